"""Cell pressure: cells under the same pressure share a boundary region and one load."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.scene import CellPressure, Pressure, Tissue

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class LumenPressures:
    """Regions of inner walls and the loads on them.

    Attributes
    ----------
    regions : dict of str to array of int
        Cells whose inner walls belong to each region.
    loads : tuple of Pressure
        Pressures on regions.
    pressure : array of float, shape (cells,)
        Pressure in each cell at load factor 1 [stress].
    """

    regions: dict[str, Index]
    loads: tuple[Pressure, ...]
    pressure: Array


def cell_pressures(lumen: CellPressure, tissue: Tissue) -> LumenPressures:
    """Return the pressures of all cells, which are numbered layer by layer and row by row, the lowest first."""
    rows = tissue.layers * tissue.rows
    pressure = np.broadcast_to(np.asarray(lumen.pressure, dtype=float), (rows, tissue.cols)).ravel()
    values, group = np.unique(pressure, return_inverse=True)
    regions = {f"lumen{number}": np.flatnonzero(group == number) for number in range(len(values))}
    loads = (Pressure(name, float(value)) for name, value in zip(regions, values, strict=True) if value > 0)
    return LumenPressures(regions, tuple(loads), pressure)
