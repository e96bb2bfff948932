"""Segments cover the part of a wall that faces another body, once, whatever the two meshes."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.options import DEFAULT_OPTIONS
from ngcell.contact.pairing.near import NearFacets
from ngcell.contact.pairing.segments import Segments, find_segments, segment_pairs
from tests.contact.stacks import REACH, Stack, blocks, rings
from tests.tissues import rotation

ORDERS = [1, 2, 3, 4]
MATCHING, FINER_BELOW, FINER_ABOVE = (0.25, 0.25), (0.11, 0.3), (0.4, 0.13)


def segments_of(stack: Stack, displacement: np.ndarray, primary: int) -> tuple[Segments, np.ndarray]:
    """The segments on the walls of one body, and the deformed nodes."""
    walls = stack.walls
    nodes = walls.nodes(stack.positions(displacement))
    edge, other = NearFacets(walls, REACH).pairs(nodes)
    mine = walls.body[edge] == primary
    return find_segments(walls, nodes, edge[mine], other[mine]), nodes


def facing_length(stack: Stack, displacement: np.ndarray, primary: int) -> float:
    """Length at rest of all that faces the other body within reach: the sum of all quadrature weights."""
    segments, nodes = segments_of(stack, displacement, primary)
    points, _ = segment_pairs(stack.walls, nodes, segments, REACH)
    return float(points.weight.sum())


def uncovered(segments: Segments, edge: int) -> tuple[float, float]:
    """Share of an edge that no segment covers, and share that several do."""
    intervals = np.sort(segments.at[segments.primary == edge], axis=1)
    intervals = intervals[np.argsort(intervals[:, 0])]
    start, end = np.append(intervals[:, 0], 1.0), np.insert(np.maximum.accumulate(intervals[:, 1]), 0, 0.0)
    return float(np.maximum(start - end, 0).sum()), float(np.maximum(end - start, 0)[:-1].sum())


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("sizes", [MATCHING, FINER_BELOW, FINER_ABOVE])
@pytest.mark.parametrize("primary", [0, 1])
@pytest.mark.parametrize("slide", [0.0, 1e-7, 0.03, -0.1, 0.37, 1.0, -1.2])
def test_weights_add_up_to_the_length_that_faces(order, sizes, primary, slide):
    stack = blocks(sizes, order=order)
    at = stack.upper_moved((slide, 0.001))
    assert facing_length(stack, at, primary) == pytest.approx(max(0.0, 1 - abs(slide)), abs=1e-12)


@pytest.mark.parametrize("primary", [0, 1])
@pytest.mark.parametrize("slide", [0.0, 0.2])
def test_a_narrow_block_is_faced_by_its_width(primary, slide):
    stack = blocks(FINER_BELOW, width=0.55, order=3)
    assert facing_length(stack, stack.upper_moved((slide, -0.01)), primary) == pytest.approx(0.55, abs=1e-12)


@pytest.mark.parametrize("sizes", [FINER_BELOW, FINER_ABOVE])
@pytest.mark.parametrize("slide", [0.0, 0.07, 0.3])
def test_segments_lie_side_by_side(sizes, slide):
    stack = blocks(sizes)
    segments, nodes = segments_of(stack, stack.upper_moved((slide, 0.0)), primary=0)
    assert ((segments.at >= 0) & (segments.at <= 1)).all()
    for edge in np.unique(segments.primary):
        gap, twice = uncovered(segments, edge)
        right = nodes[edge, [0, -1], 0]
        behind = np.clip((slide - 0.5 - right.min()) / np.ptp(right), 0, 1)  # what the upper block has left behind
        assert gap == pytest.approx(behind, abs=1e-12)
        assert twice < 1e-12


@pytest.mark.parametrize("order", ORDERS)
def test_shapes_of_both_sides_are_smooth_on_a_segment(order):
    """All feet of a segment's points lie on its other edge, and the ends of segments are projections of vertices."""
    stack = blocks(FINER_ABOVE, order=order)
    segments, nodes = segments_of(stack, stack.upper_moved((0.07, -0.01)), primary=0)
    points, ends = segment_pairs(stack.walls, nodes, segments, REACH)
    cuts = ends.cuts
    assert ((points.secondary_xi > 0) & (points.secondary_xi < 1)).all()
    assert set(cuts.secondary_xi) <= {0.0, 1.0}
    foot = stack.walls.places(cuts.secondary, cuts.secondary_xi, nodes)
    place = stack.walls.places(cuts.primary, cuts.primary_xi, nodes)
    np.testing.assert_allclose(place[:, 0], foot[:, 0], atol=1e-12)


def test_cuts_say_how_fast_the_facing_length_grows():
    stack = blocks(FINER_ABOVE)
    for slide, rate in ((0.21, -1.0), (-0.21, 1.0)):
        segments, nodes = segments_of(stack, stack.upper_moved((slide, 0.0)), primary=0)
        cuts = segment_pairs(stack.walls, nodes, segments, REACH)[1].cuts
        along = nodes[cuts.primary, -1, 0] - nodes[cuts.primary, 0, 0]
        assert (cuts.weight / along).sum() == pytest.approx(rate, abs=1e-12)


@pytest.mark.parametrize("primary", [0, 1])
@pytest.mark.parametrize(("order", "missed"), [(1, 1e-3), (2, 2e-7), (3, 2e-7), (4, 1e-9)])
@pytest.mark.parametrize("aside", [0.0, 0.005])
def test_rings_are_faced_all_round(primary, order, missed, aside):
    """Where edges of different meshes stand for the same circle, up to what the joints turn by."""
    stack = rings((0.3, 0.17), order=order)
    length = stack.walls.weights[stack.walls.body == primary]
    radius = np.linalg.norm(stack.walls.rest[stack.walls.body == primary, 0], axis=1)
    facing = length[np.abs(radius - 1) < 1e-9].sum()
    assert facing_length(stack, stack.upper_moved((aside, 0.0)), primary) == pytest.approx(facing, rel=missed)


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.0, 3.0])
def test_walls_that_do_not_face_have_no_segments(angle):
    stack = blocks(FINER_BELOW)
    turn = stack.space.affine(rotation(angle) - np.eye(2), np.zeros(2)).ravel()
    segments, nodes = segments_of(stack, turn, primary=0)
    normal = stack.walls.chord_normals(nodes)
    assert (np.einsum("sd,sd->s", normal[segments.primary], normal[segments.secondary]) < DEFAULT_OPTIONS.facing).all()
    # At rest the lower block's top faces the upper block's bottom; sides stand flush and face nothing.
    rest = stack.walls.rest[segments.primary]
    assert len(rest) and np.abs(rest[..., 1] - 0.5).max() < 1e-12


def test_walls_out_of_reach_have_no_points():
    stack = blocks(FINER_BELOW)
    at = stack.upper_moved((0.0, 1.01 * REACH))
    segments, nodes = segments_of(stack, at, primary=0)
    assert len(segments.primary)
    points, ends = segment_pairs(stack.walls, nodes, segments, REACH)
    assert len(points) == len(ends.cuts) == 0
