"""Onset of gap growth: one definition for all curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

#: Mean gap, as a share of the wall's thickness, at which gaps count as growing.
ONSET = 0.05


def growth_onset(
    displacement: Sequence[float], mean_gap: Sequence[float], thickness: float, *, at_rest: float | None = 0.0
) -> float | None:
    """Return the plate displacement at which the mean gap first reaches `ONSET` wall thicknesses; None if it does not.

    The curve is interpolated linearly between the given points.

    Parameters
    ----------
    displacement : sequence of float
        Plate displacements, in the order of the load path [length].
    mean_gap : sequence of float
        Mean gaps at these [length].
    thickness : float
        Wall thickness [length].
    at_rest : float, optional
        Mean gap without displacement, where the curve starts [length]. None if nobody knows it, since something acts
        in full before the load: the curve then starts at the first point, and where gaps have grown there already,
        that is what is returned, the smallest bound that is known.
    """
    x, y = np.asarray(displacement, dtype=float), np.asarray(mean_gap, dtype=float)
    if at_rest is not None:
        x, y = np.concatenate([[0.0], x]), np.concatenate([[at_rest], y])
    above = np.flatnonzero(y >= ONSET * thickness)
    if not len(above):
        return None
    end = above[0]
    if end == 0:
        return float(x[0])
    share = (ONSET * thickness - y[end - 1]) / (y[end] - y[end - 1])
    return float(x[end - 1] + share * (x[end] - x[end - 1]))
