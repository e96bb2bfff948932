"""Meshes of hollow cells: areas in closed form, separate bodies, orientation."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.contact.surface.find import find_surface
from ngcell.geometry import rings, rounded
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.rings import sweep
from ngcell.geometry.tissues.honeycomb import Tissue
from ngcell.mechanics.space import DisplacementSpace
from ngcell.scene.mesh import MeshChoice
from tests.tissues import small_tissue

HEXAGON = 1.5 * np.sqrt(3)
APOTHEM = np.sqrt(3) / 2


def ring_area(wall: float, radius: float = 0.0) -> float:
    """Area of a hexagonal ring of side 1: each rounded corner lacks a kite less a sixth of a disc."""
    return HEXAGON * (1 - (1 - wall / APOTHEM) ** 2) - radius**2 * (2 * np.sqrt(3) - np.pi)


def mesh_area(bodies) -> float:
    return ngsolve.Integrate(ngsolve.CF(1), bodies.mesh)


@pytest.mark.parametrize("pointy", [True, False])
@pytest.mark.parametrize("wall", [0.05, 0.3, 0.8])
def test_sharp_rings_have_the_area_of_the_hexagons_less_that_of_the_lumens(wall, pointy):
    tissue = small_tissue(2, 3, wall=wall, pointy=pointy)
    assert mesh_area(tissue.bodies) == pytest.approx(6 * ring_area(wall), rel=1e-13)


@pytest.mark.parametrize(("order", "rate"), [(1, 2), (2, 4), (3, 4)])
def test_rounded_rings_approach_the_area_with_round_corners(monkeypatch, order, rate):
    errors = []
    for edges in (2, 4, 8):
        for module in (rings, rounded):
            monkeypatch.setattr(module, "ARC_EDGES", edges)
        errors.append(mesh_area(small_tissue(1, 1, radius=0.3, order=order).bodies) / ring_area(0.2, 0.3) - 1)
    assert 0 < abs(errors[0]) < (4e-3 if order == 1 else 2e-5)
    rates = np.log2(np.abs(errors[:-1]) / np.abs(errors[1:]))
    np.testing.assert_allclose(rates, rate, atol=0.1)


@pytest.mark.parametrize("grading", [0, 1, 2])
@pytest.mark.parametrize("height", [None, 0.7])
def test_round_walls_turn_smoothly_and_their_coordinates_are_functions_of_the_space(height, grading):
    tissue = Tissue(rows=2, cols=2, wall=0.1, corner_radius=0.3, height=height)
    turns = []
    for order in (1, 2, 3, 4):
        space = DisplacementSpace(tissue.mesh("plates", MeshChoice(grading=grading)), order)
        walls = find_surface(space.bodies, space.scalar, space.rest)
        turns.append(np.degrees(np.abs(walls.exterior_angle).max()) if height is None else 0.0)
        place = ngsolve.CF((ngsolve.x, ngsolve.y, ngsolve.z)[: space.dimension])
        slope = ngsolve.Grad(space.function(space.rest.ravel())) - ngsolve.Id(space.dimension)
        off = space.function(space.rest.ravel()) - place
        assert ngsolve.Integrate(off * off, space.mesh) < 1e-28
        assert ngsolve.Integrate(ngsolve.InnerProduct(slope, slope), space.mesh) < 1e-24
    if height is None:
        assert turns[0] > 13 and (np.array(turns[1:]) < (2, 0.2, 0.03)).all()


@pytest.mark.parametrize("radius", [0.05, 0.3, 0.8])
def test_chords_of_arcs_stay_inside_by_less_than_a_percent_of_the_radius(radius):
    lattice = hexagonal_lattice(1, 1, side=1.0, pointy=True)
    outer = sweep(lattice.outlines, wall=0.2, radius=radius, edges=2, layers=1).nodes[0]
    points = np.linspace(outer, np.roll(outer, -1, axis=0), 21).reshape(-1, 2)
    # The rounded hexagon is the smaller, sharp one with all points nearer than the radius.
    centres = lattice.corners * (1 - radius / APOTHEM)
    nearest = centres[np.argmax(points @ centres.T, axis=1)]
    along = np.einsum("nd,wd->nw", points, lattice.normals).max(1)
    cut_off = np.einsum("nd,nd->n", points, nearest) / np.linalg.norm(nearest, axis=1) > APOTHEM / 2
    depth = APOTHEM - along
    rounded = (depth > 1e-12) & cut_off
    inside = radius - np.linalg.norm(points[rounded] - nearest[rounded], axis=1)
    assert rounded.sum() > 100
    assert inside.min() > -1e-12
    assert 0.005 * radius < inside.max() < 0.01 * radius


@pytest.mark.parametrize("radius", [0.0, 0.1])
def test_bodies_share_no_vertex_though_their_walls_coincide(radius):
    tissue = small_tissue(3, 3, radius=radius)
    mesh, body = tissue.bodies.mesh, tissue.bodies.body_of_element
    vertices = np.array([[vertex.nr for vertex in element.vertices] for element in mesh.Elements()])
    owner = np.full(mesh.nv, -1)
    for number in range(9):
        mine = np.unique(vertices[body == number])
        assert (owner[mine] == -1).all()
        owner[mine] = number
    assert (owner >= 0).all()
    places = np.array([vertex.point for vertex in mesh.vertices])
    assert len(np.unique(np.round(places, 9), axis=0)) < mesh.nv


@pytest.mark.parametrize("pointy", [True, False])
@pytest.mark.parametrize("radius", [0.0, 0.2])
def test_elements_are_right_side_out_and_the_boundary_elements_look_outward(radius, pointy):
    bodies = small_tissue(2, 2, radius=radius, pointy=pointy).bodies
    jacobian = ngsolve.Det(ngsolve.specialcf.JacobianMatrix(2))
    assert ngsolve.Integrate(ngsolve.IfPos(jacobian, 0, 1), bodies.mesh) == 0
    area = ngsolve.Integrate(ngsolve.CF(1), bodies.mesh, element_wise=True).NumPy()
    assert area.min() > 0
    flux = ngsolve.CF((ngsolve.x, ngsolve.y)) * ngsolve.specialcf.normal(2)
    walls = ngsolve.Integrate(flux, bodies.mesh.Boundaries(bodies.wall_names))
    lumens = ngsolve.Integrate(flux, bodies.mesh.Boundaries("lumen"))
    # Divergence theorem: twice the area inside, lumens seen from within the material.
    assert lumens == pytest.approx(-2 * 4 * HEXAGON * (1 - 0.2 / APOTHEM) ** 2, rel=1e-12)
    assert walls + lumens == pytest.approx(2 * mesh_area(bodies), rel=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_walls_enclose_each_body_outward_at_every_order(order):
    tissue = small_tissue(2, 2, order=order)
    walls = tissue.walls
    tangent = walls.basis.values(walls.quadrature_points, 1) @ walls.rest
    normal = walls.side[:, None, None] * np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)
    normal /= np.linalg.norm(normal, axis=2)[..., None]
    position = walls.quadrature_values @ walls.rest
    flux = (walls.weights * (position * normal).sum(2)).sum(1)
    np.testing.assert_allclose(np.bincount(walls.body, flux), 2 * HEXAGON, rtol=1e-12)
    np.testing.assert_allclose(np.bincount(walls.body, walls.weights.sum(1)), 6, rtol=1e-12)
    np.testing.assert_allclose(walls.nodes(tissue.space.rest), walls.rest, atol=1e-13)


def test_the_depth_behind_a_wall_is_the_element_area_over_its_length():
    walls = small_tissue(1, 1, wall=0.2, edges=3).walls
    np.testing.assert_allclose(walls.depth, ring_area(0.2) / 6, rtol=1e-12)


def test_supports_and_walls_share_out_all_outer_edges():
    tissue = small_tissue(3, 4, edges=3)
    mesh = tissue.bodies.mesh
    count = {name: sum(1 for _ in mesh.Boundaries(name).Elements()) for name in ("low", "high", "wall", "lumen")}
    assert count == {"low": 3 * 8, "high": 3 * 8, "wall": 3 * (6 * 12 - 16), "lumen": 3 * 6 * 12}
    assert tissue.bodies.wall_names.split("|") == ["wall", "low", "high"]
    assert tissue.walls.facet_count == 3 * 6 * 12


@pytest.mark.parametrize("radius", [0.0, 0.05, 0.2, 0.4])
@pytest.mark.parametrize("wall", [0.02, 0.1, 0.3])
def test_grading_keeps_the_cell_and_the_nodes_that_were_there(wall: float, radius: float):
    lattice = hexagonal_lattice(1, 1, side=1.0, pointy=True)
    layers = [
        sweep(lattice.outlines, wall=wall, radius=radius, edges=2, layers=1, grading=grading).nodes
        for grading in range(4)
    ]
    areas = [_area(nodes[0]) - _area(nodes[-1]) for nodes in layers]
    assert areas == pytest.approx([areas[0]] * 4, rel=1e-12)
    for coarse, fine in zip(layers[1:], layers[2:], strict=False):
        away = np.linalg.norm(coarse.reshape(-1, 1, 2) - fine.reshape(1, -1, 2), axis=2).min(1)
        assert away.max() < 1e-12
        sides = np.linalg.norm(np.diff(fine[-1], axis=0, append=fine[-1][:1]), axis=1)
        assert sides.min() > 0.1 * rings.GRADE**2 * min(wall, 0.25)


def _area(outline: np.ndarray) -> float:
    x, y = outline.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
