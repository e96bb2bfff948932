"""Meshes of drawn shapes: bodies apart, boundaries named, walls found."""

from __future__ import annotations

from math import pi

import ngsolve
import numpy as np
import pytest
from netgen import occ

from ngcell.contact.surface.find import find_surface
from ngcell.errors import CaseError, GeometryError
from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.shapes import check_boundaries, mesh_shapes
from ngcell.mechanics.space import DisplacementSpace


def ring(inner: float, outer: float, centre: tuple[float, float] = (0.0, 0.0)) -> occ.TopoDS_Shape:
    return occ.Circle(centre, outer).Face() - occ.Circle(centre, inner).Face()


def touching_rings(order: int = 2) -> BodyMesh:
    return mesh_shapes([ring(0.5, 1.0), ring(1.0, 1.5)], ["inner", "outer"], order=order, size=0.25)


def test_touching_bodies_share_nothing():
    bodies = touching_rings()
    owners = [set() for _ in range(bodies.mesh.nv)]
    for element, body in zip(bodies.mesh.Elements(ngsolve.VOL), bodies.body_of_element, strict=True):
        assert element.mat == bodies.body_names[body]
        for vertex in element.vertices:
            owners[vertex.nr].add(int(body))
    assert all(len(owner) == 1 for owner in owners)
    area = ngsolve.Integrate(ngsolve.CF(1), bodies.mesh, region_wise=True).NumPy()
    np.testing.assert_allclose(area, [0.75 * pi, 1.25 * pi], rtol=1e-4)


def test_walls_are_outlines_and_holes_with_a_body_inside():
    bodies = touching_rings()
    names = {"inner_outline", "inner_hole0", "outer_outline", "outer_hole0"}
    assert set(bodies.mesh.GetBoundaries()) == names
    assert set(bodies.wall_names.split("|")) == names - {"inner_hole0"}
    assert bodies.thickness == pytest.approx(0.5)
    assert bodies.length == pytest.approx(2**0.5, rel=0.02)


def test_a_hole_without_a_body_is_no_wall():
    bodies = mesh_shapes([ring(0.5, 1.0), ring(0.5, 1.0, (2.0, 0.0))], ["left", "right"], order=2)
    assert bodies.wall_names == "left_outline|right_outline"
    assert mesh_shapes([ring(0.5, 1.0)], ["alone"], order=2).wall_names == "alone_outline"


def test_many_holes_are_told_apart():
    plate = occ.Rectangle(4, 2).Face()
    for x in (1, 3):
        plate -= occ.Circle((x, 1), 0.5).Face()
    disc = occ.Circle((3, 1), 0.45).Face()
    bodies = mesh_shapes([plate, disc], ["plate", "disc"], order=2, size=0.3)
    names = set(bodies.mesh.GetBoundaries())
    assert names == {"plate_outline", "plate_hole0", "plate_hole1", "disc_outline"}
    (full,) = {name for name in bodies.wall_names.split("|") if "hole" in name}
    points = [bodies.mesh[vertex].point for edge in bodies.mesh.Boundaries(full).Elements() for vertex in edge.vertices]
    np.testing.assert_allclose(np.mean(points, axis=0), (3, 1), atol=0.05)


def test_names_of_edges_are_kept_and_shapes_are_left_alone():
    square = occ.Rectangle(1, 1).Face()
    square.edges.Min(occ.Y).name = "floor"
    before = [edge.name for edge in square.edges]
    bodies = mesh_shapes([square, square.Move((1, 0, 0))], ["left", "right"], order=1, size=0.5)
    assert set(bodies.mesh.GetBoundaries()) == {"floor", "left_outline", "right_outline"}
    assert [edge.name for edge in square.edges] == before
    check_boundaries(bodies, ["floor", "left_outline"])
    with pytest.raises(GeometryError, match="support flor: .*did you mean floor"):
        check_boundaries(bodies, ["flor"])


def test_a_small_body_does_not_refine_a_large_one():
    small, large = (occ.Rectangle(side, side).Face() for side in (0.01, 1.0))
    bodies = mesh_shapes([small, occ.Translation((0, 0.02, 0))(large)], ["small", "large"], order=1)
    counts = np.bincount(bodies.body_of_element)
    assert counts.max() < 4 * counts.min()
    assert small.faces[0].maxh > 1


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_reference_positions_are_unknowns_on_curved_elements(order):
    bodies = touching_rings(order)
    space = DisplacementSpace(bodies, order)
    position = space.function(space.rest)
    for component, coordinate in zip(position.components, (ngsolve.x, ngsolve.y), strict=True):
        error = ngsolve.Integrate((component - coordinate) ** 2, bodies.mesh, order=2 * order + 2)
        assert error < 1e-24
    walls = find_surface(bodies, space.scalar, space.rest)
    edges = list(bodies.mesh.Boundaries(bodies.wall_names).Elements())
    for nodes, edge in zip(walls.rest, edges, strict=True):
        trafo = bodies.mesh.GetTrafo(edge)  # mapped points refer to it
        mapped = [trafo(xi).point for xi in walls.basis.nodes]
        np.testing.assert_allclose(nodes, mapped, rtol=0, atol=1e-10)
    middle = (walls.rest[:, 0] + walls.rest[:, -1]) / 2
    along_radius = (walls.chord_normals(walls.rest) * middle).sum(1)
    faces_out = (walls.body == 0) | (np.linalg.norm(middle, axis=1) > 1.2)
    assert (np.sign(along_radius) == np.where(faces_out, 1, -1)).all()


def solid() -> occ.Solid:
    return occ.Box((0, 0, 0), (1, 1, 1))


SOLID = solid()
SQUARE = occ.Rectangle(1, 1).Face()
CROSSED = occ.WorkPlane().MoveTo(0, 0).LineTo(1, 1).LineTo(1, 0).LineTo(0, 1).Close().Face()
GLUED = list(occ.Glue([SQUARE, SQUARE.Move((1, 0, 0))]).faces)


@pytest.mark.parametrize(
    ("shapes", "message"),
    [
        ([solid(), SQUARE], "body b: its shape is no solid, others are; allowed: all faces or all solids"),
        ([occ.Compound([solid(), solid().Move((2, 0, 0))])], "body a: its shape has 2 solids; allowed: one"),
        ([SOLID, SOLID], "bodies a, b: two of them are the same solid or share a face"),
        ([solid().faces[0]], "body a: its face reaches from z = 0 to 1; allowed: the plane z = 0"),
        ([SQUARE.Move((0, 0, 1))], "body a: its face reaches from z = 1 to 1"),
        ([occ.Compound([SQUARE, SQUARE.Move((2, 0, 0))])], "body a: its shape has 2 faces; allowed: one"),
        ([SQUARE.edges[0]], "body a: its shape has 0 faces"),
        (["square"], "body a: its shape is 'square'; allowed: a face or a solid made with netgen.occ"),
        ([SQUARE, SQUARE], "bodies a, b: two of them are the same face or share an edge"),
        (GLUED, "bodies a, b: two of them are the same face or share an edge"),
        ([CROSSED], "bodies a: Netgen cannot mesh them"),
    ],
)
def test_shapes_that_are_no_separate_planar_faces_are_refused(shapes, message):
    with pytest.raises(GeometryError, match="^" + message):
        mesh_shapes(shapes, ["a", "b"][: len(shapes)], order=2, size=0.5)


def test_two_bodies_need_two_names():
    with pytest.raises(CaseError, match="'a' is used twice"):
        mesh_shapes([SQUARE, SQUARE.Move((2, 0, 0))], ["a", "a"], order=1)
