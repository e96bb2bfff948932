"""What is drawn of bodies: outer facets only, and each of them once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista
from vtkmodules.vtkCommonDataModel import vtkGenericCell

from ngcell.report.surface import is_of_rigid, surface_of
from ngcell.results.snapshot import Grid
from tests.export.conftest import ring_bodies
from tests.report.results import blocks


def area(points: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def test_facets_between_elements_of_a_cell_are_inside_and_those_between_cells_are_not() -> None:
    grid = blocks(0.0)
    surface = surface_of(grid)
    assert area(grid.points[surface.points], surface.triangles) == pytest.approx(2 * (2 * 1 * 4 + 2))
    assert set(surface.owner.tolist()) == {0, 1}


def test_lines_are_where_facets_meet_at_an_angle() -> None:
    grid = blocks(0.0)
    surface = surface_of(grid)
    ends = grid.points[surface.points][surface.lines]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum()
    assert length == pytest.approx(2 * (4 * 2 + 8 * 1)), "the twelve edges of each block of 2 x 1 x 1"


@pytest.mark.parametrize("kind", [24, 29, 32])
def test_facets_of_each_type_are_those_that_vtk_knows(kind: int) -> None:
    points, cell = element(kind)
    grid = Grid(points, cell[None], kind, {}, {"cell_id": np.zeros(1, dtype=int)})
    surface = surface_of(grid)
    whole = pyvista.UnstructuredGrid({kind: cell[None]}, points)
    expected = whole.extract_surface(nonlinear_subdivision=1, algorithm="dataset_surface")
    assert area(points[surface.points], surface.triangles) == pytest.approx(expected.area)
    assert len(surface.points) == len(points) - (kind == 29), "the middle of a hexahedron is not seen"


def element(kind: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes of an element as VTK places them, mapped so that no two facets are alike."""
    generic = vtkGenericCell()
    generic.SetCellType(kind)
    places = np.reshape(generic.GetParametricCoords(), (-1, 3))[: generic.GetNumberOfPoints()]
    return places * [1.0, 1.3, 0.7] + 0.1 * places[:, [1, 2, 0]], np.arange(len(places))


def test_a_rigid_body_is_an_outline_to_be_filled_and_no_shell() -> None:
    rings = ring_bodies(0.1)
    grid = replace(rings, cell_data={**rings.cell_data, "rigid": rings.cell_data["cell_id"]})
    surface = surface_of(grid)
    assert area(grid.points[surface.points], surface.triangles) == pytest.approx(1 - 0.8**2), "of the first ring only"
    assert len(surface.loops) == len(surface.rigid) == 1
    corners = grid.points[surface.points][surface.rigid[0]]
    assert sorted(corners[:, 0].tolist()) == [1.0, 1.0, 2.0, 2.0], "the outer edge of the second ring"
    assert set(surface.owner[surface.rigid[0]].tolist()) == {1}
    assert is_of_rigid(grid).tolist() == [False] * 8 + [True] * 8 and not is_of_rigid(rings).any()


def test_rings_are_covered_and_outlined() -> None:
    grid = ring_bodies(0.1)
    surface = surface_of(grid)
    assert area(grid.points[surface.points], surface.triangles) == pytest.approx(2 * (1 - 0.8**2))
    assert len(surface.loops) == 2
