"""Depths of overlap against figures whose overlap is known."""

from __future__ import annotations

from time import process_time

import ngsolve
import numpy as np
import pytest
from netgen import occ

from ngcell.contact.surface.find import find_surface
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.lattice import Lattice, hexagonal_lattice
from ngcell.geometry.sections import ring_mesh
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results import solid_overlap
from ngcell.results.outline_overlap import deepest_overlap
from ngcell.results.solid_overlap import deepest_overlap_of_solids

ORDERS = (1, 2, 3, 4)
APOTHEM = np.sqrt(3) / 2


def walls_of(bodies: BodyMesh, order: int = 2) -> Surface:
    space = DisplacementSpace(bodies, order)
    return find_surface(bodies, space.scalar, space.rest)


def tissue(lattice: Lattice, order: int = 2, *, edges: int = 2, radius: float = 0.0) -> Surface:
    supports = {"low": lattice.hull_walls(0, -1)}
    mesh = ring_mesh(lattice.outlines, wall=0.1, radius=radius, edges=edges, layers=1, supports=supports)
    return walls_of(mesh, order)


def shapes(faces: dict[str, occ.Face], walls: str, order: int = 2) -> Surface:
    """Walls of one body a face; edges named as in `walls` (a regular expression) are walls."""
    for name, face in faces.items():
        face.faces.name = name
    shape = occ.OCCGeometry(occ.Compound(list(faces.values())), dim=2)
    mesh = ngsolve.Mesh(shape.GenerateMesh(maxh=0.5)).Curve(order)
    names = list(faces)
    body = np.array([names.index(element.mat) for element in mesh.Elements(ngsolve.VOL)])
    return walls_of(BodyMesh(mesh, body, tuple(names), walls, 1.0, 1.0), order)


def turned(nodes: np.ndarray, angle: float) -> np.ndarray:
    return nodes @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def moved(walls: Surface, body: int, translation: tuple[float, float]) -> np.ndarray:
    return walls.rest + (walls.body == body)[:, None, None] * np.array(translation)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("pointy", [True, False])
@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0])
def test_a_turned_tissue_has_no_overlap(order, pointy, angle):
    walls = tissue(hexagonal_lattice(3, 3, side=1.0, pointy=pointy), order, radius=0.2)
    assert deepest_overlap(walls, turned(walls.rest, angle)) < 1e-12


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("depth", [1e-6, 0.01, 0.3])
def test_translated_hexagons_overlap_by_the_translation(order, depth):
    walls = tissue(hexagonal_lattice(1, 2, side=1.0, pointy=True), order)
    for angle in (0.0, 1.0):
        nodes = turned(moved(walls, 1, (-depth, 0)), angle)
        assert deepest_overlap(walls, nodes) == pytest.approx(depth, abs=1e-12)


def test_parted_hexagons_do_not_overlap():
    walls = tissue(hexagonal_lattice(1, 2, side=1.0, pointy=True))
    assert deepest_overlap(walls, moved(walls, 1, (0.01, 0))) == 0


@pytest.mark.parametrize("swallowed", [0, 1])
def test_a_cell_within_a_hollow_cell_overlaps_it_although_no_walls_cross(swallowed):
    walls = tissue(hexagonal_lattice(1, 2, side=1.0, pointy=True))
    centre = np.array([2 * APOTHEM * swallowed, 0.0])
    inner = (walls.body == swallowed)[:, None, None]
    other = np.array([2 * APOTHEM * (1 - swallowed), 0.0])
    nodes = np.where(inner, other + 0.3 * (walls.rest - centre), walls.rest)
    # All of a hexagon's boundary is equally far from a concentric, parallel one.
    assert deepest_overlap(walls, nodes) == pytest.approx(APOTHEM * 0.7, abs=1e-12)


def test_a_tip_is_seen_by_its_depth():
    """A square stands on its corner above a plate and cuts into it by 0.2."""
    plate = occ.MoveTo(-2, -1).Rectangle(4, 1).Face()
    square = occ.MoveTo(0, 0).Rectangle(1, 1).Face().Rotate(occ.Axis((0, 0, 0), occ.Z), 45)
    walls = shapes({"plate": plate, "square": square.Move((0, -0.2, 0))}, ".*")
    assert deepest_overlap(walls, walls.rest) == pytest.approx(0.2, abs=1e-12)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_curved_outlines_are_followed(order):
    """Two discs of radius 1 whose centres are 1.9 apart, turned so that no node lies deepest."""
    discs = {f"disc{i}": occ.Circle((1.9 * i, 0), 1).Face() for i in range(2)}
    walls = shapes(discs, ".*", order)
    assert deepest_overlap(walls, walls.rest) == pytest.approx(0.1, abs=5e-3)


def test_an_inclusion_in_a_hole_overlaps_only_where_it_leaves_it():
    matrix = occ.MoveTo(-2, -2).Rectangle(4, 4).Face() - occ.MoveTo(-1, -1).Rectangle(2, 2).Face()
    inclusion = occ.MoveTo(-1, -1).Rectangle(2, 2).Face()
    walls = shapes({"matrix": matrix, "inclusion": inclusion}, ".*")
    assert deepest_overlap(walls, walls.rest) < 1e-12
    assert deepest_overlap(walls, moved(walls, 1, (0.1, 0))) == pytest.approx(0.1, abs=1e-12)
    assert deepest_overlap(walls, np.where((walls.body == 1)[:, None, None], 0.9, 1) * walls.rest) == 0


def two_blocks(lower_walls: str) -> Surface:
    lower, upper = occ.MoveTo(0, -1).Rectangle(1, 1).Face(), occ.MoveTo(0, 0).Rectangle(1, 1).Face()
    upper.edges.name = "upper"
    lower.edges.name = "lower"
    lower.edges.Max(occ.Y).name = "top"
    return shapes({"lower": lower, "upper": upper}, lower_walls)


def test_a_body_with_an_open_outline_has_no_inside_but_its_points_are_tested():
    walls = two_blocks("top|upper")
    assert deepest_overlap(walls, moved(walls, 1, (0, -0.1))) == pytest.approx(0.1, abs=1e-12)


def test_without_closed_outlines_there_is_no_depth():
    walls = two_blocks("top")
    assert deepest_overlap(walls, moved(walls, 0, (0, 0.5))) == 0


def test_an_outline_that_crosses_itself_is_taken_as_it_is():
    walls = tissue(hexagonal_lattice(1, 2, side=1.0, pointy=True))
    folded = walls.rest.copy()
    folded[walls.body == 0] *= np.where(folded[walls.body == 0][..., 1:] > 0, 1, [-1.0, 1.0])
    assert np.isfinite(deepest_overlap(walls, folded))


def test_a_hundred_cells_take_a_fraction_of_a_second():
    walls = tissue(hexagonal_lattice(10, 10, side=1.0, pointy=True), edges=4)
    nodes = walls.rest * 0.999
    deepest_overlap(walls, nodes)
    start = process_time()
    deepest_overlap(walls, nodes)
    assert process_time() - start < 0.5  # usually below 0.1; slow machines pass as well


def test_depths_in_curved_solids_are_those_of_their_surfaces(monkeypatch):
    """Two balls of radius 1 whose centres are 1.9 apart; polyhedra of large faces would lie inside them."""
    balls = [occ.Sphere((1.9 * number, 0, 0), 1) for number in range(2)]
    bodies = mesh_shapes(balls, ["one", "two"], order=3, size=0.8)
    space = DisplacementSpace(bodies, 3)
    walls = find_surface(bodies, space.scalar, space.rest)
    xi = np.concatenate([walls.quadrature_points, walls.basis.nodes])
    point = walls.basis.values(xi) @ walls.nodes(space.rest)
    centre = np.where(walls.body == 0, 1.9, 0.0)[:, None, None] * [1.0, 0.0, 0.0]
    exact = 1 - np.linalg.norm(point - centre, axis=2).min()
    fine = deepest_overlap_of_solids(walls, space, space.rest)
    monkeypatch.setattr(solid_overlap, "_FINE_PIECES", solid_overlap._PIECES)
    coarse = deepest_overlap_of_solids(walls, space, space.rest)
    assert abs(fine - exact) < 1e-3 < abs(coarse - exact)
