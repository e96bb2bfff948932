"""K1: two stacked blocks with matching meshes and free sides, compressed to a stretch.

The blocks are halves: their left edges lie on the plane of symmetry. Without it the stack is in balance but not
stable, as in life: frictionless blocks slide off each other under load.

A block of stretch l bears the nominal pressure P(l); a penalty k lets the walls overlap by P / k, which the blocks
are spared. All of this is solved in closed form here, so that only what the discrete contact adds is left.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
import pytest
from netgen import occ
from scipy.optimize import brentq

from ngcell.scene.bodies import Body, BodyScene, BodySupport
from tests.physics.rig import Equilibrium, Rig, rubber
from tools.references.radial import RadialSolid

KAPPA = 1000.0
SOLID = RadialSolid(0.8, 0.2, KAPPA)


@dataclass(frozen=True)
class Compressed:
    """A homogeneous block: nominal pressure and stretch across the load."""

    nominal_pressure: float
    lateral: float

    @property
    def pressure(self) -> float:
        """Cauchy pressure."""
        return self.nominal_pressure / self.lateral


def compressed(stretch: float) -> Compressed:
    lateral = brentq(lambda width: SOLID.slopes(width, stretch)[0], 0.8 / stretch, 1.2 / stretch, xtol=1e-14)
    return Compressed(-SOLID.slopes(lateral, stretch)[1], lateral)


def compressed_on_penalties(stretch: float, stiffness: float) -> Compressed:
    """Two blocks of height 1 together, with an overlap of pressure / stiffness between them."""

    def excess(own: float) -> float:
        return compressed(own).nominal_pressure - stiffness * (own - stretch)

    return compressed(brentq(excess, stretch, 1 - 1e-12, xtol=1e-15))


def block(bottom: float) -> occ.Face:
    face = occ.Rectangle(1, 0.5).Face().Move((0, bottom, 0)).faces[0]
    names = {0.0: "floor", 0.5: "lower-top" if bottom == 0 else "upper-bottom", 1.0: "ceiling"}
    for edge in face.edges:
        if abs(edge.center.x) < 1e-9:
            edge.name = "symmetry"
        elif abs(edge.center.x - 0.5) < 1e-9:
            edge.name = names[round(edge.center.y, 9)]
    return face


def pressed(stretch: float, walls: str | None = None) -> Equilibrium:
    material = rubber(KAPPA)
    scene = BodyScene(
        [Body(block(0.0), material, "lower"), Body(block(0.5), material, "upper")],
        [
            BodySupport("floor", components=(False, True)),
            BodySupport("ceiling", translation=(0.0, stretch - 1), components=(False, True)),
            BodySupport("symmetry", components=(True, False)),
        ],
        size=0.125,
        levels=(0.5, 1.0),
        accuracy=inf,
    )
    *_, final = Rig(scene, walls).accepted_steps()
    return final


def stiffness_of(state: Equilibrium) -> float:
    """Penalty stiffness for each reference length: the same all along the matching walls."""
    contact = state.contact_set
    both_passes = 2 * contact.stiffness / contact.kinematics.pairs.weight
    assert np.ptp(both_passes) < 1e-9 * both_passes.mean()
    return float(both_passes.mean())


@pytest.mark.parametrize(("stretch", "incompressible"), [(0.9, 0.424568), (0.8, 0.9225)])
def test_closed_form_has_the_listed_pressure(stretch, incompressible):
    assert stretch**-2 - stretch**2 == pytest.approx(incompressible, abs=1e-6)
    assert compressed(stretch).pressure == pytest.approx(incompressible, rel=1.0 / KAPPA)


@pytest.mark.parametrize("stretch", [0.9, 0.8])
def test_pressure_is_exact_and_uniform_where_only_the_facing_walls_may_touch(stretch):
    state = pressed(stretch, walls="lower-top|upper-bottom")
    exact = compressed_on_penalties(stretch, stiffness_of(state))
    gap, pressure = state.contact_points()
    assert np.ptp(pressure) < 1e-7 * pressure.mean()
    assert pressure.mean() == pytest.approx(exact.nominal_pressure, rel=1e-7)
    assert -gap.min() == pytest.approx(exact.nominal_pressure / stiffness_of(state), rel=1e-6)
    np.testing.assert_allclose(state.force("ceiling")[1], -exact.nominal_pressure, rtol=1e-7)


@pytest.mark.parametrize(("stretch", "incompressible"), [(0.9, 0.424568), (0.8, 0.9225)])
def test_pressure_is_right_where_flush_corners_may_touch_sideways(stretch, incompressible):
    """Corners that stand flush also lie on each other's sides: a quadrature weight there goes missing."""
    state = pressed(stretch)
    stiffness = stiffness_of(state)
    exact = compressed_on_penalties(stretch, stiffness)
    assert -state.force("ceiling")[1] == pytest.approx(exact.nominal_pressure, rel=3e-3)
    _, pressure = state.contact_points()
    inside = state.is_contact_point_in(low=(0.25, 0.45), high=(0.75, 0.55))
    assert np.ptp(pressure[inside]) < 0.06 * pressure[inside].mean()
    assert pressure[inside].mean() == pytest.approx(exact.nominal_pressure, rel=2e-2)
    spared = 2 * exact.pressure / stiffness / (1 - stretch)
    assert pressure[inside].mean() / exact.lateral == pytest.approx(incompressible, rel=spared + 2 / KAPPA)
