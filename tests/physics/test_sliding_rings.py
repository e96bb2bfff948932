"""A ring is held past another one: curved walls with meshes that do not match, pressed and sliding."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from ngcell.results.outline_overlap import deepest_overlap
from ngcell.scene.bodies import Body, BodyScene, BodySupport
from tests.physics.rig import Equilibrium, Rig, ring, rubber

LEVELS = (0.15, 0.3, 0.5, 0.7, 0.85)


@pytest.fixture(scope="module")
def passage() -> list[Equilibrium]:
    """Both bores are held; one ring is moved past the other, along it, from one side to the other."""
    moved = ring(0.3, 0.5, (-0.43, 0.9)).faces[0]
    moved.maxh = 0.08
    scene = BodyScene(
        [Body(ring(0.3, 0.5), rubber(100.0), "still"), Body(moved, rubber(100.0), "moved")],
        [BodySupport("still_hole0"), BodySupport("moved_hole0", translation=(0.86, 0.0))],
        size=0.1,
        levels=LEVELS,
        accuracy=inf,
    )
    return list(Rig(scene).accepted_steps())


def test_reactions_balance_the_contact_forces(passage):
    assert tuple(state.load_factor for state in passage) == LEVELS
    for state in passage:
        on_still, on_moved = state.contact_forces.on_body
        size = np.linalg.norm(on_still)
        assert np.linalg.norm(on_still + on_moved) < 1e-12 * size
        assert np.linalg.norm(state.force("still_hole0") + on_still) < 1e-6 * size
        assert np.linalg.norm(state.force("moved_hole0") + on_moved) < 1e-6 * size


def test_walls_overlap_by_no_more_than_the_penalty_lets_them(passage):
    """The peak of the pressure is at most thrice its mean, and polygons, six chords an edge, tell the same depth."""
    sagitta = (0.1 / 6) ** 2 / (8 * 0.5)
    for state in passage:
        contact, walls = state.contact_set, state.rig.walls
        gap, _ = state.contact_points()
        closed = gap < 0
        length = contact.kinematics.pairs.weight[closed].sum() / 2
        stiffness = (2 * contact.stiffness / contact.kinematics.pairs.weight)[closed].min()
        mean_pressure = np.linalg.norm(state.contact_forces.on_body[0]) / length
        assert -gap.min() < 3 * mean_pressure / stiffness
        assert deepest_overlap(walls, walls.nodes(state.positions)) == pytest.approx(-gap.min(), rel=0.1, abs=sagitta)
        assert -gap.min() < 0.05 * state.rig.bodies.thickness


def test_without_friction_the_way_out_mirrors_the_way_in(passage):
    before, early, middle, late, after = (state.contact_forces.on_body[0] for state in passage)
    for way_in, way_out in ((before, after), (early, late)):
        np.testing.assert_allclose(way_out * (-1, 1), way_in, rtol=0.03)
    assert abs(middle[0]) < 0.01 * abs(middle[1])


def test_energy_does_not_jump_where_points_slide_from_edge_to_edge(passage):
    """Rigid sliding in small steps: with half the step, the largest change is about half as large."""
    rig = passage[0].rig
    second = rig.space.one * (rig.space.body_of_unknown == 1)

    def energy(along: float) -> float:
        moved = np.array([0.4 + along, 0.08])[:, None] * second
        return rig.problem.at(moved.ravel()).energy

    energies = np.array([energy(along) for along in np.linspace(0.0, 0.1, 401)])
    assert energies.min() > 0
    coarse, fine = (np.abs(np.diff(energies[::every])).max() for every in (2, 1))
    assert fine < 0.6 * coarse
