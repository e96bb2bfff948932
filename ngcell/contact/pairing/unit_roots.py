"""Roots of polynomials in the unit interval, one of each of many.

A projection that has not settled is not the closest point: the gap is then too large by the square of what it misses,
and the derivatives of the gap, which are those at a closest point, by what it misses. On edges that bend sharply
Newton's method alone takes dozens of steps, or goes to and fro. So the root is kept between bounds that move towards
it, and where a step leaves them, or shrinks by less than half, their middle is taken.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Change of a coordinate below which a root has settled; halvings alone come to it in 44 steps. So near to an end of
#: the interval it is that end: halvings come near to it and never there.
_SETTLED = 1e-13
_MOST = 100


def unit_roots(polynomials: Array, start: Array) -> Array:
    """Return where polynomials change from negative to positive; 0 or 1 where they do outside of the unit interval.

    Parameters
    ----------
    polynomials : array of float, shape (degree + 1, n)
        Factors of ``1, xi, xi^2, ...``.
    start : array of float, shape (n,)
        Where to begin, in [0, 1].
    """
    found, moving, factors = start.copy(), np.arange(len(start)), polynomials
    at, low, high, change = start, np.full(len(start), -np.inf), np.full(len(start), np.inf), np.full(len(start), 2.0)
    for _ in range(_MOST):
        if not len(moving):
            break
        value, rate = _with_rate(factors, at)
        low, high = np.where(value <= 0, at, low), np.where(value >= 0, at, high)
        towards = np.clip(at - value / np.where(rate > 0, rate, np.nan), 0, 1)
        step = np.abs(towards - at)
        is_sound = (towards > low) & (towards < high) & (step <= change / 2) | (step <= _SETTLED)
        after = np.where(is_sound, towards, (np.clip(low, 0, 1) + np.clip(high, 0, 1)) / 2)
        found[moving], change = after, np.abs(after - at)
        left = np.flatnonzero(change > _SETTLED)
        moving, factors = moving[left], factors[:, left]
        at, low, high, change = after[left], low[left], high[left], change[left]
    found[found <= _SETTLED], found[found >= 1 - _SETTLED] = 0, 1
    return found


def _with_rate(factors: Array, at: Array) -> tuple[Array, Array]:
    """Return values and derivatives of polynomials, by Horner's rule; factors have shape (degree + 1, n)."""
    value, rate = factors[-1], np.zeros_like(at)
    for factor in factors[-2::-1]:
        rate = rate * at + value
        value = value * at + factor
    return value, rate
