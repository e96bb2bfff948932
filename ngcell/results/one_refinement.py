"""What one refinement tells of the errors of the mesh before: a number may stay by accident while the mesh changes.

Where more meshes have been, what the one before told is remembered (`ngcell.results.error`). One refinement alone tells
at least:

- of the stored energy what it tells of the potential, since what loads and supports do to it may cancel: by linear
  theory it errs by just that where loads or supports alone act, and by less where both do;
- of forces the share of themselves that the energy errs by: they are its derivatives;
- of the mean gap the mean of what the gap of each facet has changed by, whatever its sign.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ngcell.results.gaps_of_pairs import GapsOfPairs


def at_least(
    told: Mapping[str, float],
    energy: float,
    forces: Mapping[str, float | NDArray[np.float64]],
    gaps: tuple[GapsOfPairs | None, GapsOfPairs | None],
) -> dict[str, float]:
    """Return the errors that one refinement tells of the mesh before.

    Parameters
    ----------
    told : mapping
        Errors by the names of numbers, each by what that number has changed by.
    energy : float
        Stored energy, or what nothing is told apart from if that is more [stress * length**dimension].
    forces : mapping
        Forces by name [stress * length**(dimension - 1)].
    gaps : two GapsOfPairs
        Gaps pair by pair before and after; None where they are not known.
    """
    new = dict(told)
    new["energy"] = max(told["energy"], told["potential"])
    for name, force in forces.items():
        new[name] = max(told[name], new["energy"] / energy * float(np.linalg.norm(np.atleast_1d(force))))
    before, after = gaps
    if before is not None and after is not None:
        new["mean_gap"] = max(told["mean_gap"], after.moved_from(before))
    return new
