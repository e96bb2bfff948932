"""What is reported of each cell: the pressure in it, and the connected component of cells still joined that it belongs to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.filling import filling_pressures
from ngcell.problem.assembly import Assembly
from ngcell.results.measure import Measurement, Scene, cell_components
from ngcell.results.record import CellRecord, WallRecord

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CellComponents:
    """Bodies joined by walls that have not parted.

    Attributes
    ----------
    of_body : array of int, shape (bodies,)
        Clump that each body belongs to.
    sizes : array of int, shape (components,)
        Number of bodies of each component.
    """

    of_body: NDArray[np.int64]
    sizes: NDArray[np.int64]


def find_components(scene: Scene, assembly: Assembly, measured: Measurement) -> CellComponents:
    """Return the components of a step; the tied solid is one."""
    count = assembly.space.bodies.body_count
    component = np.zeros(count, dtype=np.int64)
    if assembly.contact is not None:
        component = cell_components(scene, measured, assembly.space.bodies.thickness)
    return CellComponents(component, np.bincount(component))


def cell_pressures(assembly: Assembly, displacement: Array, given: Array | None) -> Array | None:
    """Return the pressure of what each cell holds [stress], shape (bodies,); None where cells are empty.

    Parameters
    ----------
    assembly : Assembly
        The bodies: their fluids, or what fills them.
    displacement : array of float, shape (unknowns,)
        An equilibrium [length].
    given : array of float, shape (bodies,), optional
        Pressures that cells are under by the case [stress].
    """
    count = assembly.space.bodies.body_count
    if assembly.fluid is not None:
        pressure = np.zeros(count)
        pressure[assembly.fluid.body] = assembly.fluid.pressures(displacement)
        return pressure
    if assembly.bulk.filling is not None:
        return filling_pressures(assembly.space, assembly.bulk.filling, displacement)
    return given


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
