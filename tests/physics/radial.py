"""The thick ring in plane strain, solved a second way: one dimension, shooting, no finite elements.

A point at the reference radius R moves to r(R); its stretches are r' along the radius, r/R around it and 1 across.
With the stored energy W per reference volume, balance of forces along the radius is

    d/dR (R dW/dl_r) = dW/dl_t.

Second derivatives of W are complex steps: exact to round-off. Nothing is shared with the code under test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

_STEP = 1e-30


@dataclass(frozen=True)
class RadialSolid:
    """W = c1/2 (I1* - 3) + c2/2 (I2* - 3) + kappa/2 (ln J)^2."""

    c1: float
    c2: float
    kappa: float

    def slopes(self, radial, tangential):
        """dW/dl_r and dW/dl_t."""
        squares = [radial**2, tangential**2, 1.0]
        jacobian = radial * tangential
        first = sum(squares)
        second = squares[0] * squares[1] + squares[1] + squares[0]
        scale = jacobian ** (-2 / 3)
        return [
            (
                self.c1 * scale * (square - first / 3)
                + self.c2 * scale**2 * (square * (first - square) - 2 * second / 3)
                + self.kappa * np.log(jacobian)
            )
            / stretch
            for square, stretch in zip(squares[:2], (radial, tangential), strict=True)
        ]

    def radial_slope(self, radial, tangential):
        """d2W/dl_r2 and d2W/dl_r dl_t."""
        by_radial = self.slopes(radial + 1j * _STEP, tangential)[0].imag / _STEP
        by_tangential = self.slopes(radial, tangential + 1j * _STEP)[0].imag / _STEP
        return by_radial, by_tangential


@dataclass(frozen=True)
class RadialState:
    """A ring in balance: deformed radii, and pressures on the deformed circles (compression > 0)."""

    inner: float
    outer: float
    inner_pressure: float
    outer_pressure: float


def _march(solid: RadialSolid, start: float, end: float, radius: float, stretch: float) -> list[float]:
    """r and r' at `end`, from those at `start`."""

    def rate(place, state):
        position, radial = state
        tangential = position / place
        by_radial, by_tangential = solid.radial_slope(radial, tangential)
        along, around = solid.slopes(radial, tangential)
        change = by_tangential * (radial - tangential) / place + (along - around) / place
        return [radial, -change / by_radial]

    path = solve_ivp(rate, (start, end), (radius, stretch), method="DOP853", rtol=1e-12, atol=1e-13)
    return path.y[:, -1].tolist()


def _pressure(solid: RadialSolid, rest: float, radius: float, stretch: float) -> float:
    return -solid.slopes(stretch, radius / rest)[0] * rest / radius


def ring_with_free_rim(solid: RadialSolid, driven: float, radius: float, free: float) -> RadialState:
    """A ring whose circle of reference radius `driven` is brought to `radius`, while `free` bears no load."""
    isochoric = driven / radius

    def load_at_rim(stretch: float) -> float:
        return _pressure(solid, free, *_march(solid, driven, free, radius, stretch))

    stretch = brentq(load_at_rim, 0.7 * isochoric, 1.4 * isochoric, xtol=1e-14)
    rim, _ = _march(solid, driven, free, radius, stretch)
    load = _pressure(solid, driven, radius, stretch)
    if driven < free:
        return RadialState(radius, rim, load, 0.0)
    return RadialState(rim, radius, 0.0, load)


def inflated_radius(solid: RadialSolid, inner: float, outer: float, pressure: float) -> float:
    """Inner radius of a ring with free rim under a pressure inside."""

    def excess(radius: float) -> float:
        return ring_with_free_rim(solid, inner, radius, outer).inner_pressure - pressure

    return brentq(excess, inner, 1.8 * inner, xtol=1e-12)
