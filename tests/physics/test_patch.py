"""K1 with meshes that do not match: the patch test of the mortar method.

Blocks that may widen freely stand flush at their right ends: only the walls between them may touch, for a corner that
slides past a corner leaves a kink in the energy, in which Newton's method cycles. Blocks between slippery walls are
kept from widening.
"""

from __future__ import annotations

from functools import partialmethod
from math import inf

import numpy as np
import pytest
from netgen import occ

from ngcell.contact.options import ContactOptions
from ngcell.scene import Mortar
from ngcell.scene.bodies import Body, BodyScene, BodySupport
from tests.physics.rig import Equilibrium, Rig, rubber
from tests.physics.test_stacked_blocks import KAPPA, compressed
from tests.tissues import contact_term
from tools.references.radial import RadialSolid

#: Compressible enough to be compressed without widening.
SPONGE = 5.0
STRETCH = 0.8


def block(bottom: float, size: float) -> occ.Face:
    face = occ.MoveTo(0, bottom).Rectangle(1, 1).Face().faces[0]
    face.edges.Min(occ.Y).name = "floor" if bottom == 0 else "upper-bottom"
    face.edges.Max(occ.Y).name = "ceiling" if bottom == 1 else "lower-top"
    face.edges.Min(occ.X).name, face.edges.Max(occ.X).name = "left", "right"
    face.maxh = size
    return face


def pressed(stretch: float, sizes: tuple[float, float], order: int, *, confined: bool) -> Equilibrium:
    material = rubber(SPONGE if confined else KAPPA)
    sides = ["left", "right"] if confined else ["left"]
    scene = BodyScene(
        [Body(block(0, sizes[0]), material, "lower"), Body(block(1, sizes[1]), material, "upper")],
        [
            BodySupport("floor", components=(False, True)),
            BodySupport("ceiling", translation=(0.0, 2 * (stretch - 1)), components=(False, True)),
            *(BodySupport(name, components=(True, False)) for name in sides),
        ],
        size=max(sizes),
        order=order,
        levels=2 if confined else 1,
        contact=Mortar(),
        accuracy=inf,
    )
    *_, final = Rig(scene, walls="lower-top|upper-bottom").accepted_steps()
    return final


def multipliers(state: Equilibrium) -> np.ndarray:
    """Pressures of the functions that are pressed, and those of point constraints that press."""
    contact = state.contact_set
    pressure = contact.pressures(state.positions)
    along = contact.rows < contact_term(state.rig.problem).method.space.size
    assert (pressure[~along] == 0).all()
    return pressure[along]


def assert_uniform(state: Equilibrium, pressure: float) -> None:
    found = multipliers(state)
    assert len(found) > 4 and np.ptp(found) < 1e-8 * pressure
    assert found.mean() == pytest.approx(pressure, rel=1e-8)
    assert -state.force("ceiling")[1] == pytest.approx(pressure, rel=1e-8)


@pytest.mark.parametrize(
    ("sizes", "order"), [((0.4, 0.27), 1), ((0.4, 0.27), 4), ((0.2, 0.3), 2)]
)
def test_confined_blocks_press_uniformly(sizes, order):
    exact = -RadialSolid(0.8, 0.2, SPONGE).slopes(1.0, STRETCH)[1]
    assert_uniform(pressed(STRETCH, sizes, order, confined=True), exact)


@pytest.mark.parametrize(
    ("sizes", "order"), [((0.4, 0.27), 1), ((0.4, 0.27), 3), ((0.22, 0.3), 2)]
)
def test_k1_blocks_with_free_sides_press_uniformly(sizes, order):
    assert_uniform(pressed(STRETCH, sizes, order, confined=False), compressed(STRETCH).nominal_pressure)


@pytest.mark.parametrize("multiple", [10.0, 100.0])
def test_the_stiffness_of_the_penalty_terms_leaves_no_trace(multiple, monkeypatch):
    stiffer = partialmethod(Mortar.stages, options=ContactOptions(mortar_multiple=multiple))
    monkeypatch.setattr(Mortar, "stages", stiffer)
    exact = -RadialSolid(0.8, 0.2, SPONGE).slopes(1.0, STRETCH)[1]
    assert_uniform(pressed(STRETCH, (0.4, 0.27), 2, confined=True), exact)
