"""M4: a thick cylinder whose inner radius is driven from 1 to 1.5, its rim free."""

from __future__ import annotations

from math import inf, log, pi, sqrt

import pytest
from netgen import occ

from ngcell.scene import MooneyRivlin
from ngcell.scene.bodies import Body, BodyScene, BodySupport
from tests.physics.rig import Rig, ring, swelling
from tools.references.radial import RadialSolid, inflated_radius, ring_with_free_rim

INNER, OUTER, FINAL = 1.0, 2.0, 1.5


def incompressible_pressure(radius: float) -> float:
    """Inner pressure over shear modulus: f(a/A, b/B)."""

    def f(inner: float, outer: float) -> float:
        return log(inner / outer) + 0.5 * (outer**-2 - inner**-2)

    return f(radius / INNER, sqrt(OUTER**2 + radius**2 - INNER**2) / OUTER)


def quarter() -> occ.Face:
    """The quarter with x, y > 0."""
    face = (ring(INNER, OUTER) * occ.Rectangle(OUTER, OUTER).Face()).faces[0]
    for edge in face.edges:
        at = edge.center
        if abs(at.y) < 1e-9:
            edge.name = "along-x"
        elif abs(at.x) < 1e-9:
            edge.name = "along-y"
        else:
            edge.name = "bore" if at.x**2 + at.y**2 < 1 else "rim"
    return face


def driven_cylinder(kappa: float, order: int, size: float) -> tuple[float, float]:
    """Pressure in the bore, from the work of the support, and radius of the rim."""
    tube = Body(quarter(), MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=kappa), "tube")
    mirrors = [
        BodySupport("along-x", components=(False, True)),
        BodySupport("along-y", components=(True, False)),
    ]
    scene = BodyScene(
        [tube], [*mirrors, swelling("bore", FINAL, INNER)], size=size, order=order, levels=(0.5, 1.0), accuracy=inf
    )
    *_, final = Rig(scene).accepted_steps()
    return final.work_rate / (pi / 2 * FINAL * (FINAL - INNER)), final.radius("rim")


def test_radial_solution_has_the_listed_numbers():
    """Incompressible limit in closed form; radii at that pressure as listed for c1 = c2."""
    pressure = incompressible_pressure(FINAL)
    assert pressure == pytest.approx(0.428228, abs=5e-7)
    stiff = ring_with_free_rim(RadialSolid(0.5, 0.5, 1e6), INNER, FINAL, OUTER)
    assert stiff.inner_pressure == pytest.approx(pressure, rel=1e-5)
    assert stiff.outer == pytest.approx(sqrt(OUTER**2 + FINAL**2 - INNER**2), rel=1e-5)
    for kappa, radius in ((1000.0, 1.500560), (100.0, 1.505637)):
        solid = RadialSolid(0.5, 0.5, kappa)
        assert inflated_radius(solid, INNER, OUTER, pressure) == pytest.approx(radius, abs=2e-6)


@pytest.mark.parametrize("kappa", [1000.0, 100.0])
def test_driven_cylinder_bears_the_radial_solution(kappa):
    exact = ring_with_free_rim(RadialSolid(0.5, 0.5, kappa), INNER, FINAL, OUTER)
    pressure, rim = driven_cylinder(kappa, order=3, size=0.25)
    assert pressure == pytest.approx(exact.inner_pressure, rel=3e-5)
    assert rim == pytest.approx(exact.outer, abs=2e-5)
    assert pressure == pytest.approx(incompressible_pressure(FINAL), rel=0.8 / kappa)


def test_error_falls_with_size_and_order():
    exact = ring_with_free_rim(RadialSolid(0.5, 0.5, 100.0), INNER, FINAL, OUTER).inner_pressure
    coarse, fine = (abs(driven_cylinder(100.0, 2, size)[0] / exact - 1) for size in (0.25, 0.125))
    cubic = abs(driven_cylinder(100.0, 3, 0.125)[0] / exact - 1)
    assert fine < coarse / 8
    assert cubic < 1e-6
