"""Cells from outlines: rings that share their walls node by node, whatever the polygons, and what cannot be swept."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest
import shapely

from ngcell.contact.pairing.facing import find_facing
from ngcell.contact.surface.find import find_surface
from ngcell.errors import GeometryError
from ngcell.geometry.held import held_walls
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.lumens import can_be_swept, check_corners, check_lumens
from ngcell.geometry.partition import outlines_of
from ngcell.geometry.rings import GRADE, sweep
from ngcell.geometry.sections import ring_mesh
from ngcell.geometry.short_sides import without_short_sides
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.tie import coincident_facets

SAME = 1e-6
#: An L, re-entrant and clockwise, the square in its corner, and two on top whose joint lies inside of its long side.
CELLS = [
    [(0, 0), (0, 3), (3, 3), (3, 2), (1, 2), (1, 0)],
    [(1, 0), (3, 0), (3, 2), (1, 2)],
    [(0, 3), (1.6, 3), (1.6, 4.5), (0, 4.5)],
    [(1.6, 3), (3, 3), (3.2, 4), (1.6, 4.5)],
]
OUTLINES = outlines_of([np.array(cell, dtype=float) for cell in CELLS], SAME)
CHOICES = {"wall": 0.2, "radius": 0.0, "edges": 2, "layers": 1, "supports": {}}


def cut_off(angle: float, cut: float) -> float:
    """Area that a corner of an exterior angle loses: a kite less the part of a disc."""
    radius = cut / np.tan(angle / 2)
    return radius * cut - radius**2 * angle / 2


def test_a_corner_inside_a_side_splits_it_and_neighbours_follow_from_shared_sides():
    assert OUTLINES.counts.tolist() == [7, 4, 4, 4]
    pairs = {(int(one), int(two)) for one, two in zip(OUTLINES.cell, OUTLINES.neighbours, strict=True) if two > one}
    assert pairs == {(0, 1), (0, 2), (0, 3), (2, 3)}
    np.testing.assert_allclose(OUTLINES.areas, shapely.area(OUTLINES.polygons), rtol=1e-13)
    shared = OUTLINES.twins >= 0
    assert (OUTLINES.twins[OUTLINES.twins[shared]] == np.flatnonzero(shared)).all()
    np.testing.assert_allclose(OUTLINES.exterior_angles[OUTLINES.cell == 0].sum(), 2 * np.pi)


@pytest.mark.parametrize("radius", [0.0, 0.3])
@pytest.mark.parametrize("grading", [0, 1, 3])
def test_rings_have_the_area_between_outline_and_lumen(radius, grading):
    mesh = ring_mesh(OUTLINES, **CHOICES | {"radius": radius, "grading": grading}).mesh
    for cell, outline in enumerate(OUTLINES.polygons):
        lumen = outline.buffer(-0.2, join_style="mitre")
        found = ngsolve.Integrate(1, mesh, definedon=mesh.Materials(f"cell{cell}"))
        convex = OUTLINES.exterior_angles[(OUTLINES.cell == cell) & (OUTLINES.exterior_angles > 1e-3)]
        lost = sum(cut_off(angle, radius / np.sqrt(3)) for angle in convex) if radius else 0.0
        # Chords lie inside of the arcs.
        assert lost - 1e-12 <= outline.area - lumen.area - found <= 1.2 * lost + 1e-12
    jacobian = ngsolve.Det(ngsolve.specialcf.JacobianMatrix(2))
    assert ngsolve.Integrate(ngsolve.IfPos(jacobian, 0, 1), mesh) == 0


@pytest.mark.parametrize("radius", [0.0, 0.3])
def test_shared_walls_match_node_by_node(radius):
    edges = np.arange(len(OUTLINES.corners)) % 3 + 1
    bodies = ring_mesh(OUTLINES, **CHOICES | {"radius": radius, "grading": 2, "edges": edges})
    space = DisplacementSpace(bodies, 2)
    walls = find_surface(bodies, space.scalar, space.rest)
    pairs = coincident_facets(walls)
    length = walls.weights.sum(1)
    shared = OUTLINES.lengths[OUTLINES.twins >= 0]
    assert length[pairs].sum() == pytest.approx(shared.sum() - radius / np.sqrt(3) * 2 * len(shared), rel=1e-9)
    assert len(find_facing(walls, 1e-6).pairs) == 4


@pytest.mark.parametrize("radius", [0.0, 0.2])
def test_grading_keeps_cells_and_the_nodes_that_were_there(radius):
    layers = [sweep(OUTLINES, wall=0.2, radius=radius, edges=2, layers=1, grading=grading) for grading in range(1, 4)]
    for coarse, fine in zip(layers, layers[1:], strict=False):
        for cell in range(4):
            one, two = (rings.nodes[:, rings.cell == cell].reshape(-1, 2) for rings in (coarse, fine))
            away = np.linalg.norm(one[:, None] - two[None], axis=2).min(1)
            assert away.max() < 1e-11
    finest = layers[-1]
    sides = np.linalg.norm(finest.nodes[-1][finest.ahead] - finest.nodes[-1], axis=1)
    assert sides.min() > 0.1 * GRADE**2 * 0.2


def test_polygons_of_hexagons_are_the_honeycomb():
    regular = hexagonal_lattice(3, 4, side=1.0, pointy=True).outlines
    cells = np.split(regular.corners, np.cumsum(regular.counts)[:-1])
    found = outlines_of([cell[::-1] for cell in cells], SAME)
    for cell in range(12):
        one, two = regular.corners[regular.cell == cell], found.corners[found.cell == cell]
        assert np.linalg.norm(one[:, None] - two, axis=2).min(1).max() < 1e-12
    assert sorted(found.neighbours) == sorted(regular.neighbours)
    held, known = held_walls(found, "plates", 0.5 + 1e-9), held_walls(regular, "plates", 0.5 + 1e-9)
    lattice = hexagonal_lattice(3, 4, side=1.0, pointy=True)
    assert (known["lower-plate"] == lattice.hull_walls(0, -1).ravel()).all()
    assert (known["upper-plate"] == lattice.hull_walls(2, 1).ravel()).all()
    assert held["lower-plate"].sum() == held["upper-plate"].sum() == 8


def ring_of_squares() -> list[np.ndarray]:
    """Eight squares around a pore."""
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    return [square + (x, y) for y in range(3) for x in range(3) if (x, y) != (1, 1)]


def test_walls_around_pores_are_outer_ones_that_nothing_holds():
    outlines = outlines_of(ring_of_squares(), SAME)
    assert (outlines.twins < 0).sum() == 12 + 4
    assert held_walls(outlines, "frame", 0.0)["frame"].sum() == 12
    held = held_walls(outlines, "plates", 0.0)
    assert [int(member.sum()) for member in held.values()] == [3, 3]
    middle = (outlines.corners + outlines.corners[outlines.ahead]) / 2
    assert (middle[held["lower-plate"], 1] == 0).all() and (middle[held["upper-plate"], 1] == 3).all()
    assert held_walls(outlines, None, 0.0) == {}


def test_plates_with_nothing_to_hold_say_how_far_off_it_is():
    outlines = outlines_of([np.array([(0.0, 0.0), (1.0, 1.0), (0.0, 2.0), (-1.0, 1.0)])], SAME)
    with pytest.raises(GeometryError, match="the tissue's lower edge.*allowed: tissue.held_within >= 1"):
        held_walls(outlines, "plates", 0.5)


def test_a_side_too_short_for_its_wall_becomes_a_corner_of_all_cells():
    lower, upper = 0.95, 1.05
    cells = [
        [(0, 0), (1, 0), (1, lower), (0, lower - 0.1)],
        [(1, 0), (2, 0), (2, lower), (1, lower)],
        [(0, lower - 0.1), (1, lower), (1, upper), (0, 2)],
        [(1, lower), (2, lower), (2, 2), (0, 2), (1, upper)],
    ]
    outlines = outlines_of([np.array(cell, dtype=float) for cell in cells], SAME)
    with pytest.raises(GeometryError, match="cell 2.*closes its lumen, or one side of it; allowed: 0 < wall < 0.0"):
        check_lumens(outlines, 0.1)
    found, gone = without_short_sides(outlines, 0.1, 0.25)
    assert gone == 1
    assert can_be_swept(found, 0.1).all()
    assert found.areas.sum() == pytest.approx(outlines.areas.sum(), rel=1e-12)
    assert found.counts.tolist() == [4, 4, 3, 4]
    assert np.isclose(found.corners, (1, 1)).all(1).sum() == 4


@pytest.mark.parametrize(
    ("cells", "says"),
    [
        ([[(0, 0), (1, 0)]], "cell 0 has 2 corners; allowed: three or more"),
        ([[(0, 0), (1, 0), (1, float("nan"))]], "cell 0 has 3 corners; .*at finite places"),
        ([[(0, 0), (1, 1), (1, 0), (0, 1)]], "cell 0: Self-intersection.*allowed: a simple polygon"),
        ([[(0, 0), (1, 0), (2, 0)]], "cell 0: .*allowed: a simple polygon with an area"),
        ([CELLS[1], [(2, 0), (4, 0), (4, 2), (2, 2)]], "cell 0 and cell 1 overlap by 50 % of the smaller one"),
        ([CELLS[1], CELLS[1]], "cell 0 and cell 1 overlap by 100 % of the smaller one"),
        ([CELLS[1], [(3.01, 0), (4, 0), (4, 2), (3.01, 2)]], "cell 0 and cell 1 have a gap of 0.01 between them"),
    ],
)
def test_polygons_that_make_no_tissue_are_refused(cells, says):
    with pytest.raises(GeometryError, match=says):
        outlines_of([np.array(cell, dtype=float) for cell in cells], SAME, narrowest=0.02)


def test_walls_and_corners_that_do_not_fit_are_refused_with_what_does():
    with pytest.raises(GeometryError, match=r"cell 0, about .*: its wall of 0.6 .*allowed: 0 < wall < 0\.4\d+ in"):
        check_lumens(OUTLINES, 0.6)
    check_lumens(OUTLINES, 0.45)
    with pytest.raises(GeometryError, match=r"round corners of cell \d meet on one of its sides.*radius < 0.866"):
        check_corners(OUTLINES, 0.9, 0.51)
    square = outlines_of([np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])], SAME)
    limit = 0.1 / (1 - np.sqrt(0.5))  # of a right angle, whose radius is what it loses of its sides
    check_corners(square, 0.1, 0.999 * limit)
    with pytest.raises(GeometryError, match=f"cut through its wall.*corner_radius < {np.sqrt(3) * limit:.4g}"):
        check_corners(square, 0.1, 1.001 * limit)
