"""What is seen of bodies: triangles, and the lines along which their surface has an edge.

Planar bodies are covered by triangles of the nodes of their elements, and rigid ones outlined; of solids only facets
that no second element of the same cell has are drawn. Nodes of neighbouring elements may be given twice: facets are
compared by the places of their corners in the reference state.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import OutputError
from ngcell.export.outline import SHAPES, bodies_that_are, cell_loops, triangulate
from ngcell.results.snapshot import Grid

Index = NDArray[np.integer]

#: Facets of VTK's solid cell types, corners first and in order, then the nodes of edges and, if any, the middle.
_FACETS: dict[int, tuple[tuple[int, ...], ...]] = {
    24: ((0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (2, 0, 3, 6, 7, 9), (0, 2, 1, 6, 5, 4)),
    29: (
        (0, 4, 7, 3, 16, 15, 19, 11, 20), (1, 2, 6, 5, 9, 18, 13, 17, 21), (0, 1, 5, 4, 8, 17, 12, 16, 22),
        (3, 7, 6, 2, 19, 14, 18, 10, 23), (0, 3, 2, 1, 11, 10, 9, 8, 24), (4, 5, 6, 7, 12, 13, 14, 15, 25),
    ),
    32: (
        (0, 2, 1, 8, 7, 6), (3, 4, 5, 9, 10, 11),
        (0, 1, 4, 3, 6, 13, 9, 12, 15), (1, 2, 5, 4, 7, 14, 10, 13, 16), (2, 0, 3, 5, 8, 12, 11, 14, 17),
    ),
}  # fmt: skip
#: VTK type of a facet with so many nodes.
_FACET_TYPE = {6: 22, 9: 28}
#: Facets that meet at more than this angle have an edge between them [degree].
_EDGE_ANGLE = 30.0


@dataclass(frozen=True, eq=False)
class Surface:
    """What is drawn of a grid, as numbers of its points.

    Attributes
    ----------
    points : array of int, shape (points,)
        Points of the grid that are drawn.
    triangles : array of int, shape (triangles, 3)
        Places in `points`.
    lines : array of int, shape (lines, 2)
        Ends of the lines, as places in `points`.
    owner : array of int, shape (points,)
        Cell that each point belongs to.
    loops : list of array of int
        Closed outer lines around planar cells, as places in `points`; empty for solids.
    rigid : list of array of int
        Closed outer lines around rigid bodies, which are shells for the solver only, likewise.
    """

    points: Index
    triangles: Index
    lines: Index
    owner: Index
    loops: list[Index]
    rigid: list[Index]


def is_solid(grid: Grid) -> bool:
    """Return whether the bodies of a grid are three-dimensional."""
    return grid.cell_type in _FACETS


def surface_of(grid: Grid) -> Surface:
    """Return what is drawn of bodies.

    Raises
    ------
    OutputError
        If their elements are of a type that is not known here.
    """
    owner = owner_of_points(grid)
    loops: list[Index] = []
    rigid: list[Index] = []
    if is_solid(grid):
        triangles, lines = _solid_surface(grid)
    else:
        triangles, lines, loops, rigid = _planar_surface(grid)
    points = np.unique(np.concatenate([triangles.ravel(), lines.ravel()]))
    number = np.zeros(len(grid.points), dtype=np.int64)
    number[points] = np.arange(len(points))
    return Surface(
        points=points,
        triangles=number[triangles],
        lines=number[lines],
        owner=owner[points],
        loops=[number[loop] for loop in loops],
        rigid=[number[loop] for loop in rigid],
    )


def is_of_rigid(grid: Grid) -> NDArray[np.bool_]:
    """Return which points are those of rigid bodies, which carry no fields, shape (points,)."""
    return np.isin(owner_of_points(grid), list(bodies_that_are("rigid", grid)))


def owner_of_points(grid: Grid) -> Index:
    """Return the cell that each point belongs to, shape (points,)."""
    owner = np.zeros(len(grid.points), dtype=np.int64)
    owner[grid.cells] = np.asarray(grid.cell_data["cell_id"], dtype=np.int64)[:, None]
    return owner


def wall_triangles(grid: Grid) -> Index:
    """Return triangles of points that cover walls of solids, shape (triangles, 3)."""
    return triangulate(grid)


def wall_lines(grid: Grid) -> Index:
    """Return the ends of lines that make up walls in the plane, shape (lines, 2)."""
    cells = grid.cells
    if not len(cells):  # nothing that may be touched
        return np.zeros((0, 2), dtype=np.int64)
    if cells.shape[1] == 3:  # two corners and the node between them
        return np.concatenate([cells[:, [0, 2]], cells[:, [2, 1]]])
    if cells.shape[1] == 2:
        return cells
    raise OutputError(f"cannot draw walls of VTK type {grid.cell_type}")


def _planar_surface(grid: Grid) -> tuple[Index, Index, list[Index], list[Index]]:
    """Return triangles and lines of planar bodies, and the outer lines around cells and around rigid bodies."""
    rigid = bodies_that_are("rigid", grid)
    around = [loop for loop in cell_loops(grid) if loop.outer or loop.cell_id not in rigid]
    lines = np.concatenate([np.column_stack([loop.points, np.roll(loop.points, -1)]) for loop in around])
    outer = [loop for loop in around if loop.outer]
    return (
        triangulate(replace(grid, cells=grid.cells[~np.isin(grid.cell_data["cell_id"], list(rigid))], cell_data={})),
        lines,
        [loop.points for loop in outer if loop.cell_id not in rigid],
        [loop.points for loop in outer if loop.cell_id in rigid],
    )


def _solid_surface(grid: Grid) -> tuple[Index, Index]:
    """Return triangles and lines of solids, as numbers of their points."""
    corner_number = _numbered_places(grid)
    triangles, edges, normals = [], [], []
    for facets, corners in _outer_facets(grid, corner_number):
        triangles.append(facets[:, np.array(SHAPES[_FACET_TYPE[facets.shape[1]]].triangles)].reshape(-1, 3))
        one = np.arange(corners)
        two = (one + 1) % corners
        edges.append(np.stack([facets[:, one], facets[:, corners + one], facets[:, two]], axis=-1).reshape(-1, 3))
        a, b, c = (grid.points[facets[:, place]] for place in (0, 1, 2))
        normals.append(np.repeat(_unit(np.cross(b - a, c - a)), corners, axis=0))
    found = np.concatenate(edges)
    sharp = _is_sharp(np.sort(corner_number[found[:, [0, 2]]], axis=1), np.concatenate(normals))
    found = found[sharp]
    return np.concatenate(triangles), np.concatenate([found[:, :2], found[:, 1:]])


def _outer_facets(grid: Grid, corner_number: Index) -> list[tuple[Index, int]]:
    """Return the facets that only one element has, as (facets, nodes), with the number of their corners."""
    by_size: dict[int, list[Index]] = {}
    for facet in _FACETS[grid.cell_type]:
        by_size.setdefault(len(facet), []).append(grid.cells[:, facet])
    found = []
    for size, parts in by_size.items():
        facets, corners = np.concatenate(parts), 3 if size == 6 else 4
        keys = np.sort(corner_number[facets[:, :corners]], axis=1)
        _, number, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
        found.append((facets[count[number.ravel()] == 1], corners))
    return found


def _numbered_places(grid: Grid) -> Index:
    """Number points so that coincident ones of the same cell have the same number, shape (points,)."""
    size = float(np.ptp(grid.points, axis=0).max(initial=0.0)) or 1.0
    rounded = np.round(grid.points / size * 1e7 + 0.137).astype(np.int64)  # away from halves, as outlines are
    keys = np.column_stack([owner_of_points(grid), rounded])
    return np.asarray(np.unique(keys, axis=0, return_inverse=True)[1].ravel())


def _is_sharp(ends: Index, normals: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the first of each pair of edges with the same ends whose facets meet at an angle, and single ones."""
    order = np.lexsort(ends.T)
    same = (ends[order][1:] == ends[order][:-1]).all(1)
    flat = np.abs((normals[order][1:] * normals[order][:-1]).sum(1)) > np.cos(np.radians(_EDGE_ANGLE))
    first, second = np.append(same, False), np.insert(same, 0, False)
    sharp = ~second & ~(first & np.append(flat, False))
    result = np.zeros(len(ends), dtype=bool)
    result[order] = sharp
    return result


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1.0))
