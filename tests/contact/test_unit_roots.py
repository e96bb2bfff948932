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
    """Polynomials that are nearly flat but for their ends: from there Newton's method alone is thrown far out."""
    rng = np.random.default_rng(3)
    root, start = rng.random((2, 500))
    flat = np.polynomial.polynomial.polypow([-1, 2], 7)  # (2 xi - 1)^7
    factors = np.tile(flat[:, None] + 0.02 * np.eye(8)[:, 1:2], (1, 500))
    factors[0] -= np.polynomial.polynomial.polyval(root, factors[:, 0])
    np.testing.assert_allclose(unit_roots(factors, start), root, atol=1e-12)


def test_roots_of_many_folds_settle():
    """At a root of order nine Newton's steps shrink by a ninth only; values are round-off within a hundredth of it."""
    factors = np.polynomial.polynomial.polypow([-0.3, 1], 9)[:, None]
    found = unit_roots(factors, np.array([1.0]))
    np.testing.assert_allclose(found, 0.3, atol=0.02)


def test_of_several_roots_one_is_found_at_which_the_polynomial_rises():
    rises = np.polynomial.polynomial.polyfromroots([0.1, 0.5, 0.8])
    start = np.linspace(0, 1, 21)
    found = unit_roots(np.tile(rises[:, None], (1, 21)), start)
    assert np.minimum(abs(found - 0.1), abs(found - 0.8)).max() < 1e-12
    np.testing.assert_allclose(found[[0, 1, 2, 3]], 0.1, atol=1e-12)
    np.testing.assert_allclose(found[[-1, -2, -3]], 0.8, atol=1e-12)


def test_polynomials_that_do_not_change_sign_end_at_an_end():
    factors = np.array([[-3.0, 3.0], [1.0, 1.0]])
    np.testing.assert_array_equal(unit_roots(factors, np.array([0.4, 0.4])), [1.0, 0.0])


def test_polynomials_that_fall_and_do_not_change_sign_end_at_an_end_to_the_last_digit():
    """Newton's method says nothing of them: halvings come near to the end. What lies beside it would be no end."""
    factors = np.array([[1.0, -0.2], [-0.5, -0.5]])
    np.testing.assert_array_equal(unit_roots(factors, np.array([0.4, 0.4])), [0.0, 1.0])


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
