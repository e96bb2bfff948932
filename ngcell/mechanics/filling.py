"""What cells hold, as loads: cells under the same pressure share a boundary region and one term of the energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.scene import CellPressure, Pressure, Tissue

Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Filling:
    """Regions of inner walls and the loads on them.

    Attributes
    ----------
    regions : dict of str to array of int
        Cells whose inner walls belong to each region.
    loads : tuple of Pressure
        Pressures on regions.
    """

    regions: dict[str, Index]
    loads: tuple[Pressure, ...]


def cell_pressures(lumen: CellPressure, tissue: Tissue) -> Filling:
    """Return the pressures of all cells, which are numbered row by row, the lowest row first."""
    pressure = np.broadcast_to(np.asarray(lumen.pressure, dtype=float), (tissue.rows, tissue.cols)).ravel()
    values, group = np.unique(pressure, return_inverse=True)
    regions = {f"lumen{number}": np.flatnonzero(group == number) for number in range(len(values))}
    loads = (Pressure(name, float(value)) for name, value in zip(regions, values, strict=True) if value > 0)
    return Filling(regions, tuple(loads))
