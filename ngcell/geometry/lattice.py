"""The hexagonal lattice: where the cells sit, and which of their walls lie on the hull of the patch.

Wall k of a cell is the one between its corners k and k+1, counted anticlockwise; its outward normal has the angle
``first_angle + 60 (k + 1/2)`` degrees. Facing walls are found from coincident midpoints, never listed by hand.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.near import near_pairs
from ngcell.geometry.outlines import Outlines

WALLS = 6


@dataclass(frozen=True, eq=False)
class Lattice:
    """Cells of a regular hexagonal lattice.

    Attributes
    ----------
    centres : array of float, shape (cells, 2)
        Centres of the cells [length].
    row_of_cell : array of int, shape (cells,)
        Row of each cell, from the bottom.
    side : float
        Side of the hexagons [length], > 0.
    first_angle : float
        Angle of corner 0 [radian].
    """

    centres: NDArray[np.float64]
    row_of_cell: NDArray[np.int64]
    side: float
    first_angle: float

    @property
    def apothem(self) -> float:
        """Distance from a centre to the middle of a wall [length]."""
        return float(self.side * np.sqrt(3) / 2)

    @property
    def corners(self) -> NDArray[np.float64]:
        """Corners of a cell about its centre [length], shape (6, 2)."""
        angle = self.first_angle + np.pi / 3 * np.arange(WALLS)
        return self.side * np.column_stack([np.cos(angle), np.sin(angle)])

    @property
    def normals(self) -> NDArray[np.float64]:
        """Outward unit normals of a cell's walls, shape (6, 2)."""
        angle = self.first_angle + np.pi / 3 * (np.arange(WALLS) + 0.5)
        return np.column_stack([np.cos(angle), np.sin(angle)])

    @cached_property
    def neighbours(self) -> NDArray[np.int64]:
        """Cell on the other side of each wall, -1 on the hull; shape (cells, 6)."""
        across = self.centres[:, None] + 2 * self.apothem * self.normals
        count = len(self.centres)
        cell, wall = near_pairs(np.concatenate([self.centres, across.reshape(-1, 2)]), 1e-6 * self.side)
        is_wall = (cell < count) & (wall >= count)
        beyond = np.full(count * WALLS, -1)
        beyond[wall[is_wall] - count] = cell[is_wall]
        return beyond.reshape(-1, WALLS)

    @cached_property
    def outlines(self) -> Outlines:
        """Outlines of the cells; wall k of a cell starts at its corner k."""
        opposite = (np.arange(WALLS) + WALLS // 2) % WALLS
        twins = np.where(self.neighbours < 0, -1, WALLS * self.neighbours + opposite)
        corners = self.centres[:, None] + self.corners
        return Outlines(corners.reshape(-1, 2), np.full(len(self.centres), WALLS), twins.ravel())

    def hull_walls(self, row: int, upward: float) -> NDArray[np.bool_]:
        """Return which walls of a row lie on the hull and face up (`upward` = 1) or down (-1); (cells, 6)."""
        faces = upward * self.normals[:, 1] > 1e-6
        return np.asarray((self.neighbours < 0) & faces & (self.row_of_cell == row)[:, None])


def hexagonal_lattice(rows: int, cols: int, *, side: float, pointy: bool) -> Lattice:
    """Return `rows` times `cols` hexagons; pointy ones stand on a corner, every second row moved by half a cell.

    Flat ones stand on a wall; there every second column is moved up by half a cell.
    """
    row, col = (index.ravel() for index in np.divmod(np.arange(rows * cols), cols))
    width = np.sqrt(3) * side
    if pointy:
        centres = np.column_stack([width * (col + 0.5 * (row % 2)), 1.5 * side * row])
        return Lattice(centres, row, side, np.pi / 6)
    centres = np.column_stack([1.5 * side * col, width * (row + 0.5 * (col % 2))])
    return Lattice(centres, row, side, 0.0)
