"""Where the gap starts to grow fast."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def growth_onset(displacement: Sequence[float], mean_gap: Sequence[float]) -> float | None:
    """Return the displacement at which the mean gap starts to grow fast, or None if it cannot be told.

    The curve, from the origin on, is fitted by two straight lines that meet; the onset is where they meet. There is none
    if fewer than four points are given or if the second line is no steeper than twice the first.

    Parameters
    ----------
    displacement : sequence of float
        Plate displacements, increasing [length].
    mean_gap : sequence of float
        Mean gaps at these [length].
    """
    x = np.concatenate([[0.0], displacement])
    y = np.concatenate([[0.0], mean_gap])
    if len(x) < 5:
        return None
    fits = [_hinge(x, y, at) for at in np.linspace(x[1], x[-2], 101)]
    error, at, slope, change = min(fits)
    del error
    return float(at) if change > max(slope, 0) else None


def _hinge(x: np.ndarray, y: np.ndarray, at: float) -> tuple[float, float, float, float]:
    columns = np.column_stack([x, np.maximum(x - at, 0)])
    (slope, change), *_ = np.linalg.lstsq(columns, y, rcond=None)
    return float(((columns @ [slope, change] - y) ** 2).sum()), at, float(slope), float(change)
