"""What is reported of each cell: the pressure in it, and the connected component that it belongs to."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.results.measure import Measurement
from ngcell.results.record import CellRecord, WallRecord
from ngcell.results.walls import CellComponents

Array = NDArray[np.float64]


def cell_records(
    found: CellComponents, measured: Measurement, step: int, plate_displacement: float, pressure: Array | None
) -> list[CellRecord]:
    """Return a row for each cell of a step."""
    return [
        CellRecord(
            step=step,
            load_factor=measured.load_factor,
            plate_displacement=plate_displacement,
            cell=cell,
            pressure=0.0 if pressure is None else float(pressure[cell]),
            component=int(component),
            component_size=int(found.sizes[component]),
            held=cell not in measured.free_bodies,
        )
        for cell, component in enumerate(found.of_body)
    ]


def debonding(walls: Sequence[WallRecord], cells: Sequence[CellRecord]) -> dict[str, Any]:
    """Return what has come apart at a level, for the summary; nothing between levels."""
    if not cells:
        return {}
    pressures = [row.pressure for row in cells]
    sizes = {row.component: row.component_size for row in cells}
    return {
        "wall_pairs_opened": sum(not isnan(row.onset) for row in walls),
        "wall_pairs_parted": sum(row.parted for row in walls),
        "component_sizes": sorted(sizes.values(), reverse=True),
        "smallest_cell_pressure": min(pressures),
        "largest_cell_pressure": max(pressures),
    }
