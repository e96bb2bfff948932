"""The load at which the first wall would rupture, and how sure it is.

The largest utilisation u of all walls is known at the accepted steps. Between the last one below 1 and the first one
above, the load factor at which it reaches 1 is interpolated linearly, and errs by

- what the mesh makes u err by, over the slope of u between the two;
- what the line leaves of the parabolas through these two steps and the one before, or behind: for parabolas it is
  ``|d (x - x0) (x - x1)|`` over the slope, with the second divided difference d. Where no third step is known, it is
  half of the distance between the two.

The load does not lie outside of the two steps while u grows between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan, nan

import numpy as np
from numpy.typing import NDArray

from ngcell.results.record import StepRecord

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RuptureLoad:
    """The load at which the first wall would rupture.

    Attributes
    ----------
    load_factor, error : float
        It, and by how much it may err; the error is NaN where none of the mesh was estimated.
    interpolation_error : float
        What of the error is that of interpolation.
    between : tuple of float
        Load factors of the two steps around it; both the first step's where walls had ruptured there already, and
        nobody knows how much earlier.
    cell : int
        The cell whose wall is nearest to rupture behind it.
    place : tuple of float
        Where, at rest [length].
    """

    load_factor: float
    error: float
    interpolation_error: float
    between: tuple[float, float]
    cell: int
    place: tuple[float, float]


def rupture_load(records: Sequence[StepRecord], *, starts_at_rest: bool) -> RuptureLoad | None:
    """Return the load at which the first wall would rupture along the released steps; None where none does.

    Steps whose utilisation is not known, since an element is inverted, are left out.
    """
    released = [record for record in records if record.phase == "released"]
    found = [record for record in released if not isnan(record.more["utilisation"])]
    above = [number for number, record in enumerate(found) if record.more["utilisation"] >= 1]
    if not above:
        return None
    end, rest = above[0], int(starts_at_rest)
    load = np.array([0.0] * rest + [record.load_factor for record in found])
    share = np.array([0.0] * rest + [record.more["utilisation"] for record in found])
    error = np.array([0.0] * rest + [record.more["utilisation_error"] for record in found])
    more, last = found[end].more, end + rest
    where = int(more["utilisation_cell"]), (more["utilisation_x"], more["utilisation_y"])
    if last == 0 or load[last] == load[last - 1]:
        at = found[end].load_factor
        return RuptureLoad(at, nan, nan, (at, at), *where)
    step, rise = load[last] - load[last - 1], share[last] - share[last - 1]
    part = (1 - share[last - 1]) / rise
    at, slope = float(load[last - 1] + part * step), abs(rise / step)
    curved = _interpolation_error(load, share, last, at)
    of_mesh = (1 - part) * error[last - 1] + part * error[last]
    between = float(load[last - 1]), float(load[last])
    return RuptureLoad(at, float(of_mesh / slope) + curved, curved, between, *where)


def _interpolation_error(load: Array, share: Array, last: int, at: float) -> float:
    """Return by how much the load factor may err that lies on the line between two steps, `last` the second."""
    slope = (share[last] - share[last - 1]) / (load[last] - load[last - 1])
    errors = []
    for other in (last - 2, last + 1):
        if 0 <= other < len(load) and load[other] not in (load[last], load[last - 1]):
            beside = (share[other] - share[last]) / (load[other] - load[last])
            second = (beside - slope) / (load[other] - load[last - 1])
            errors.append(abs(second * (at - load[last - 1]) * (at - load[last]) / slope))
    return float(max(errors)) if errors else abs(float(load[last] - load[last - 1])) / 2
