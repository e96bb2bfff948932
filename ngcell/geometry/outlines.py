"""Outlines of cells: polygons of any number of corners, and which of their sides neighbours share.

Corners of all cells stand one after the other, cell by cell and anticlockwise. Side k is the one from corner k to the
next corner of the same cell. A side that two cells share is one whole side of each, from the same corner to the same
corner: where a corner of one cell lies inside a side of another, that side has a corner there, too, of 180 degrees.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Distance as a share of a cell's side below which places are one.
_SAME = 1e-6


@dataclass(frozen=True, eq=False)
class Outlines:
    """The outlines of cells that touch along whole sides and do not overlap.

    Attributes
    ----------
    corners : array of float, shape (corners, 2)
        Corners of all outlines, cell by cell and anticlockwise [length].
    counts : array of int, shape (cells,)
        Number of corners of each cell.
    twins : array of int, shape (corners,)
        For the side that starts at each corner, the same side of the neighbour; -1 where there is none.
    """

    corners: Array
    counts: Index
    twins: Index

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return len(self.counts)

    @cached_property
    def starts(self) -> Index:
        """First corner of each cell, shape (cells,)."""
        return np.asarray(np.cumsum(self.counts) - self.counts)

    @cached_property
    def cell(self) -> Index:
        """Cell of each corner, shape (corners,)."""
        return np.repeat(np.arange(self.cell_count), self.counts)

    @cached_property
    def ahead(self) -> Index:
        """The next corner of the same cell, shape (corners,)."""
        return following(self.counts)

    @cached_property
    def behind(self) -> Index:
        """The corner before in the same cell, shape (corners,)."""
        return np.argsort(self.ahead)

    @cached_property
    def neighbours(self) -> Index:
        """Cell on the other side of each side, -1 where there is none; shape (corners,)."""
        return np.where(self.twins >= 0, self.cell[self.twins], -1)

    @cached_property
    def lengths(self) -> Array:
        """Length of each side [length], shape (corners,)."""
        return np.asarray(np.linalg.norm(self.corners[self.ahead] - self.corners, axis=1))

    @cached_property
    def directions(self) -> Array:
        """Unit vector along each side, shape (corners, 2)."""
        return np.asarray((self.corners[self.ahead] - self.corners) / self.lengths[:, None])

    @cached_property
    def exterior_angles(self) -> Array:
        """Angle by which the outline turns at each corner [radian], > 0 where it is convex; shape (corners,)."""
        before, after = self.directions[self.behind], self.directions
        return np.asarray(np.arctan2(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(1)))

    @cached_property
    def bisectors(self) -> Array:
        """Vector along the bisector of each corner, inwards, whose distance from both sides is 1; (corners, 2)."""
        inward = np.column_stack([-self.directions[:, 1], self.directions[:, 0]])
        before = inward[self.behind]
        return np.asarray((before + inward) / (1 + (before * inward).sum(1))[:, None])

    @cached_property
    def areas(self) -> Array:
        """Area of each cell [length**2], shape (cells,)."""
        return enclosed_areas(self.corners, self)

    @cached_property
    def polygons(self) -> NDArray[np.object_]:
        """Each cell as a polygon of shapely, shape (cells,)."""
        return self.polygons_with(self.corners)

    def polygons_with(self, corners: Array) -> NDArray[np.object_]:
        """Return the polygon of each cell with these corners in place of its own, shape (cells,)."""
        import shapely

        return np.asarray(shapely.polygons(shapely.linearrings(corners, indices=self.cell)))

    @cached_property
    def _parts(self) -> NDArray[np.object_]:
        """The connected parts of what the cells cover together, as polygons of shapely."""
        import shapely

        return np.asarray(shapely.get_parts(shapely.union_all(self.polygons, grid_size=_SAME * self.side)))

    @property
    def pore_count(self) -> int:
        """Number of pores that cells enclose."""
        import shapely

        return int(shapely.get_num_interior_rings(self._parts).sum())

    @cached_property
    def on_hull(self) -> NDArray[np.bool_]:
        """Which sides lie on the hull of the tissue: outer ones, but for those around pores; shape (corners,)."""
        import shapely

        hull = shapely.get_exterior_ring(self._parts)
        outer = np.flatnonzero(self.twins < 0)
        middle = shapely.points((self.corners + self.corners[self.ahead])[outer] / 2)
        found = np.zeros(len(self.corners), dtype=bool)
        near, _ = shapely.STRtree(hull).query(middle, predicate="dwithin", distance=4 * _SAME * self.side)
        found[outer[near]] = True
        return found

    @property
    def side(self) -> float:
        """Side of the regular hexagon of the cells' mean area [length]: the scale of a cell."""
        return float(np.sqrt(self.areas.mean() / (1.5 * np.sqrt(3))))

    def moved_inwards(self, wall: Array | float) -> Array:
        """Return the corners of the lumens, whose sides are this far from those of the outlines, shape (corners, 2).

        Parameters
        ----------
        wall : float or array of float, shape (cells,)
            Thickness of each cell's wall [length].
        """
        return np.asarray(self.corners + self.of_cells(wall)[self.cell, None] * self.bisectors)

    def of_cells(self, value: Array | float) -> Array:
        """Return a value for each cell, whether one is given or one for all."""
        return np.broadcast_to(np.asarray(value, dtype=float), (self.cell_count,))


def following(counts: Index) -> Index:
    """Return the number of the next one around closed lines of so many points each, shape (points,)."""
    ahead = np.arange(1, int(counts.sum()) + 1)
    ends = np.cumsum(counts)
    ahead[ends - 1] = ends - counts
    return ahead


def enclosed_areas(corners: Array, outlines: Outlines) -> Array:
    """Return the areas that polygons with these corners enclose, > 0 if anticlockwise [length**2], shape (cells,)."""
    start = corners - corners[outlines.starts][outlines.cell]
    end = start[outlines.ahead]
    swept = (start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]) / 2
    return np.asarray(np.bincount(outlines.cell, swept, outlines.cell_count), dtype=np.float64)
