"""The quadrature rules on walls whose edges or faces are divided into equal parts."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.surface.facets import FacetSurface
from ngcell.contact.surface.find import find_surface
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.prisms import prism_mesh
from ngcell.geometry.sections import ring_section
from ngcell.mechanics.space import DisplacementSpace
from tests.contact.solids import balls
from tests.tissues import contact_term, small_tissue


@pytest.mark.parametrize("parts", [1, 2, 4])
def test_the_rule_of_equal_parts_is_exact_for_what_has_kinks_between_them(parts: int):
    walls = small_tissue(1, 2, order=3).walls
    points = walls.divided(parts)
    length = np.bincount(points.facet, points.weight)
    np.testing.assert_allclose(length, walls.weights.sum(1), rtol=1e-13)
    assert (np.diff(points.xi.reshape(walls.facet_count, -1), axis=1) > 0).all()  # points between parts are there once
    kinked = sum(np.abs(points.xi - place) for place in np.arange(1, parts) / parts)
    expected = sum((place**2 + (1 - place) ** 2) / 2 for place in np.arange(1, parts) / parts)
    np.testing.assert_allclose(np.bincount(points.facet, points.weight * kinked), expected * length, rtol=1e-12)


@pytest.mark.parametrize("parts", [1, 2, 3])
@pytest.mark.parametrize("kind", ["squares", "triangles"])
def test_the_rule_of_equal_parts_of_faces_is_exact_for_what_has_kinks_between_them(kind: str, parts: int):
    walls = contact_term(balls(2).problem).method.walls if kind == "triangles" else prisms()
    points = walls.divided(parts)
    share = points.weight / walls.rest_measure(points.facet, points.xi)
    assert len(np.unique(np.column_stack([points.facet, points.xi.round(9)]), axis=0)) == len(points.facet)
    place = np.arange(1, parts) / parts
    kinked = sum(np.abs(points.xi[:, 0] - at) for at in place)
    # Integrals of |x - a| over the unit square, and over the unit triangle, which is 1 - x wide.
    square, triangle = (place**2 + (1 - place) ** 2) / 2, place**2 / 2 - place**3 / 6 + (1 - place) ** 3 / 6
    expected = (triangle if kind == "triangles" else square).sum()
    np.testing.assert_allclose(np.bincount(points.facet, share), 0.5 if kind == "triangles" else 1.0, rtol=1e-13)
    np.testing.assert_allclose(np.bincount(points.facet, share * kinked), expected, rtol=1e-11, atol=1e-14)


def prisms() -> FacetSurface:
    """Return the walls of prisms, whose sides and ends have rules of their own."""
    section = ring_section(
        hexagonal_lattice(1, 2, side=1.0, pointy=True).outlines, wall=0.2, radius=0.0, edges=1, layers=1, supports={}
    )
    space = DisplacementSpace(prism_mesh(section, height=0.6, slices=2), 2)
    return find_surface(space.bodies, space.scalar, space.rest)
