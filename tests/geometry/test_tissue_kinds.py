"""Kinds of tissue beside the honeycomb: how many cells, which neighbours, what plates hold, and meshes that fit."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell import Brick, CaseError, MeshChoice, Perturbed, Polygons, Voronoi
from ngcell.contact.pairing.facing import find_facing
from ngcell.contact.surface.find import find_surface
from ngcell.geometry.bodies import LOWER_PLATE, UPPER_PLATE
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.tie import coincident_facets
from ngcell.scene import read_case

BRICKS = {"rows": 3, "cols": 4, "aspect": 2.0, "wall": 0.1}
POINTS = {"cells": 30, "extent": (9.0, 8.0), "wall": 0.1}


def boundary_length(bodies, name: str) -> float:
    return float(ngsolve.Integrate(1, bodies.mesh.Boundaries(name)))


def neighbours(outlines) -> np.ndarray:
    both = np.column_stack([outlines.cell, outlines.neighbours])[outlines.twins >= 0]
    return np.unique(np.sort(both, axis=1), axis=0)


def test_bricks_have_half_of_each_neighbour_above_and_below():
    tissue = Brick(**BRICKS)
    outlines = tissue.outlines
    assert tissue.grid == (3, 4) and tissue.cell_count == 12
    np.testing.assert_allclose(outlines.areas, 2.0, rtol=1e-12)
    assert len(neighbours(outlines)) == 3 * 3 + 2 * (2 * 4 - 1)
    above = (outlines.neighbours - outlines.cell >= 3) & (outlines.twins >= 0)
    np.testing.assert_allclose(outlines.lengths[above], 1.0)
    assert len(Brick(**BRICKS, stagger=0.0).outlines.corners) == 48
    quarter = Brick(**BRICKS, stagger=0.25).outlines
    assert set(quarter.lengths.round(9)) == {0.5, 1.0, 1.5, 2.0}


def test_plates_hold_the_straight_edges_of_bricks_whatever_their_aspect():
    for aspect in (0.5, 2.0, 30.0):
        bodies = Brick(**BRICKS | {"aspect": aspect, "wall": 0.02}).mesh("plates", MeshChoice())
        assert boundary_length(bodies, LOWER_PLATE) == pytest.approx(8) == boundary_length(bodies, UPPER_PLATE)


@pytest.mark.parametrize("seed", range(4))
def test_voronoi_cells_fill_the_rectangle_and_end_on_it(seed):
    tissue = Voronoi(**POINTS, seed=seed, relaxation=1)
    assert tissue.cell_count == 30
    assert tissue.outlines.areas.sum() == pytest.approx(72, rel=1e-12)
    low, high = tissue.outlines.corners.min(0), tissue.outlines.corners.max(0)
    assert low.tolist() == [0, 0] and high.tolist() == [9, 8]
    bodies = tissue.mesh("plates", MeshChoice(grading=2))
    assert boundary_length(bodies, LOWER_PLATE) == pytest.approx(9) == boundary_length(bodies, UPPER_PLATE)
    assert boundary_length(tissue.mesh("frame", MeshChoice()), "frame") == pytest.approx(34)
    jacobian = ngsolve.Det(ngsolve.specialcf.JacobianMatrix(2))
    assert ngsolve.Integrate(ngsolve.IfPos(jacobian, 0, 1), bodies.mesh) == 0
    space = DisplacementSpace(bodies, 2)
    walls = find_surface(bodies, space.scalar, space.rest)
    tied = walls.weights.sum(1)[coincident_facets(walls)].sum()
    outlines = tissue.outlines
    assert tied == pytest.approx(outlines.lengths[outlines.twins >= 0].sum(), rel=1e-9)
    assert find_facing(walls, 1e-6).pairs.tolist() == neighbours(outlines).tolist()


def test_relaxation_makes_cells_alike_and_a_seed_is_a_tissue():
    spread = [np.std(Voronoi(**POINTS, seed=1, relaxation=steps).outlines.areas) for steps in (0, 3, 50)]
    assert spread[0] > 2 * spread[1] > 2 * spread[2]
    one, two, three = (Voronoi(**POINTS, seed=seed).outlines.corners for seed in (1, 1, 2))
    assert np.array_equal(one, two) and (one.shape != three.shape or not np.allclose(one, three))


def test_sides_too_short_for_the_wall_are_collapsed_or_refused():
    tissue = Voronoi(**POINTS | {"wall": 0.2}, seed=1, relaxation=0)
    assert tissue.plan[1] > 0 and Voronoi(**POINTS | {"wall": 0.01}, seed=1, relaxation=5).plan[1] == 0
    with pytest.raises(CaseError, match=r"tissue.wall = 0.2: cell \d+, about .* closes its lumen, or one side of it"):
        read_case(
            "shear-empty",
            [
                'tissue={ kind = "voronoi", cells = 30, extent = [9.0, 8.0], wall = 0.2, seed = 1, relaxation = 0, '
                "shortest = 0.0 }"
            ],
        )


@pytest.mark.parametrize("grading", [0, 1, 3])
@pytest.mark.parametrize("kind", ["brick", "voronoi", "re-entrant"])
def test_lumens_of_any_shape_are_filled_to_the_last_element(kind, grading, tmp_path):
    (tmp_path / "l.csv").write_text("cell,x,y\n0,0,0\n0,3,0\n0,3,1\n0,1,1\n0,1,3\n0,0,3\n")
    tissue = {
        "brick": lambda: Brick(**BRICKS),
        "voronoi": lambda: Voronoi(**POINTS, seed=1),
        "re-entrant": lambda: Polygons(file=str(tmp_path / "l.csv"), wall=0.1),
    }[kind]()
    bodies = tissue.mesh("plates", MeshChoice(grading=grading), filled=True)
    area = ngsolve.Integrate(ngsolve.CF(1), bodies.mesh, element_wise=True).NumPy()
    jacobian = ngsolve.Det(ngsolve.specialcf.JacobianMatrix(2))
    assert area.min() > 0 and ngsolve.Integrate(ngsolve.IfPos(jacobian, 0, 1), bodies.mesh, order=5) == 0
    np.testing.assert_allclose(np.bincount(bodies.body_of_element, area), tissue.outlines.areas, rtol=1e-12)
    hollow = tissue.mesh("plates", MeshChoice(grading=grading)).mesh
    assert ngsolve.Integrate(1, bodies.mesh.Materials("filling")) == pytest.approx(
        tissue.outlines.areas.sum() - ngsolve.Integrate(1, hollow), rel=1e-12
    )
    walls = {name for name in bodies.mesh.GetBoundaries() if name != "lumen"}
    assert "lumen" not in bodies.mesh.GetBoundaries() and walls == set(hollow.GetBoundaries()) - {"lumen"}
    # Every edge inside belongs to two elements of its cell: what fills a lumen is bonded to its wall.
    mesh = bodies.mesh
    edges = np.array([[edge.nr for edge in element.edges] for element in mesh.Elements()])
    of_edge = np.bincount(edges.ravel(), minlength=mesh.nedge)
    outer = sum(1 for _ in mesh.Elements(ngsolve.BND))
    assert (of_edge == 1).sum() == outer and of_edge.max() == 2


def test_closed_prisms_of_any_outline_have_end_walls():
    tissue = Brick(**BRICKS | {"height": 1.0, "end_wall": 0.1, "layers": 2})
    bodies = tissue.mesh("plates", MeshChoice(slices=2))
    assert ngsolve.Integrate(1, bodies.mesh) == pytest.approx(24 * (2 - 1.8 * 0.8 * 0.8), rel=1e-12)
    volume = ngsolve.Integrate(ngsolve.CF(1), bodies.mesh, element_wise=True).NumPy()
    ends = np.bincount(bodies.body_of_element, volume * bodies.is_end_wall)
    np.testing.assert_allclose(ends, 2 * 0.1 * 1.8 * 0.8, rtol=1e-12)


def test_prisms_of_any_outline_are_hollow():
    tissue = Brick(**BRICKS | {"height": 0.5, "layers": 2})
    assert tissue.cell_count == 24 and tissue.grid == (6, 4)
    bodies = tissue.mesh("plates", MeshChoice(slices=2))
    assert bodies.dimension == 3 and bodies.body_count == 24
    assert ngsolve.Integrate(1, bodies.mesh) == pytest.approx(24 * 0.5 * (2 - 1.8 * 0.8), rel=1e-12)


def test_the_number_of_elements_is_foreseen():
    for tissue in (Brick(**BRICKS), Voronoi(**POINTS), Brick(**BRICKS | {"height": 0.5})):
        for grading in (0, 1, 3):
            choice = MeshChoice(grading=grading)
            assert tissue.element_count(choice) == tissue.mesh(None, choice).mesh.ne


def test_where_four_cells_meet_the_one_across_is_no_neighbour_on_any_mesh():
    tissue = Brick(**BRICKS, stagger=0.0)
    bodies = tissue.mesh("plates", MeshChoice(grading=3))
    space = DisplacementSpace(bodies, 2)
    walls = find_surface(bodies, space.scalar, space.rest)
    found = find_facing(walls, 0.05 * bodies.thickness_of_body).pairs
    assert found.tolist() == neighbours(tissue.outlines).tolist()


@pytest.mark.parametrize("tissue", [Voronoi(**POINTS), Perturbed(rows=2, cols=3, side=1.0, wall=0.2, spread=0.1)])
def test_a_copy_with_another_seed_is_another_tissue(tissue):
    before = tissue.outlines
    other = tissue.model_copy(update={"seed": 7})
    fresh = type(tissue)(**tissue.model_dump() | {"seed": 7})
    np.testing.assert_array_equal(other.outlines.corners, fresh.outlines.corners)
    assert not np.array_equal(before.corners, fresh.outlines.corners)
    assert tissue.model_copy().outlines is before


def test_sides_that_are_gone_are_counted_where_one_cell_has_to_keep_its_own():
    tissue = Voronoi(cells=12, extent=(6.0, 4.0), wall=0.12, seed=7, relaxation=0)
    drawn, (outlines, gone) = tissue.drawn(), tissue.plan
    corners = [len(np.unique(each.corners.round(9), axis=0)) for each in (drawn, outlines)]
    assert gone > 0 and corners[0] - corners[1] == gone
