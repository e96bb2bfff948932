"""Bodies that loads move: M4 and K4 with the pressure as load, and a block under a dead traction."""

from __future__ import annotations

from functools import cache
from math import inf, pi

import numpy as np
import pytest
from netgen import occ
from scipy.optimize import brentq

from ngcell.errors import GeometryError
from ngcell.run import simulate
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin, Pressure, Traction
from tests.physics.rig import Equilibrium, Rig, ring, rubber
from tests.physics.test_thick_cylinder import INNER, OUTER, incompressible_pressure, quarter
from tools.references.radial import RadialSolid, Ring, closing, inflated_radius, ring_with_free_rim

PRESSURE = incompressible_pressure(1.5)
MIRRORS = [BodySupport("along-x", components=(False, True)), BodySupport("along-y", components=(True, False))]


def tube(kappa: float, *, whole: bool, levels=(0.5, 1.0), order: int = 3) -> BodyScene:
    """M4, as a ring that nothing holds or as a quarter of it."""
    material = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=kappa)
    shape, bore = (ring(INNER, OUTER), "tube_hole0") if whole else (quarter(), "bore")
    return BodyScene(
        [Body(shape, material, "tube")],
        [] if whole else MIRRORS,
        loads=[Pressure(boundary=bore, value=PRESSURE)],
        size=0.25,
        order=order,
        levels=levels,
        accuracy=inf,
    )


def last(scene: BodyScene) -> Equilibrium:
    *_, final = Rig(scene).accepted_steps()
    return final


@cache
def inflated(kappa: float, *, whole: bool) -> Equilibrium:
    return last(tube(kappa, whole=whole))


@pytest.mark.parametrize(
    ("whole", "kappa", "listed"), [(True, 1000.0, 1.500560), (False, 100.0, 1.505637)], ids=["whole", "quarter"]
)
def test_a_pressure_inflates_the_thick_cylinder(whole, kappa, listed):
    final = inflated(kappa, whole=whole)
    exact = inflated_radius(RadialSolid(0.5, 0.5, kappa), INNER, OUTER, PRESSURE)
    assert exact == pytest.approx(listed, abs=2e-6)
    bore, rim = ("tube_hole0", "tube_outline") if whole else ("bore", "rim")
    assert final.radius(bore) == pytest.approx(exact, abs=1e-4)
    solid = RadialSolid(0.5, 0.5, kappa)
    assert final.radius(rim) == pytest.approx(ring_with_free_rim(solid, INNER, exact, OUTER).outer, abs=1e-4)


def test_the_supports_of_the_quarter_bear_the_pressure():
    """Also at the ends of the loaded line, which slide along them."""
    final = inflated(100.0, whole=False)
    exact = inflated_radius(RadialSolid(0.5, 0.5, 100.0), INNER, OUTER, PRESSURE)
    np.testing.assert_allclose(final.force("along-y"), (-PRESSURE * exact, 0), atol=1e-4)
    np.testing.assert_allclose(final.force("along-x"), (0, -PRESSURE * exact), atol=1e-4)


def test_the_reported_energy_is_what_the_pressure_has_stored():
    """The work of the pressure on the area of the bore, in closed form; the potential is no part of it."""
    solid = RadialSolid(0.5, 0.5, 100.0)
    scene = tube(100.0, whole=True)
    for step in simulate(scene):
        end = inflated_radius(solid, INNER, OUTER, step.record.load_factor * PRESSURE)
        nodes, weights = np.polynomial.legendre.leggauss(8)
        half = (end - INNER) / 2
        radii = INNER + half * (1 + nodes)
        rates = [ring_with_free_rim(solid, INNER, a, OUTER).inner_pressure * 2 * pi * a for a in radii]
        assert step.record.energy == pytest.approx(half * (weights @ rates), rel=2e-4)


def test_steps_between_levels_leave_no_trace():
    one, two = (last(tube(100.0, whole=False, levels=levels, order=2)) for levels in ((1.0,), 4))
    np.testing.assert_allclose(one.displacement, two.displacement, atol=1e-7)


@pytest.mark.parametrize("pressure", [0.3, 0.6])
def test_a_pressure_closes_the_gap_of_two_rings(pressure):
    """K4, before and after the rings touch; neither is held."""
    kappa = 100.0
    solid = RadialSolid(0.8, 0.2, kappa)
    exact = closing(Ring(solid, 0.5, 1.0), Ring(solid, 1.1, 1.6), pressure)
    scene = BodyScene(
        [Body(ring(0.5, 1.0), rubber(kappa), "inner"), Body(ring(1.1, 1.6), rubber(kappa), "outer")],
        loads=[Pressure(boundary="inner_hole0", value=pressure)],
        size=0.25,
        order=3,
        levels=1,
        accuracy=inf,
    )
    final = last(scene)
    assert final.radius("inner_hole0") == pytest.approx(exact.inside.inner, rel=3e-3)
    assert final.radius("inner_outline") == pytest.approx(exact.inside.outer, rel=3e-3)
    assert final.radius("outer_outline") == pytest.approx(exact.outside.outer, rel=3e-3)


@pytest.mark.parametrize("traction", [0.4, -0.3])
@pytest.mark.parametrize("kappa", [100.0, 5.0])
def test_a_dead_traction_stretches_a_block_uniaxially(traction, kappa):
    """Nominal traction and stretch of a homogeneous block in plane strain with free sides."""
    solid = RadialSolid(0.8, 0.2, kappa)

    def lateral(stretch: float) -> float:
        return brentq(lambda width: solid.slopes(width, stretch)[0], 0.5 / stretch, 2 / stretch, xtol=1e-14)

    stretch = brentq(lambda own: solid.slopes(lateral(own), own)[1] - traction, 0.7, 1.5, xtol=1e-14)
    face = occ.Rectangle(1, 0.5).Face().faces[0]
    face.edges.Min(occ.X).name, face.edges.Max(occ.X).name, face.edges.Min(occ.Y).name = "left", "right", "floor"
    scene = BodyScene(
        [Body(face, rubber(kappa), "block")],
        [BodySupport("left", components=(True, False)), BodySupport("floor", components=(False, True))],
        loads=[Traction(boundary="right", vector=(traction, 0.0))],
        size=0.25,
        levels=2,
        accuracy=inf,
    )
    final = last(scene)
    at = final.vertices("block_outline")
    assert final.vertices("right")[:, 0] == pytest.approx(stretch, abs=1e-7)
    assert at[:, 1].max() == pytest.approx(0.5 * lateral(stretch), abs=1e-7)
    assert final.force("left") == pytest.approx((-0.5 * traction, 0), abs=1e-7)


def test_a_load_on_an_unknown_boundary_is_refused():
    scene = BodyScene(
        [Body(ring(0.5, 1.0), rubber(10.0), "tube")],
        loads=[Traction(boundary="tube_hole", vector=(1.0, 0.0))],
        accuracy=inf,
    )
    with pytest.raises(GeometryError, match=r"load tube_hole: no such boundary \(did you mean tube_hole0\?\); allowed"):
        simulate(scene)
