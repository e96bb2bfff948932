"""Projections settle, however sharply edges bend: closest points are closest, and gaps have the derivatives that are
told."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.pairing.closest_on_edges import closest_points
from ngcell.contact.pairing.unit_roots import unit_roots
from tests.tissues import small_tissue


def test_roots_are_found_from_anywhere():
    rng = np.random.default_rng(3)
    root, start = rng.random((2, 500))

    def function(chosen, at):
        away = at - root[chosen]
        return np.arctan(20 * away), 20 / (1 + 400 * away**2)  # from far away Newton's method alone is thrown out

    np.testing.assert_allclose(unit_roots(function, start), root, atol=1e-12)


def test_steps_that_overshoot_are_halved():
    """Rates of a tenth of what they are: Newton's method alone goes to and fro between both ends."""
    root = np.linspace(0.05, 0.95, 19)
    found = unit_roots(lambda chosen, at: (at - root[chosen], np.full(len(at), 0.1)), np.full(19, 0.5))
    np.testing.assert_allclose(found, root, atol=1e-12)


def test_functions_that_do_not_change_sign_end_at_an_end():
    offset = np.array([-3.0, 3.0])
    found = unit_roots(lambda chosen, at: (at + offset[chosen], np.ones(len(at))), np.array([0.4, 0.4]))
    np.testing.assert_array_equal(found, [1.0, 0.0])


def bent_tissue(order: int = 4):
    """Two cells whose walls bend by far more than their thickness from corner to corner."""
    tissue = small_tissue(1, 2, order=order, edges=2)
    return tissue, tissue.body_translation(1, np.array([-0.05, 0.1])) + tissue.smooth(0.25, 5)


def test_closest_points_on_sharply_bent_edges_are_stationary():
    tissue, displacement = bent_tissue()
    walls = tissue.walls
    nodes = walls.nodes(tissue.positions(displacement))
    rng = np.random.default_rng(1)
    facet = rng.integers(walls.facet_count, size=4000)
    start = walls.places(facet, rng.random(4000), nodes)
    point = start + 0.3 * rng.normal(size=(4000, 2))
    xi, distance = closest_points(walls, nodes, facet, point)
    place, slope = (np.einsum("pi,pid->pd", walls.basis.values(xi, degree), nodes[facet]) for degree in (0, 1))
    along = np.einsum("pd,pd->p", point - place, slope) / np.einsum("pd,pd->p", slope, slope)
    is_end = ((xi == 1) & (along > 0)) | ((xi == 0) & (along < 0))
    np.testing.assert_allclose(np.where(is_end, 0, along), 0, atol=1e-11)
    assert (~is_end).mean() > 0.3
    np.testing.assert_allclose(distance, np.linalg.norm(point - place, axis=1), rtol=1e-14)


def test_gaps_of_sharply_bent_walls_have_the_derivatives_that_are_told():
    tissue, displacement = bent_tissue()
    contact = PenaltyContact(tissue.walls, np.ones(tissue.walls.facet_count), reach=0.3)
    way, step = tissue.smooth(1.0, 8), 1e-7
    found = contact.pair(tissue.positions(displacement))
    after, before = (tissue.positions(displacement + sign * step * way) for sign in (1, -1))
    change = (contact.pair(after).energy(after) - contact.pair(before).energy(before)) / (2 * step)
    gap, jacobian, stiffness = found.penalty_terms(tissue.positions(displacement))
    assert (gap < 0).sum() > 10
    assert change == pytest.approx((stiffness * np.minimum(gap, 0)) @ (jacobian @ way), rel=1e-6)
