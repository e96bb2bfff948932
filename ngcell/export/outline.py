"""The planar shape of cells: how a finite element is drawn, and the closed lines around each tissue cell.

A tissue cell is the union of the elements with its number. An edge of an element is on the boundary of that union if
no second element of the same cell has it. Such edges join to loops, outer ones counter-clockwise and those around a
lumen clockwise. Points are compared by their coordinates, not by number, so elements need not share points.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import OutputError
from ngcell.results.snapshot import Grid

_QUAD_RING = (0, 4, 1, 5, 2, 6, 3, 7)
_TRIANGLE_RING = (0, 3, 1, 4, 2, 5)


@dataclass(frozen=True, slots=True)
class ElementShape:
    """Nodes around an element in order, and triangles of its nodes that cover it."""

    ring: tuple[int, ...]
    triangles: tuple[tuple[int, int, int], ...]


def _fan(ring: tuple[int, ...], centre: int) -> ElementShape:
    return ElementShape(ring, tuple((a, b, centre) for a, b in zip(ring, ring[1:] + ring[:1], strict=True)))


SHAPES = {
    5: ElementShape((0, 1, 2), ((0, 1, 2),)),
    9: ElementShape((0, 1, 2, 3), ((0, 1, 2), (0, 2, 3))),
    22: ElementShape(_TRIANGLE_RING, ((0, 3, 5), (3, 1, 4), (4, 2, 5), (3, 4, 5))),
    23: ElementShape(_QUAD_RING, ((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7))),
    28: _fan(_QUAD_RING, 8),
    34: _fan(_TRIANGLE_RING, 6),
}
"""Planar VTK cell types: triangle, quad, and their quadratic and biquadratic forms."""


_HEXAHEDRON, _UPPER_END = 29, (4, 5, 6, 7, 12, 13, 14, 15, 25)


def planar_view(grid: Grid) -> Grid:
    """Return a planar grid as it is; of prisms, of triquadratic hexahedra, their upper ends as seen from above."""
    if grid.cell_type != _HEXAHEDRON:
        return grid
    top = grid.points[grid.cells[:, _UPPER_END], 2]
    seen = (top >= grid.points[:, 2].max() - 1e-9 * np.ptp(grid.points[:, 2])).all(1)
    cell_data = {name: values[seen] for name, values in grid.cell_data.items()}
    return Grid(grid.points, grid.cells[seen][:, _UPPER_END], 28, grid.point_data, cell_data)


def is_drawn_from_above(grid: Grid) -> bool:
    """Return whether a grid is planar, or of prisms; other solids are shown by `ngcell view`."""
    return grid.cell_type in SHAPES or grid.cell_type == _HEXAHEDRON


@dataclass(frozen=True, eq=False, slots=True)
class Loop:
    """A closed line of points around a tissue cell (outer) or around one of its holes."""

    cell_id: int
    points: NDArray[np.integer]
    outer: bool


def element_shape(grid: Grid) -> ElementShape:
    """How the cells of a planar grid are drawn.

    Raises
    ------
    OutputError
        If the cells are not planar, or of a type that is not known here.
    """
    if grid.cell_type not in SHAPES:
        raise OutputError(f"cannot draw cells of VTK type {grid.cell_type}; known are {sorted(SHAPES)}")
    return SHAPES[grid.cell_type]


def triangulate(grid: Grid) -> NDArray[np.integer]:
    """Triangles of points that cover the grid, shape (triangles, 3)."""
    return grid.cells[:, np.array(element_shape(grid).triangles)].reshape(-1, 3)


def bodies_that_are(what: str, grid: Grid) -> set[int]:
    """Return the bodies that this field of a grid marks by 1, as `free` and `rigid` do."""
    marked = np.asarray(grid.cell_data.get(what, np.zeros(len(grid.cells)))) == 1
    return set(np.asarray(grid.cell_data["cell_id"])[marked].tolist())


def cell_loops(grid: Grid) -> list[Loop]:
    """All closed lines around the tissue cells of a planar grid, found in the reference state."""
    rings = _counter_clockwise(grid.cells[:, element_shape(grid).ring], grid.points)
    nodes, owner = rings.ravel(), np.repeat(np.asarray(grid.cell_data["cell_id"]), rings.shape[1])
    first, corner = _merged_corners(grid.points[nodes], owner)
    start, end = corner, np.roll(corner.reshape(rings.shape), -1, axis=1).ravel()
    outside = ~np.isin(start * len(first) + end, end * len(first) + start)
    chains = _chains(zip(start[outside].tolist(), end[outside].tolist(), strict=True))
    return [_loop(nodes[first[chain]], int(owner[first[chain[0]]]), grid.points) for chain in chains]


def _merged_corners(places: NDArray[Any], owner: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Number element corners so that coincident ones of the same tissue cell have the same number.

    Returns the first corner of each number, and the number of each corner.
    """
    size = float(np.ptp(places, axis=0).max(initial=0.0)) or 1.0
    # The offset keeps the points of a regular lattice away from the halves, which round up or down by chance.
    rounded = np.round(places / size * 1e8 + 0.137).astype(np.int64)
    keys = np.column_stack([owner, rounded])
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return first, number.ravel()


def _counter_clockwise(rings: NDArray[Any], points: NDArray[Any]) -> NDArray[Any]:
    corners = points[rings, :2]
    turned = _signed_area(corners) < 0
    return np.where(turned[:, None], rings[:, ::-1], rings)


def _signed_area(polygons: NDArray[Any]) -> NDArray[Any]:
    x, y = polygons[..., 0], polygons[..., 1]
    area: NDArray[np.float64] = 0.5 * np.sum(x * np.roll(y, -1, axis=-1) - np.roll(x, -1, axis=-1) * y, axis=-1)
    return area


def _chains(edges: Iterable[tuple[int, int]]) -> list[list[int]]:
    following = defaultdict(list)
    for start, end in edges:
        following[start].append(end)
    chains = []
    for first in list(following):
        while following[first]:
            chains.append(_follow(following, first))
    return chains


def _follow(following: dict[int, list[int]], first: int) -> list[int]:
    line, point = [], first
    while following[point]:
        line.append(point)
        point = following[point].pop()
    return line


def _loop(points: NDArray[Any], cell_id: int, places: NDArray[Any]) -> Loop:
    return Loop(cell_id, points, bool(_signed_area(places[points, :2]) > 0))
