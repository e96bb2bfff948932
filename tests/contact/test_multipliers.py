"""The functions that the contact pressure is made of."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.methods.multipliers import SHARP, MultiplierSpace, constrained_points, sagitta
from tests.contact.stacks import rings
from tests.tissues import SmallTissue, small_tissue

ORDERS = [1, 2, 3, 4]
ALONG = np.linspace(0, 1, 21)


def pressure(space: MultiplierSpace, coefficients: np.ndarray, edge: np.ndarray, xi: np.ndarray) -> np.ndarray:
    """A pressure at points of edges."""
    return (space.values(xi) * coefficients[space.row[edge]]).sum(-1)


@pytest.mark.parametrize("order", ORDERS)
def test_functions_are_positive_and_add_up_to_one(order):
    space = MultiplierSpace(small_tissue(1, 1, order=order).walls)
    values = space.values(ALONG)
    assert (values >= 0).all()
    np.testing.assert_allclose(values.sum(1), 1, atol=1e-14)


@pytest.mark.parametrize(("order", "degree"), [(1, 1), (2, 1), (3, 2), (4, 3)])
def test_an_edge_holds_all_polynomials_of_its_degree_and_no_more(order, degree):
    space = MultiplierSpace(small_tissue(1, 1, order=order).walls)
    assert space.degree == degree
    values = space.values(ALONG)
    for power in range(degree + 2):
        _, misfit, *_ = np.linalg.lstsq(values, ALONG**power, rcond=None)
        assert (misfit.sum() < 1e-20) == (power <= degree)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("radius", [0.0, 0.2])
def test_integrals_add_up_to_the_length_of_the_walls(order, radius):
    tissue = small_tissue(1, 2, order=order, radius=radius, edges=3)
    space = MultiplierSpace(tissue.walls)
    assert (space.weight > 0).all()
    assert space.weight.sum() == pytest.approx(tissue.walls.weights.sum(), rel=1e-14)
    if radius == 0:
        assert space.weight.sum() == pytest.approx(12, rel=1e-12)


def joints(tissue: SmallTissue) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The two edge ends at each vertex of the walls, as edges and coordinates, and whether the outline is smooth."""
    ends = tissue.walls.vertices
    order = np.argsort(ends.ravel(), kind="stable").reshape(-1, 2)
    np.testing.assert_array_equal(ends.ravel()[order[:, 0]], ends.ravel()[order[:, 1]])
    edge, end = np.divmod(order, 2)
    return edge, end.astype(float), np.abs(tissue.walls.exterior_angle[edge[:, 0], end[:, 0]]) < SHARP


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("radius", [0.0, 0.2])
def test_a_pressure_is_continuous_at_smooth_joints_and_broken_at_corners(order, radius):
    tissue = small_tissue(1, 2, order=order, radius=radius, edges=3)
    space = MultiplierSpace(tissue.walls)
    coefficients = np.random.default_rng(1).uniform(1, 2, space.size)
    edge, end, smooth = joints(tissue)
    assert (~smooth).sum() == (12 if radius == 0 else 0)
    jump = np.abs(np.diff(pressure(space, coefficients, edge, end), axis=1))[:, 0]
    assert jump[smooth].max() < 1e-14
    assert (jump[~smooth] > 1e-3).all()
    # As many functions as a chain of polynomials has, which gains one at each break and loses one on each side of it.
    assert space.size == space.degree * tissue.walls.facet_count + (1 - 2) * (~smooth).sum()


def test_constrained_points_are_each_vertex_once_and_the_quarters_of_edges():
    walls = small_tissue(1, 2, radius=0.2).walls
    points = constrained_points(walls)
    edge, xi = points.facet, points.xi
    np.testing.assert_array_equal(np.diff(edge) >= 0, True)
    place = walls.places(edge, xi, walls.rest)
    quarters = walls.basis.values(np.array([0.25, 0.5, 0.75])) @ walls.rest
    outline = np.concatenate([walls.rest[:, 0], quarters.reshape(-1, 2)])
    assert len(place) == len(outline) == 4 * walls.facet_count
    apart = np.linalg.norm(place[:, None] - place[None], axis=2) + 9 * np.eye(len(place))
    mine = walls.body[edge]
    assert apart[mine[:, None] == mine[None]].min() > 1e-3
    np.testing.assert_allclose(np.sort(place.ravel()), np.sort(outline.ravel()), atol=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_the_sagitta_of_arcs_is_at_least_what_chords_cut_off(order):
    walls = rings((0.3, 0.3), order=order).walls
    length = np.linalg.norm(walls.rest[:, -1] - walls.rest[:, 0], axis=1)
    radius = np.linalg.norm(walls.rest[:, 0], axis=1)
    cut_off = radius - np.sqrt(radius**2 - length**2 / 4)
    if order == 1:
        assert (sagitta(walls, walls.rest) >= cut_off * (1 - 1e-9)).all()
        assert (sagitta(walls, walls.rest) <= 2.1 * cut_off.max()).all()
    else:
        # Curved edges turn smoothly at their joints.
        assert sagitta(walls, walls.rest).max() < 0.05 * cut_off.max()
