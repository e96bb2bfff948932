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

#: Smallest length of a side of a lumen, as a share of the wall's thickness: shorter ones leave slivers.
SHORTEST = 0.05
#: Divisor in place of zero.
_TINY = 1e-300
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
    inside, outside = outlines.polygons_with(np.where(good[outlines.cell, None], lumen, 0.0)), outlines.polygons
    good &= shapely.is_valid(outside) & shapely.is_valid(inside)
    good[good] = shapely.contains_properly(outside[good], inside[good])
    return np.asarray(good, dtype=bool)


def largest_wall(outlines: Outlines, cell: int, wall: float) -> float:
    """Return the largest thickness below `wall` [length] that can be swept in a cell; 0 if none can."""
    low, high = 0.0, min(wall, float(np.ptp(outlines.corners[outlines.cell == cell], axis=0).max()))
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
    cell, count = int(np.argmin(good)), int((~good).sum())
    x, y = outlines.corners[outlines.cell == cell].mean(0)
    thickness = float(outlines.of_cells(wall)[cell])
    largest = largest_wall(outlines, cell, thickness)
    raise GeometryError(
        f"{name} {cell}, about ({x:.4g}, {y:.4g}): its wall of {thickness:.4g} closes its lumen, or one side of it; "
        f"allowed: 0 < wall < {largest:.4g} in this cell" + (f" (one of {count} such cells)" if count > 1 else "")
    )


def check_corners(outlines: Outlines, wall: Array | float, cut: float) -> None:
    """Check that outer corners can be rounded, each of which loses this length of both of its sides.

    Raises
    ------
    GeometryError
        If a side is shorter than what its corners lose, or an arc cuts through the wall.
    """
    half = np.maximum(outlines.exterior_angles, 0.0) / 2
    # The arc's radius is cut / tan(half); it passes the wall's inner corner at wall = radius (1 - cos(half)).
    through = outlines.of_cells(wall)[outlines.cell] / np.maximum(np.tan(half / 2) * np.cos(half), _TINY)
    for limits, what in ((outlines.lengths / 2, "meet on one of its sides"), (through, "cut through its wall")):
        corner = int(limits.argmin())
        if cut >= limits[corner]:
            x, y = outlines.corners[corner]
            raise GeometryError(
                f"round corners of cell {outlines.cell[corner]} {what}, about ({x:.4g}, {y:.4g}); "
                f"allowed: 0 <= corner_radius < {np.sqrt(3) * limits[corner]:.4g}"
            )
