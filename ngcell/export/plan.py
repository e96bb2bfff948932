"""The plan of a tissue: where its cells are, and the walls that they share, at rest.

Layers of prisms are laid out side by side, the lowest first. They all have the walls of the uppermost one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.export.outline import cell_loops, planar_view
from ngcell.results.snapshot import Grid

Array = NDArray[np.float64]

#: Distance between layers, as a share of a layer's width.
_APART = 1.1
#: Places that differ in the seventh digit are two.
_DIGITS = 7


def places(cells: Grid) -> tuple[Array, NDArray[np.integer]]:
    """Return the places of cells in the plan, shape (cells, 2), and their layers, which stand side by side.

    The place of a cell is the mean of its points in the reference state.
    """
    centre, layer = _centres(cells)
    return centre + _beside(cells, layer), layer


def wall_lines(cells: Grid, pairs: NDArray[np.integer]) -> list[Array]:
    """Return the lines that each pair of cells of a layer shares, shape (lines, 2, 2).

    Parameters
    ----------
    cells : Grid
        The bodies, with `cell_id`.
    pairs : array of int, shape (pairs, 2)
        The two cells of each pair.

    Notes
    -----
    Where cells share no line, since they are apart at rest or overlap, a line crosses that of their centres midway.
    """
    centre, layer = _centres(cells)
    top = np.flatnonzero(layer == layer.max())
    above = top[[int(np.linalg.norm(centre[top] - place, axis=1).argmin()) for place in centre]]
    shared = _shared_lines(cells)
    beside = _beside(cells, layer)
    found = []
    for one, two in pairs:
        names = sorted((int(above[one]), int(above[two])))
        lines = shared.get((names[0], names[1]))
        found.append((_between(centre[one], centre[two]) if lines is None else lines) + beside[one])
    return found


def _between(one: Array, two: Array) -> Array:
    """Return a line of the length of a hexagon's side across the middle between the centres of two, (1, 2, 2)."""
    half = (two - one)[::-1] * [-0.5, 0.5] / np.sqrt(3)
    return np.asarray([[(one + two) / 2 - half, (one + two) / 2 + half]])


def _shared_lines(cells: Grid) -> dict[tuple[int, int], Array]:
    """Return the lines that are on the outlines of two cells, by the two, each (lines, 2, 2)."""
    view = planar_view(cells)
    loops = [loop for loop in cell_loops(view) if loop.outer]
    lines = [np.stack([loop.points, np.roll(loop.points, -1)], axis=1) for loop in loops]
    ends = view.points[np.concatenate(lines), :2]
    owner = np.repeat([loop.cell_id for loop in loops], [len(line) for line in lines])
    # The offset keeps middles away from the halves, which round up or down by chance.
    middle = np.round(ends.mean(1) / np.ptp(ends, axis=(0, 1)).max() * 10**_DIGITS + 0.137).astype(np.int64)
    _, number, count = np.unique(middle, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(number.ravel(), kind="stable")
    order = order[count[number.ravel()[order]] == 2]
    found: dict[tuple[int, int], list[Array]] = {}
    for one, two in order.reshape(-1, 2):
        low, high = sorted((int(owner[one]), int(owner[two])))
        found.setdefault((low, high), []).append(ends[one])
    return {pair: np.array(parts) for pair, parts in found.items()}


def _centres(cells: Grid) -> tuple[Array, NDArray[np.integer]]:
    owner = np.repeat(np.ravel(cells.cell_data["cell_id"]), cells.cells.shape[1])
    count = np.bincount(owner)
    points = cells.points[cells.cells.ravel()]
    centre = np.column_stack([np.bincount(owner, points[:, axis]) / np.maximum(count, 1) for axis in range(3)])
    tallest = float(np.ptp(cells.points[:, 2]))
    _, layer = np.unique((centre[:, 2] / (tallest or 1.0)).round(6), return_inverse=True)
    return centre[:, :2], layer.ravel()


def _beside(cells: Grid, layer: NDArray[np.integer]) -> Array:
    """Return how far each cell is moved along x for its layer to stand beside the others, shape (cells, 2)."""
    return np.outer(layer, [_APART * float(np.ptp(cells.points[:, 0])), 0.0])
