"""ContactPairs against plain geometry: who is inside whom, who has slid past, who answers to two neighbours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import Point, Polygon

from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.pairing.closest import classified
from ngcell.contact.pairing.facing import find_facing
from ngcell.contact.surface.find import find_surface
from ngcell.contact.surface.surface import Surface
from tests.tissues import SmallTissue, rotation, small_tissue


def contact_between(walls: Surface) -> PenaltyContact:
    return PenaltyContact(walls, np.ones(walls.facet_count), reach=0.3)


def depth_inside(tissue: SmallTissue, point: np.ndarray, centre: np.ndarray, angle: float) -> np.ndarray:
    """How deep points lie inside an undistorted cell, negative outside (then not a distance)."""
    normals = tissue.lattice.normals @ rotation(angle).T
    return tissue.lattice.apothem - np.max((point - centre) @ normals.T, axis=1)


TRANSLATIONS = [(-0.1, 0.0), (-0.1, 0.35), (-0.2, 0.8), (-0.2, -0.9), (0.02, 0.3), (-0.3, 1.0), (0.0, 0.5)]


@pytest.mark.parametrize("angle", [0.0, 0.3])
@pytest.mark.parametrize("translation", TRANSLATIONS)
def test_walls_overlap_exactly_where_their_points_lie_inside_the_other_cell(translation, angle):
    tissue = small_tissue(1, 2, edges=7)
    walls, centres = tissue.walls, tissue.lattice.centres.copy()
    turned = tissue.space.affine(rotation(angle) - np.eye(2), centres[1] - rotation(angle) @ centres[1])
    member = tissue.space.body_of_unknown == 1
    displacement = tissue.body_translation(1, np.array(translation)) + (turned * member).ravel()
    centres[1] += translation
    positions = tissue.positions(displacement)
    kinematics = contact_between(walls).pair(positions).kinematics
    gap, pairs = kinematics.gaps(positions), kinematics.pairs
    overlap = np.zeros((walls.facet_count, len(walls.quadrature_points)))
    overlap[pairs.primary, np.searchsorted(walls.quadrature_points, pairs.primary_xi - 1e-9)] = np.maximum(-gap, 0)
    point = walls.quadrature_values @ walls.nodes(positions)
    expected = np.zeros_like(overlap)
    for body, other, turn in ((0, 1, angle), (1, 0, 0.0)):
        mine = walls.body == body
        depth = depth_inside(tissue, point[mine].reshape(-1, 2), centres[other], turn)
        expected[mine] = np.maximum(depth, 0).reshape(expected[mine].shape)
    assert expected.max() > 0 or translation[0] >= 0
    np.testing.assert_allclose(overlap, expected, atol=1e-12)


def test_a_point_that_slid_past_the_end_of_an_outline_is_without_force():
    base = small_tissue(1, 2, edges=5)
    right = np.argmax(base.lattice.normals[:, 0])
    facing = np.zeros((2, 6), dtype=bool)
    facing[0, right] = facing[1, (right + 3) % 6] = True
    tissue = small_tissue(1, 2, edges=5, supports={"between": facing})
    bodies = replace(tissue.bodies, wall_names="between")  # the walls end at the corners
    walls = find_surface(bodies, tissue.space.scalar, tissue.space.rest)
    positions = tissue.positions(tissue.body_translation(1, np.array([-0.05, 0.4])))
    contact = contact_between(walls).pair(positions)
    gap, pairs = contact.kinematics.gaps(positions), contact.kinematics.pairs
    y = walls.places(pairs.primary, pairs.primary_xi, walls.nodes(positions))[:, 1]
    both = (y > -0.1) & (y < 0.5)
    np.testing.assert_allclose(gap[both], -0.05, atol=1e-12)
    # No further aside than deep, a contact force acts on the end itself; beyond that there is none.
    assert (gap[(y < -0.1 - 0.051) | (y > 0.5 + 0.051)] >= 0).all()


@pytest.mark.parametrize("order", [1, 2])
def test_points_where_three_bodies_meet_answer_to_both_neighbours(order):
    tissue = small_tissue(2, 2, order=order)
    walls = tissue.walls
    pairs = contact_between(walls).pair(tissue.space.rest).kinematics.pairs
    point = walls.places(pairs.primary, pairs.primary_xi, walls.rest)
    corners = (tissue.lattice.centres[:, None] + tissue.lattice.corners).reshape(-1, 2)
    place, count = np.unique(np.round(corners, 9), axis=0, return_counts=True)
    assert (count == 3).sum() == 2
    for corner in place[count == 3]:
        meeting = np.flatnonzero(np.linalg.norm(corners - corner, axis=1) < 1e-6) // 6
        near = np.linalg.norm(point - corner, axis=1) < 0.05
        for body in meeting:
            mine = near & (walls.body[pairs.primary] == body)
            seen = np.column_stack([pairs.primary, pairs.primary_xi])[mine]
            points, pair_count = np.unique(seen, axis=0, return_counts=True)
            assert len(points) and (pair_count == 2).all()
            assert set(walls.body[pairs.secondary[mine]]) == set(meeting) - {body}


@pytest.mark.parametrize("order", [2, 4, 6])
def test_small_walls_far_from_the_origin_meet_as_they_do_near_it(order):
    """Coordinates of 16 have a round-off of 2e-15: gaps have no more than some times that, and a foot stays a foot."""
    tissue = small_tissue(1, 2, edges=5, order=order)
    displacement = tissue.smooth(0.02, 1) + tissue.body_translation(1, np.array([-0.02, 0.1]))
    contact = contact_between(tissue.walls)
    near = 0.02 * tissue.positions(displacement)
    far = near + tissue.space.affine(np.zeros((2, 2)), np.array([16.0, -16.0]))
    here, there = contact.pair(near), contact.pair(far)
    _, mine, theirs = np.intersect1d(here.keys, there.keys, return_indices=True)
    gap = here.gaps(near)[mine]
    assert len(mine) > 50 and (np.abs(gap) < 1e-3).sum() > 20
    np.testing.assert_allclose(there.gaps(far)[theirs], gap, rtol=0, atol=3e-14)
    pairs, moved = here.kinematics.pairs, there.kinematics.pairs
    np.testing.assert_array_equal(moved.at_end[theirs], pairs.at_end[mine])
    np.testing.assert_array_equal(moved.sign[theirs], pairs.sign[mine])


@pytest.mark.parametrize(("xi", "at_end"), [(0.4, False), (0.0, True), (1.0, True)])
def test_between_the_ends_of_an_edge_a_foot_that_is_off_by_round_off_stays_one(xi, at_end):
    walls = small_tissue(1, 2).walls
    facet, off = np.array([0]), 1e-8
    along = (walls.rest[0, -1] - walls.rest[0, 0])[None]
    point = walls.places(facet, np.array([xi]), walls.rest) + off * along
    found = classified(walls, walls.rest, facet, np.array([xi]), point)
    assert found.at_end.tolist() == [at_end]


def test_contact_pairs_do_not_depend_on_what_was_searched_before():
    tissue = small_tissue(2, 2)
    used = contact_between(tissue.walls)
    for seed in range(4):
        positions = tissue.positions(tissue.smooth(0.1 * seed, seed))
        seen, fresh = used.pair(positions), contact_between(tissue.walls).pair(positions)
        assert seen.energy(positions) == fresh.energy(positions)
        np.testing.assert_array_equal(seen.kinematics.pairs.secondary, fresh.kinematics.pairs.secondary)


def test_couplings_hold_all_penalty_terms_while_nothing_moves_by_more_than_half_of_the_margin():
    tissue = small_tissue(2, 2)
    contact, size = contact_between(tissue.walls), tissue.space.size
    row, column = contact.couplings(tissue.space.rest, 0.2)
    known = set(zip(row.tolist(), column.tolist(), strict=True))
    random = np.random.default_rng(1)
    moved = tissue.space.rest + 0.1 * random.uniform(-1, 1, (2, 1)) * (tissue.space.body_of_unknown == 2)
    kinematics = contact.pair(moved * 1.0).kinematics
    width = kinematics.dofs.shape[1]
    needed = zip(
        np.repeat(kinematics.dofs, width, axis=1).ravel().tolist(),
        np.tile(kinematics.dofs, (1, width)).ravel().tolist(),
        strict=True,
    )
    assert set(needed) <= known
    assert len(known) < size**2


def test_facing_gaps_follow_the_walls_wherever_they_slide():
    tissue = small_tissue(1, 2, edges=4)
    facing = find_facing(tissue.walls, 1e-3)
    assert facing.pairs.tolist() == [[0, 1]]
    positions = tissue.positions(tissue.body_translation(1, np.array([2.0, 0.0])))
    gaps = facing.gaps(tissue.walls, tissue.walls.nodes(positions))
    np.testing.assert_allclose(gaps, 2.0, atol=1e-12)  # far beyond the reach of contact
    positions = tissue.positions(tissue.body_translation(1, np.array([0.5, 3.0])))
    gaps = facing.gaps(tissue.walls, tissue.walls.nodes(positions))
    point = tissue.walls.places(facing.facet, facing.xi, tissue.walls.nodes(positions))
    centres = tissue.lattice.centres + [[0, 0], [0.5, 3.0]]
    outlines = [Polygon(centre + tissue.lattice.corners) for centre in centres]
    expected = [outlines[other].distance(Point(at)) for other, at in zip(facing.other, point, strict=True)]
    np.testing.assert_allclose(gaps, expected, rtol=1e-12)


@pytest.mark.parametrize("scale", [1.0, 1e6, 1e-3])
def test_a_straight_joint_does_not_turn(scale):
    """To round-off, whatever the unit of length: what follows from a exterior angle would depend on it."""
    walls = small_tissue(1, 2).walls
    exterior_angle = walls.exterior_angle_at(scale * walls.rest)
    straight = np.abs(exterior_angle) < 1e-3
    assert straight.any()
    assert np.abs(exterior_angle[straight]).max() < 1e-14
    np.testing.assert_allclose(exterior_angle[~straight], np.pi / 3, rtol=1e-12)
