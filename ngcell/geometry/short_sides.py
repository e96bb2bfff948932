"""Sides too short for their walls: their ends become one corner, in all cells that have them.

A wall takes from a side of its lumen what its corners need, so that a short side, or one between sharp corners, has
none left. Such sides shrink to a point, the shortest first, until every side of every lumen is long enough.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.near import components
from ngcell.geometry.outlines import Outlines
from ngcell.geometry.partition import outlines_through

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def without_short_sides(outlines: Outlines, wall: Array | float, shortest: float) -> tuple[Outlines, int]:
    """Return outlines without sides whose lumens would have too short a side, and how many sides are gone.

    Parameters
    ----------
    outlines : Outlines
        The cells.
    wall : float or array of float, shape (cells,)
        Thickness of the walls [length].
    shortest : float
        Smallest length of a side of a lumen, as a share of the wall's thickness, >= 0; with 0 no side goes.

    Notes
    -----
    Ends of a side on the hull stay on it: the corner goes where more outer walls with different directions meet, and
    midway between ends that are alike.
    Where a cell would have less than three sides left, its wall is too thick for it: it keeps its sides.
    `ngcell.geometry.lumens.check_lumens` says so if they leave no lumen.
    """
    gone, kept_whole = 0, np.zeros(outlines.cell_count, dtype=bool)
    while shortest > 0 and len(short := _short_sides(outlines, wall, shortest, kept_whole)):
        node = _nodes(outlines)
        rank = _ranks(outlines, node)
        places = np.zeros((node.max() + 1, 2))
        places[node] = outlines.corners
        goal = np.arange(len(places))
        taken = np.zeros(len(places), dtype=bool)
        before = gone
        for one, two in zip(node[short].tolist(), node[outlines.ahead[short]].tolist(), strict=True):
            if taken[one] or taken[two]:
                continue
            kept, other = (two, one) if rank[two] > rank[one] else (one, two)
            if rank[one] == rank[two]:
                places[kept] = (places[one] + places[two]) / 2
            goal[other], taken[[one, two]] = kept, True
            gone += 1
        failing = _with_too_few_sides(outlines, goal[node])
        if failing.any():
            gone, kept_whole = before, kept_whole | failing
            continue
        try:
            outlines = outlines_through(places, goal[node], outlines.counts)
        except GeometryError:  # two cells would come to lie on one side of a wall
            return outlines, before
    return outlines, gone


def _with_too_few_sides(outlines: Outlines, node: Index) -> NDArray[np.bool_]:
    """Return the cells that would have less than three sides through these places, shape (cells,)."""
    is_side = node != node[outlines.ahead]
    return np.bincount(outlines.cell[is_side], minlength=outlines.cell_count) < 3


def _short_sides(
    outlines: Outlines, wall: Array | float, shortest: float, kept_whole: NDArray[np.bool_]
) -> Index:
    """Return the sides whose lumens have too short a side, the shortest first, but for those of cells that are kept."""
    with np.errstate(divide="ignore", invalid="ignore"):
        lumen = outlines.moved_inwards(wall)
        along = ((lumen[outlines.ahead] - lumen) * outlines.directions).sum(1)
    is_kept = kept_whole[outlines.cell]
    is_kept |= (outlines.twins >= 0) & is_kept[outlines.twins]
    short = np.flatnonzero(~(along >= shortest * outlines.of_cells(wall)[outlines.cell]) & ~is_kept)
    return np.asarray(short[np.argsort(outlines.lengths[short], kind="stable")])


def _nodes(outlines: Outlines) -> Index:
    """Return the number of the place of each corner: the same for all cells that meet there."""
    shared = np.flatnonzero(outlines.twins >= 0)
    twin = outlines.twins[shared]
    one = np.concatenate([shared, outlines.ahead[shared]])
    two = np.concatenate([outlines.ahead[twin], twin])
    return components(len(outlines.corners), one, two)


def _ranks(outlines: Outlines, node: Index) -> Index:
    """Return for each place 0 inside of the tissue, 1 on a straight outer wall and 2 where outer walls turn."""
    outer = outlines.twins < 0
    ends = np.zeros((node.max() + 1, 2))
    rank = np.zeros(len(ends), dtype=np.int64)
    rank[node[outer]] = rank[node[outlines.ahead[outer]]] = 1
    np.add.at(ends, node[outer], outlines.directions[outer])
    np.add.at(ends, node[outlines.ahead[outer]], -outlines.directions[outer])
    return np.where(np.linalg.norm(ends, axis=1) > 1e-3, 2, rank)
