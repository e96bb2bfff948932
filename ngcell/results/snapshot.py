"""The fields of one accepted step as plain arrays, independent of any finite element library."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False, slots=True)
class Grid:
    """Points, cells of one VTK type, and the values on them.

    Attributes
    ----------
    points : array of float, shape (points, 3)
        Reference coordinates [length]; the third is 0 in a planar scene.
    cells : array of int, shape (cells, nodes)
        Points of each cell in the node order of its VTK cell type.
    cell_type : int
        VTK cell type of all cells, for instance 28 (biquadratic quadrilateral) or 9 (linear quadrilateral).
    point_data : mapping of str to array, first axis points
        Values at the points.
    cell_data : mapping of str to array, first axis cells
        Values on the cells.

    Raises
    ------
    ValueError
        If the shapes do not agree with each other.
    """

    points: NDArray[np.float64]
    cells: NDArray[np.integer]
    cell_type: int
    point_data: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    cell_data: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3:
            raise ValueError(f"points have shape {self.points.shape}; (points, 3) is needed")
        if self.cells.ndim != 2:
            raise ValueError(f"cells have shape {self.cells.shape}; (cells, nodes) is needed")
        _require_length(self.point_data, len(self.points), "points")
        _require_length(self.cell_data, len(self.cells), "cells")


@dataclass(frozen=True, eq=False, slots=True)
class Snapshot:
    """The fields of one accepted step.

    Attributes
    ----------
    step : int
        Number of the accepted step, from 0.
    load_factor : float
        Share of the case's full load, in [0, 1].
    plate_displacement : float
        Length of the displacement of the moved plate [length], >= 0.
    bulk : Grid
        The bodies. `point_data`: `displacement` (points, 3) [length], `J` (points,) [1] > 0, `cauchy_stress`
        (points, 9) [stress] by rows, `von_mises` (points,) [stress] >= 0. `cell_data`: `cell_id` (cells,),
        the tissue cell that the finite element belongs to, `free` (cells,), 1 where that tissue cell is
        held by nothing, where there are rigid bodies `rigid` (cells,), 1 in them, and, unless lumens are empty,
        the pressure in them `cell_pressure` (cells,) [stress].
    walls : Grid
        The walls that may be in contact: edges in 2-D, facets in 3-D. `point_data`: `displacement` (points, 3)
        [length], `gap` (points,) [length], open > 0, `contact_pressure` (points,) [stress] >= 0. `cell_data`:
        `cell_id` (cells,).

    Both may have further fields under other names.
    """

    step: int
    load_factor: float
    plate_displacement: float
    bulk: Grid
    walls: Grid


def _require_length(data: Mapping[str, NDArray[Any]], length: int, place: str) -> None:
    for name, values in data.items():
        if len(values) != length:
            raise ValueError(f"{name!r} has {len(values)} values on {length} {place}")
