"""Polygons in which faces lie over each other cover what faces, once, whatever the two meshes."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.pairing.intersections import find_intersections, intersection_pairs
from ngcell.contact.pairing.near import near_facets
from ngcell.contact.surface.surface import Surface
from tests.contact.solids import blocks
from tests.contact.test_solid_mortar import prisms

REACH = 0.1


def faced_area(walls: Surface, nodes: np.ndarray, primary: int) -> float:
    """Area at rest of what faces the other body: the sum of all weights."""
    edge, other = near_facets(walls, nodes, REACH)
    mine = walls.body[edge] == primary
    intersections = find_intersections(walls, nodes, edge[mine], other[mine])
    return float(intersection_pairs(walls, nodes, intersections, REACH).weight.sum())


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("primary", [0, 1])
@pytest.mark.parametrize(
    ("translation", "area"),
    [((0, 0, 0), 0.55 * 0.65), ((0.1, -0.05, 0.01), 0.55 * 0.65), ((0.5, 0, 0), 0.3 * 0.65), ((1.5, 0, 0), 0.0)],
)
def test_weights_add_up_to_the_area_that_faces(order, primary, translation, area):
    bodies = blocks(order)
    nodes = bodies.walls.nodes(bodies.space.rest + np.array(translation)[:, None] * bodies.upper)
    assert faced_area(bodies.walls, nodes, primary) == pytest.approx(area, abs=1e-12)


@pytest.mark.parametrize("noise", [0.0, 1e-12, 1e-11, 1e-10, 1e-9])
def test_sides_that_nearly_coincide_make_no_difference(noise):
    """Meshes that match, up to about the distance at which corners count as on a side."""
    bodies = prisms(1, edges=4)
    random = np.random.default_rng(4)
    for _ in range(10):
        positions = bodies.space.rest + noise * random.standard_normal(bodies.space.rest.shape)
        for primary in (0, 1):
            assert faced_area(bodies.walls, bodies.walls.nodes(positions), primary) == pytest.approx(0.6, abs=1e-7)


def test_shapes_of_both_sides_are_smooth_on_a_polygon():
    """All closest points of its points lie inside the other face, and nearest to no other."""
    bodies = blocks(1)
    nodes = bodies.walls.nodes(bodies.space.rest + np.array([0.07, 0.03, -0.01])[:, None] * bodies.upper)
    edge, other = near_facets(bodies.walls, nodes, REACH)
    mine = bodies.walls.body[edge] == 0
    found = intersection_pairs(
        bodies.walls, nodes, find_intersections(bodies.walls, nodes, edge[mine], other[mine]), REACH
    )
    for xi in (found.primary_xi, found.secondary_xi):
        assert (xi > 0).all() and (xi.sum(1) < 1).all()
    own = bodies.walls.places(found.primary, found.primary_xi, nodes)
    away = own - bodies.walls.places(found.secondary, found.secondary_xi, nodes)
    np.testing.assert_allclose(away, [[0, 0, 0.01]] * len(away), atol=1e-12)
