"""Onset of gap growth: one definition for all curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

#: Mean gap, as a share of the wall's thickness, at which gaps count as growing.
ONSET = 0.05


def growth_onset(displacement: Sequence[float], mean_gap: Sequence[float], thickness: float) -> float | None:
    """Return the plate displacement at which the mean gap first reaches `ONSET` wall thicknesses; None if it does not.

    The curve is interpolated linearly between the origin and the given points, so gaps count as closed before the
    first step.

    Parameters
    ----------
    displacement : sequence of float
        Plate displacements, in the order of the load path [length].
    mean_gap : sequence of float
        Mean gaps at these [length].
    thickness : float
        Wall thickness [length].
    """
    x, y = np.concatenate([[0.0], displacement]), np.concatenate([[0.0], mean_gap])
    above = np.flatnonzero(y >= ONSET * thickness)
    if not len(above):
        return None
    end = above[0]
    share = (ONSET * thickness - y[end - 1]) / (y[end] - y[end - 1])
    return float(x[end - 1] + share * (x[end] - x[end - 1]))
