"""Concentric rings in plane strain, or spherical shells, in one dimension: shooting, no elements.

    python -m tools.references radial [--kappa 1000]      at this ratio of kappa to mu

A point at the reference radius R moves to r(R); its stretches are r' along the radius, r/R around it and 1 across, in a
shell r/R again. With the stored energy W per reference volume and n = 1 or 2 directions around the radius, balance of
forces along it is

    d/dR (R^n dW/dl_r) = n R^(n-1) dW/dl_t.

Given the radius and the pressure on one circle, r' there follows from the law, and r, r' are marched to the other
circle. Rings that touch without friction share radius and pressure there, so marching on through the outer ring leaves
one number to find: the radius of the bore at which the rim bears nothing. Second derivatives of W are complex
steps: exact to round-off. Nothing is shared with the package.
"""

from __future__ import annotations

from cmath import log
from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import Any

import click
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, newton

from tools.commands import described

_STEP = 1e-30


def _log(value: Any) -> Any:
    """Natural logarithm; that of a number of Python stays one, as numbers of numpy take several times as long."""
    return log(value) if type(value) is complex else np.log(value)


@dataclass(frozen=True)
class RadialSolid:
    """W = c1/2 (I1* - 3) + c2/2 (I2* - 3) + kappa/2 (ln J)^2, in a ring (around = 1) or a shell (around = 2)."""

    c1: float
    c2: float
    kappa: float
    around: int = 1

    def slopes(self, radial: Any, tangential: Any) -> list[Any]:
        """dW/dl_r and dW/dl_t."""
        squares = [radial * radial, tangential * tangential, tangential * tangential if self.around == 2 else 1.0]
        jacobian = radial * tangential**self.around
        first = squares[0] + squares[1] + squares[2]
        second = squares[0] * squares[1] + squares[1] * squares[2] + squares[2] * squares[0]
        scale, logarithm = jacobian ** (-2 / 3), _log(jacobian)
        return [
            (
                self.c1 * scale * (square - first / 3)
                + self.c2 * scale**2 * (square * (first - square) - 2 * second / 3)
                + self.kappa * logarithm
            )
            / stretch
            for square, stretch in zip(squares[:2], (radial, tangential), strict=True)
        ]

    def derivatives(self, radial: Any, tangential: Any) -> tuple[Any, Any, Any, Any]:
        """dW/dl_r, dW/dl_t, d2W/dl_r2 and d2W/dl_r dl_t."""
        along, around = self.slopes(radial + 1j * _STEP, tangential)
        by_tangential = self.slopes(radial, tangential + 1j * _STEP)[0].imag / _STEP
        return along.real, around.real, along.imag / _STEP, by_tangential


@dataclass(frozen=True)
class Ring:
    """A ring at rest: its solid and its radii."""

    solid: RadialSolid
    inner: float
    outer: float


@dataclass(frozen=True)
class RadialState:
    """A ring in balance: deformed radii, and pressures on the deformed circles (compression > 0)."""

    inner: float
    outer: float
    inner_pressure: float
    outer_pressure: float


@dataclass(frozen=True)
class NestedState:
    """Two rings, one in the other, in balance."""

    inside: RadialState
    outside: RadialState

    @property
    def gap(self) -> float:
        """Distance of the rings; zero where they touch."""
        return self.outside.inner - self.inside.outer

    @property
    def contact_pressure(self) -> float:
        """Pressure between the rings, on the deformed circle."""
        return self.inside.outer_pressure


def loaded_inside(ring: Ring, radius: float, pressure: float) -> RadialState:
    """The state of a ring whose bore has this radius and bears this pressure."""
    end, load = _across(ring.solid, ring.inner, ring.outer, radius, pressure)
    return RadialState(radius, end, pressure, load)


def loaded_outside(ring: Ring, radius: float, pressure: float) -> RadialState:
    """The state of a ring whose rim has this radius and bears this pressure."""
    end, load = _across(ring.solid, ring.outer, ring.inner, radius, pressure)
    return RadialState(end, radius, load, pressure)


def ring_with_free_rim(solid: RadialSolid, driven: float, radius: float, free: float) -> RadialState:
    """A ring whose circle of reference radius `driven` is brought to `radius`, while `free` bears no load."""
    isochoric = (driven / radius) ** solid.around

    def load_at_rim(stretch: float) -> float:
        return _pressure(solid, free, *_march(solid, driven, free, radius, stretch))

    stretch = newton(load_at_rim, isochoric, tol=1e-14)  # by secants: the load is nearly linear in the stretch
    rim, _ = _march(solid, driven, free, radius, stretch)
    load = _pressure(solid, driven, radius, stretch)
    if driven < free:
        return RadialState(radius, rim, load, 0.0)
    return RadialState(rim, radius, 0.0, load)


def inflated_radius(solid: RadialSolid, inner: float, outer: float, pressure: float) -> float:
    """Inner radius of a ring with free rim under a pressure inside."""

    def excess(radius: float) -> float:
        return ring_with_free_rim(solid, inner, radius, outer).inner_pressure - pressure

    return float(brentq(excess, *_bracket(excess, inner, 1.02), xtol=1e-12))


def press_fit(inside: Ring, outside: Ring) -> NestedState:
    """Press-fit: a ring, wider than the bore that it sits in; bore and rim bear nothing."""

    def at(radius: float) -> NestedState:
        return NestedState(
            ring_with_free_rim(inside.solid, inside.outer, radius, inside.inner),
            ring_with_free_rim(outside.solid, outside.inner, radius, outside.outer),
        )

    def excess(radius: float) -> float:
        state = at(radius)
        return state.inside.outer_pressure - state.outside.inner_pressure

    # An incompressible ring cannot be pressed to less than the radius at which its bore is closed.
    closed = np.sqrt(inside.outer**2 - inside.inner**2)
    return at(brentq(excess, max(outside.inner, 1.03 * closed), inside.outer, xtol=1e-14))


def pulled_apart(inside: Ring, outside: Ring, rim: float) -> NestedState:
    """Parting rings: the rim is pulled to a radius; the inner ring stays as it is."""
    outer = ring_with_free_rim(outside.solid, outside.outer, rim, outside.inner)
    return NestedState(RadialState(inside.inner, inside.outer, 0.0, 0.0), outer)


def first_touch(inside: Ring, outside: Ring) -> NestedState:
    """Closing rings: the inner ring, inflated until it touches the outer one, which is at rest."""
    rest = RadialState(outside.inner, outside.outer, 0.0, 0.0)
    return NestedState(loaded_outside(inside, outside.inner, 0.0), rest)


def closing(inside: Ring, outside: Ring, pressure: float) -> NestedState:
    """Closing rings: a pressure inflates the inner ring, before and after it touches the outer one."""
    touch = first_touch(inside, outside)
    if pressure <= touch.inside.inner_pressure:
        radius = inflated_radius(inside.solid, inside.inner, inside.outer, pressure)
        return NestedState(loaded_inside(inside, radius, pressure), touch.outside)
    return _touching(inside, outside, pressure, start=touch.inside.inner, ratio=1.01)


def _touching(inside: Ring, outside: Ring, pressure: float, *, start: float, ratio: float) -> NestedState:
    """Two rings that touch, with a pressure in the bore and none on the rim; the bore is sought from `start` on."""

    def state(radius: float) -> NestedState:
        inner = loaded_inside(inside, radius, pressure)
        return NestedState(inner, loaded_inside(outside, inner.outer, inner.outer_pressure))

    def load_at_rim(radius: float) -> float:
        return state(radius).outside.outer_pressure

    return state(brentq(load_at_rim, *_bracket(load_at_rim, start, ratio), xtol=1e-14))


def _bracket(function: Callable[[float], float], start: float, ratio: float) -> tuple[float, float]:
    """The first of the intervals that go on from `start` by `ratio` in which a function changes sign."""
    places = (start * ratio**step for step in range(400))
    for (one, before), (two, after) in pairwise((place, function(place)) for place in islice(places, 400)):
        if before * after <= 0:
            return one, two
    raise ValueError(f"no balance between radius {start} and {start * ratio**400}")


def _across(solid: RadialSolid, start: float, end: float, radius: float, pressure: float) -> tuple[float, float]:
    """Radius and pressure on the circle of reference radius `end`, from those on that of `start`."""
    position, stretch = profile(solid, start, end, radius, pressure)(end)
    return float(position), _pressure(solid, end, float(position), float(stretch))


def profile(
    solid: RadialSolid, start: float, end: float, radius: float, pressure: float
) -> Callable[[Any], tuple[Any, Any]]:
    """r and r' at reference radii from `start` to `end`, where the circle of `start` has a radius and bears a pressure.
    """

    def excess(stretch: float) -> float:
        return _pressure(solid, start, radius, stretch) - pressure

    isochoric = (start / radius) ** solid.around
    stretch = brentq(excess, 0.5 * isochoric, 2.0 * isochoric, xtol=1e-15)
    path = _path(solid, start, end, radius, stretch, dense=True)
    return lambda place: (path.sol(place)[0], path.sol(place)[1])


def _march(solid: RadialSolid, start: float, end: float, radius: float, stretch: float) -> tuple[float, float]:
    """r and r' at `end`, from those at `start`."""
    position, slope = _path(solid, start, end, radius, stretch, dense=False).y[:, -1]
    return float(position), float(slope)


def _path(solid: RadialSolid, start: float, end: float, radius: float, stretch: float, *, dense: bool) -> Any:
    """r and r' from `start` to `end`, or at `end` alone unless `dense`, as scipy returns them."""

    def rate(place: float, state: Any) -> list[Any]:
        position, radial = state.tolist()  # numbers of Python, which are faster one by one
        tangential = position / place
        along, around, by_radial, by_tangential = solid.derivatives(radial, tangential)
        change = by_tangential * (radial - tangential) / place + solid.around * (along - around) / place
        return [radial, -change / by_radial]

    return solve_ivp(rate, (start, end), (radius, stretch), method="DOP853", rtol=1e-12, atol=1e-13, dense_output=dense)


def _pressure(solid: RadialSolid, rest: float, radius: float, stretch: float) -> float:
    return -float(solid.slopes(stretch, radius / rest)[0]) * (rest / radius) ** solid.around


@described(__doc__)
@click.option("--kappa", default=1000.0, show_default=True, help="Bulk over shear modulus.")
def command(kappa: float) -> None:
    """Print the numbers that cases of rings expect, in units of the shear modulus, for c1 = c2."""
    solid = RadialSolid(0.5, 0.5, kappa)

    def ring(inner: float, outer: float) -> Ring:
        return Ring(solid, inner, outer)

    for bore, rim in ((0.9, 1.5), (0.8, 1.5)):
        state = press_fit(ring(0.5, 1.0), ring(bore, rim))
        click.echo(
            f"press-fit [0.5, 1]/[{bore}, {rim}]: c = {state.inside.outer:.6f}, p = {state.contact_pressure:.6f}"
        )
    for rim in (1.6, 2.0):
        state = pulled_apart(ring(0.5, 1.0), ring(1.0, 1.5), rim)
        pull = -state.outside.outer_pressure
        click.echo(f"parting rings, b = {rim}: gap = {state.gap:.6f}, pull at the rim = {pull:.6f}")
    pair = ring(0.5, 1.0), ring(1.1, 1.6)
    touch = first_touch(*pair)
    click.echo(f"closing rings, first touch: P = {touch.inside.inner_pressure:.6f}, a = {touch.inside.inner:.6f}")
    for pressure in (0.2, 0.3, touch.inside.inner_pressure, 0.4, 0.5, 0.6):
        state = closing(*pair, pressure)
        click.echo(
            f"closing rings, P = {pressure:.6f}: a = {state.inside.inner:.6f}, c = {state.inside.outer:.6f}, "
            f"p = {state.contact_pressure:.6f}, gap = {state.gap:.6f}"
        )
