"""What is reported of each cell: the pressure in it, and the connected component that it belongs to."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.results.measure import Measurement
from ngcell.results.record import CellRecord, WallRecord
from ngcell.results.rupture.cells import BURST, ENDS, CellEnds, end_of
from ngcell.results.walls import CellComponents

Array = NDArray[np.float64]


def cell_records(
    found: CellComponents,
    measured: Measurement,
    step: int,
    plate_displacement: float,
    pressure: Array | None,
    ends: CellEnds | None = None,
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
            more={} if ends is None else ends.columns(cell),
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
        **_ends(cells),
    }


def end_of_cell(row: CellRecord) -> str:
    """Return how a cell has ended until this row: one of `ngcell.results.rupture.cells.ENDS`; empty where nobody knows.
    """
    return end_of(row.more["burst_at"], row.more["separated_at"]) if row.more else ""


def _ends(cells: Sequence[CellRecord]) -> dict[str, Any]:
    """Return how cells have ended, and the energy of those that have burst; nothing where nobody knows what walls bear.
    """
    if not cells[0].more:
        return {}
    found = {end: [row.cell for row in cells if end_of_cell(row) == end] for end in ENDS}
    first = [row.more["separated_at"] for row in cells if not isnan(row.more["separated_at"])]
    energy = sum((row.more["burst_energy"] for row in cells if end_of_cell(row) == BURST), 0.0)
    return {"cells": found, "first_separation": min(first, default=None), "burst_energy": energy}
