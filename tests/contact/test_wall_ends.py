"""Where the ends of two walls meet, weighted gaps have no kink: segments come to rest at the ends of their walls."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.methods.mortar_set import MortarSet
from ngcell.contact.pairing.wall_ends import ROUNDED, WallEnds
from tests.contact.stacks import Stack, blocks
from tests.tissues import contact_set

ENDS = WallEnds(np.array([[False, False], [False, True], [True, False], [True, True]]))
#: Projections on both sides of where ends begin to come to rest.
AT = np.array([0.0, 0.3, 0.7, 0.99, 1.7, 2.5]) * ROUNDED
PROJECTED = np.concatenate([AT, [0.2, 0.5, 0.9], 1 - AT[::-1]])


@pytest.mark.parametrize("edge", range(4))
def test_whole_edges_stay_whole_and_places_tell_their_projections(edge):
    edges = np.full(len(PROJECTED), edge)
    place = ENDS.places(edges, PROJECTED)
    np.testing.assert_array_equal(ENDS.places(np.array([edge, edge]), np.array([0.0, 1.0])), [0, 1])
    assert (np.diff(place) > 0).all() and np.abs(place - PROJECTED).max() <= ROUNDED
    np.testing.assert_allclose(ENDS.projected(edges, place), PROJECTED, atol=1e-10)


@pytest.mark.parametrize("edge", range(4))
def test_rates_are_the_derivatives_of_places(edge):
    inside = PROJECTED[1:-1]
    edges, step = np.full(len(inside), edge), 1e-4 * ROUNDED
    before, place, after = (ENDS.places(edges, inside + change) for change in (-step, 0.0, step))
    rate, bend = ENDS.rates(edges, place)
    np.testing.assert_allclose((after - before) / (2 * step), rate, rtol=1e-7)
    np.testing.assert_allclose((after - 2 * place + before) / step**2, rate * bend, atol=1e-3 / ROUNDED)


def weighted_gaps(stack: Stack, slide: float, lift: float) -> tuple[MortarSet, np.ndarray]:
    """Those of blocks of one width, of which the upper one has slid and is lifted."""
    at = stack.upper_moved((slide, lift))
    found = contact_set(stack.problem, stack.problem.at(at))
    return found, found.weighted_gaps(stack.positions(at))


@pytest.mark.parametrize("order", [1, 2, 3])
def test_where_two_walls_end_a_weighted_gap_has_one_slope(order):
    """It had two, by the gap there times the rate at which less is covered."""
    stack, step = blocks((0.5, 0.5), order=order), 1e-9
    (left, to_left), (here, at_rest), (right, to_right) = (weighted_gaps(stack, way, 0.01) for way in (-step, 0, step))
    functions = here.rows < stack.contact.space.size
    np.testing.assert_array_equal(left.rows, here.rows)
    np.testing.assert_array_equal(right.rows, here.rows)
    slopes = [(at_rest - to_left)[functions] / step, (to_right - at_rest)[functions] / step]
    np.testing.assert_allclose(*slopes, atol=0.01 * 0.01 / 0.5)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_walls_of_one_width_are_covered_in_whole(order):
    stack = blocks((0.5, 0.5), order=order)
    found, gaps = weighted_gaps(stack, 0.0, 0.01)
    np.testing.assert_allclose(gaps[found.rows < stack.contact.space.size], 0.01, rtol=1e-12)
