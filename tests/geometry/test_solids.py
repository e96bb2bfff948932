"""Solids side by side in one mesh: who touches whom, names, measures, and what is refused."""

from __future__ import annotations

from math import pi

import ngsolve
import numpy as np
import pytest
from netgen import occ

from ngcell.contact.pairing.facing import find_facing
from ngcell.contact.surface.find import find_surface
from ngcell.errors import GeometryError
from ngcell.geometry.enclosure import winding_numbers
from ngcell.geometry.near import near_pairs
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.space import DisplacementSpace


def shell(inner: float, outer: float) -> occ.Solid:
    return (occ.Sphere((0, 0, 0), outer) - occ.Sphere((0, 0, 0), inner)).solids[0]


def cube(corner: tuple[float, float, float] = (0, 0, 0)) -> occ.Solid:
    return occ.Box(corner, tuple(x + 1 for x in corner)).solids[0]


def test_a_hole_is_a_wall_where_another_body_lies_in_it():
    alone = mesh_shapes([shell(0.5, 1.0)], ["shell"], order=2, size=0.5)
    assert alone.wall_names == "shell_outline"
    assert set(alone.mesh.GetBoundaries()) == {"shell_outline", "shell_hole0"}
    nested = mesh_shapes([shell(0.5, 1.0), occ.Sphere((0, 0, 0), 0.45).solids[0]], ["a", "b"], order=2, size=0.5)
    assert nested.wall_names == "a_hole0|a_outline|b_outline"
    assert nested.thickness == pytest.approx(2 * 0.45 / 3, rel=1e-9)


def test_touching_solids_share_no_node_and_face_each_other():
    bodies = mesh_shapes([cube(), cube((0, 0, 1))], ["lower", "upper"], order=2, size=0.6)
    assert bodies.dimension == 3
    assert ngsolve.Integrate(ngsolve.CF(1), bodies.mesh) == pytest.approx(2, rel=1e-12)
    space = DisplacementSpace(bodies, 2)
    walls = find_surface(bodies, space.scalar, space.rest)
    assert walls.weights.sum() == pytest.approx(12, rel=1e-12)
    assert (walls.weights > 0).all()
    outward = walls.chord_normals(walls.rest)
    centre = np.array([[0.5, 0.5, 0.5], [0.5, 0.5, 1.5]])[walls.body]
    height = np.einsum("ed,ed->e", walls.middles(walls.rest) - centre, outward)
    np.testing.assert_allclose(height, 0.5, rtol=1e-12)
    facing = find_facing(walls, 1e-3)
    assert facing.pairs.tolist() == [[0, 1]]
    assert np.abs(facing.gaps(walls, walls.rest)).max() < 1e-12
    assert facing.weight.sum() == pytest.approx(2, rel=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_curved_faces_follow_the_sphere(order):
    bodies = mesh_shapes([occ.Sphere((0, 0, 0), 1.0).solids[0]], ["ball"], order=order, size=0.5)
    space = DisplacementSpace(bodies, order)
    walls = find_surface(bodies, space.scalar, space.rest)
    assert walls.weights.sum() == pytest.approx(4 * pi, rel={1: 0.2, 2: 5e-3, 3: 1e-3}[order])
    radius = np.linalg.norm(walls.rest, axis=2)
    assert np.abs(radius - 1).max() < {1: 1e-12, 2: 1e-3, 3: 1e-3}[order]


def test_near_pairs_in_three_dimensions_are_those_of_all_distances():
    points = np.random.default_rng(1).uniform(0, 1, (300, 3))
    one, two = near_pairs(points, 0.13)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    first, second = np.nonzero(np.triu(apart <= 0.13, 1))
    assert len(one) > 100
    np.testing.assert_array_equal(np.column_stack([one, two]), np.column_stack([first, second]))


def test_winding_numbers_tell_inside_from_outside():
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    triangles = corners[np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])]
    points = np.array([(0.2, 0.2, 0.2), (0.5, 0.5, 0.5), (-0.1, 0.2, 0.2), (0.05, 0.9, 0.02)])
    np.testing.assert_allclose(winding_numbers(points, triangles), [1, 0, 0, 1], atol=1e-12)


def test_names_of_faces_must_be_plain():
    solid = cube()
    solid.faces[0].name = "my face"
    with pytest.raises(GeometryError, match="face name 'my face'; allowed: letters"):
        mesh_shapes([solid], ["cube"], order=1, size=0.5)
