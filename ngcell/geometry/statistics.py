"""What a tissue is made of, in numbers: cells, areas, walls and neighbours."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.outlines import Outlines

Array = NDArray[np.float64]


def tissue_table(outlines: Outlines, wall: Array | float, collapsed: int = 0) -> dict[str, Any]:
    """Return the numbers of the cells of a layer by name.

    Parameters
    ----------
    outlines : Outlines
        The cells.
    wall : float or array of float, shape (cells,)
        Thickness of their walls [length].
    collapsed : int
        Number of sides that were too short for the wall.
    """
    shared = outlines.twins >= 0
    pairs = np.column_stack([outlines.cell, outlines.neighbours])[shared]
    neighbours = np.bincount(np.unique(pairs, axis=0)[:, 0], minlength=outlines.cell_count)
    lumens = Outlines(outlines.moved_inwards(wall), outlines.counts, outlines.twins).areas
    sizes = np.bincount(neighbours)
    return {
        "cells": outlines.cell_count,
        "pores": outlines.pore_count,
        "walls_between_cells": int(shared.sum()) // 2,
        "outer_walls": int((~shared).sum()),
        "collapsed_sides": collapsed,
        "cells_by_neighbours": {str(number): int(sizes[number]) for number in np.flatnonzero(sizes)},
        "area": _distribution(outlines.areas),
        "wall_thickness": _distribution(outlines.of_cells(wall)),
        "solid_share_of_area": _distribution(1 - lumens / outlines.areas),
        "wall_length": _distribution(outlines.lengths),
    }


def _distribution(values: Array) -> dict[str, float]:
    spread = values.std() if np.ptp(values) else 0.0  # without round-off
    found = {"mean": values.mean(), "standard_deviation": spread, "smallest": values.min()}
    return {name: float(value) for name, value in {**found, "largest": values.max()}.items()}
