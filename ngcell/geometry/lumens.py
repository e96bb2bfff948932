"""Whether outlines can be swept: how much of a cell its wall leaves open.

A ring covers each of its points once if all of its quadrangles, one a side, are the right way out, and its lumen is a
polygon that does not cross itself and lies inside the outline: the number of quadrangles over a point is how often the
outline winds around it, less how often the lumen does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.outlines import Outlines

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Smallest length of a side of a lumen, as a share of the wall's thickness: shorter ones leave slivers.
SHORTEST = 0.05
#: Halvings by which the largest thickness of a wall is found.
_HALVINGS = 30


def can_be_swept(outlines: Outlines, wall: Array | float) -> NDArray[np.bool_]:
    """Return for each cell whether walls of this thickness leave it one lumen with all of its sides, shape (cells,)."""
    import shapely

    thickness = outlines.of_cells(wall)
    with np.errstate(divide="ignore", invalid="ignore"):
        lumen = outlines.moved_inwards(wall)
        along = ((lumen[outlines.ahead] - lumen) * outlines.directions).sum(1)
    is_kept = np.isfinite(lumen).all(1) & (along >= SHORTEST * thickness[outlines.cell])
    good = np.bincount(outlines.cell[~is_kept], minlength=outlines.cell_count) == 0
    asked = np.flatnonzero(good)
    inside, outside = (polygons(corners, outlines, asked) for corners in (lumen, outlines.corners))
    good[asked] = shapely.is_valid(outside) & shapely.is_valid(inside)
    good[good] = shapely.contains_properly(outside[good[asked]], inside[good[asked]])
    return np.asarray(good)


def polygons(corners: Array, outlines: Outlines, cells: Index) -> NDArray[np.object_]:
    """Return the polygons of some cells, with these corners in place of those of the outlines, shape (cells,)."""
    import shapely

    taken = np.isin(outlines.cell, cells)
    rank = np.searchsorted(cells, outlines.cell[taken])
    return np.asarray(shapely.polygons(shapely.linearrings(corners[taken], indices=rank)))


def largest_wall(outlines: Outlines, cell: int, wall: float) -> float:
    """Return the largest thickness below `wall` [length] that can be swept in a cell; 0 if none can."""
    low, high = 0.0, wall
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if can_be_swept(outlines, middle)[cell] else (low, middle)
    return low


def check_lumens(outlines: Outlines, wall: Array | float, name: str = "cell") -> None:
    """Check that walls of this thickness leave every cell an open lumen.

    Raises
    ------
    GeometryError
        If one does not.
    """
    good = can_be_swept(outlines, wall)
    if good.all():
        return
    cell = int(np.argmin(good))
    x, y = outlines.corners[outlines.cell == cell].mean(0)
    thickness = float(outlines.of_cells(wall)[cell])
    largest = largest_wall(outlines, cell, thickness)
    raise GeometryError(
        f"{name} {cell}, about ({x:.4g}, {y:.4g}): its wall of {thickness:.4g} closes its lumen, or one side of it; "
        f"allowed: 0 < wall < {largest:.4g} in this cell" + (f" ({(~good).sum()} cells have such walls)")
    )
