"""Roots in the unit interval, one of each of many functions.

A projection that has not settled is not the closest point: the gap is then too large by the square of what it misses,
and the derivatives of the gap, which are those at a closest point, by what it misses. On edges that bend sharply
Newton's method alone takes dozens of steps, or goes to and fro. So the root is kept between bounds that move towards
it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Change of a coordinate below which a root has settled; halvings alone come to it in 44 steps.
_SETTLED = 1e-13
_MOST = 60


def unit_roots(function: Callable[[Index, Array], tuple[Array, Array]], start: Array) -> Array:
    """Return where functions change from negative to positive; 0 or 1 where they do outside of the unit interval.

    Parameters
    ----------
    function : callable
        Takes the numbers of functions and a coordinate for each, and returns values and positive rates, by which
        Newton's method takes its steps.
    start : array of float, shape (n,)
        Where to begin, in [0, 1].
    """
    found, moving = start.copy(), np.arange(len(start))
    low, high = np.full(len(start), -np.inf), np.full(len(start), np.inf)
    for _ in range(_MOST):
        if not len(moving):
            break
        at = found[moving]
        value, rate = function(moving, at)
        low[moving] = np.where(value <= 0, at, low[moving])
        high[moving] = np.where(value >= 0, at, high[moving])
        below, above = low[moving], high[moving]
        after = np.clip(at - value / rate, 0, 1)
        middle = (np.clip(below, 0, 1) + np.clip(above, 0, 1)) / 2
        after = np.where((after > below) & (after < above), after, middle)
        found[moving] = after
        moving = moving[np.abs(after - at) > _SETTLED]
    return found
