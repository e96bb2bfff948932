"""The radial solver against closed forms of incompressible rings, and the references at a finite bulk modulus."""

from __future__ import annotations

from math import log, sqrt

import pytest
from scipy.optimize import brentq

from tools.references.radial import (
    RadialSolid,
    Ring,
    closing,
    first_touch,
    loaded_inside,
    loaded_outside,
    press_fit,
    pulled_apart,
    ring_with_free_rim,
)

SOFT, STIFF = RadialSolid(0.5, 0.5, 1000.0), RadialSolid(0.5, 0.5, 1e5)
#: What is left of the difference to an incompressible ring at kappa / mu = 1e5.
LEFT = 1e-5


def ring(solid: RadialSolid, inner: float, outer: float) -> Ring:
    return Ring(solid, inner, outer)


def f(inner: float, outer: float) -> float:
    """Drop of pressure through an incompressible ring over its shear modulus, from the stretches of its circles."""
    return log(inner / outer) + 0.5 * (outer**-2 - inner**-2)


def incompressible_fit(bore: float, rim: float, modulus_ratio: float = 1.0) -> tuple[float, float]:
    """Press-fit: interface radius and pressure for an inner ring [0.5, 1.0], in its shear modulus."""

    def drops(radius: float) -> tuple[float, float]:
        inner = f(sqrt(radius**2 - 1 + 0.5**2) / 0.5, radius)
        outer = f(radius / bore, sqrt(rim**2 + radius**2 - bore**2) / rim)
        return inner, modulus_ratio * outer

    radius = brentq(lambda radius: sum(drops(radius)), max(bore, sqrt(0.76)), 1.0, xtol=1e-14)
    return radius, drops(radius)[1]


def incompressible_closing(pressure: float) -> tuple[float, float, float]:
    """Closing rings above first touch: bore, interface radius and contact pressure for [0.5, 1.0] in [1.1, 1.6]."""

    def outer_drop(radius: float) -> float:
        return f(radius / 1.1, sqrt(1.6**2 + radius**2 - 1.1**2) / 1.6)

    def excess(bore: float) -> float:
        radius = sqrt(1 + bore**2 - 0.5**2)
        return f(bore / 0.5, radius) + outer_drop(radius) - pressure

    bore = brentq(excess, sqrt(1.1**2 - 1 + 0.25), 1.5, xtol=1e-14)
    radius = sqrt(1 + bore**2 - 0.25)
    return bore, radius, outer_drop(radius)


@pytest.mark.parametrize(("bore", "radius", "pressure"), [(0.9, 0.984461, 0.104605), (0.8, 0.969712, 0.230555)])
def test_press_fit_of_stiff_rings_is_that_of_incompressible_ones(bore, radius, pressure):
    closed_form = incompressible_fit(bore, 1.5)
    assert closed_form == pytest.approx((radius, pressure), abs=6e-7)
    state = press_fit(ring(STIFF, 0.5, 1.0), ring(STIFF, bore, 1.5))
    assert (state.inside.outer, state.contact_pressure) == pytest.approx(closed_form, abs=LEFT)
    assert state.gap == 0
    assert state.outside.outer_pressure == pytest.approx(0, abs=1e-8)
    assert state.inside.inner == pytest.approx(sqrt(radius**2 - 1 + 0.25), abs=LEFT)


@pytest.mark.parametrize(("bore", "radius", "pressure"), [(0.9, 0.984409, 0.104506), (0.8, 0.969601, 0.230343)])
def test_press_fit_at_a_finite_bulk_modulus(bore, radius, pressure):
    state = press_fit(ring(SOFT, 0.5, 1.0), ring(SOFT, bore, 1.5))
    assert (state.inside.outer, state.contact_pressure) == pytest.approx((radius, pressure), abs=6e-7)


def test_press_fit_of_rings_of_two_materials():
    inner, outer = ring(STIFF, 0.5, 1.0), ring(RadialSolid(2.5, 0.5, 3e5), 0.9, 1.5)
    state = press_fit(inner, outer)
    assert (state.inside.outer, state.contact_pressure) == pytest.approx(incompressible_fit(0.9, 1.5, 3.0), abs=LEFT)


@pytest.mark.parametrize(("rim", "incompressible", "finite"), [(1.6, 0.144552, 0.144409), (2.0, 0.658312, 0.657930)])
def test_gap_of_rings_that_are_pulled_apart(rim, incompressible, finite):
    assert sqrt(1 + rim**2 - 1.5**2) - 1 == pytest.approx(incompressible, abs=6e-7)
    for solid, gap, error in ((STIFF, incompressible, LEFT), (SOFT, finite, 6e-7)):
        state = pulled_apart(ring(solid, 0.5, 1.0), ring(solid, 1.0, 1.5), rim)
        assert state.gap == pytest.approx(gap, abs=error)
        assert (state.inside.inner, state.inside.outer) == (0.5, 1.0)


def test_pressure_of_first_touch():
    touch = sqrt(1.1**2 - 1 + 0.25) / 0.5
    assert f(touch, 1.1) == pytest.approx(0.351057, abs=6e-7)
    for solid, pressure, error in ((STIFF, 0.351057, LEFT), (SOFT, 0.350737, 6e-7)):
        state = first_touch(ring(solid, 0.5, 1.0), ring(solid, 1.1, 1.6))
        assert state.inside.inner_pressure == pytest.approx(pressure, abs=error)
        assert (state.gap, state.contact_pressure) == (0, 0)


@pytest.mark.parametrize(
    ("pressure", "finite"),
    [
        (0.4, (0.706098, 1.117477, 0.016303)),
        (0.5, (0.771979, 1.160250, 0.052709)),
        (0.6, (0.854241, 1.216563, 0.094045)),
    ],
)
def test_closing_above_the_first_touch(pressure, finite):
    closed_form = incompressible_closing(pressure)
    if pressure == 0.6:
        assert closed_form == pytest.approx((0.853969, 1.216250, 0.093885), abs=6e-7)
    for solid, numbers, error in ((STIFF, closed_form, LEFT), (SOFT, finite, 6e-7)):
        state = closing(ring(solid, 0.5, 1.0), ring(solid, 1.1, 1.6), pressure)
        assert (state.inside.inner, state.inside.outer, state.contact_pressure) == pytest.approx(numbers, abs=error)
        assert state.gap == 0


def test_closing_below_the_first_touch_is_the_inner_ring_alone():
    inner, outer = ring(SOFT, 0.5, 1.0), ring(SOFT, 1.1, 1.6)
    touch = first_touch(inner, outer)
    for pressure in (0.2, 0.3):
        state = closing(inner, outer, pressure)
        alone = ring_with_free_rim(SOFT, 0.5, state.inside.inner, 1.0)
        assert alone.inner_pressure == pytest.approx(pressure, abs=1e-10)
        assert state.gap == pytest.approx(1.1 - alone.outer, abs=1e-10)
        assert state.contact_pressure == pytest.approx(0, abs=1e-9)
    for step in (-1e-6, 1e-6):
        near = closing(inner, outer, touch.inside.inner_pressure + step)
        assert near.inside.inner == pytest.approx(touch.inside.inner, abs=1e-5)
        assert near.gap == pytest.approx(0, abs=1e-5)
        assert near.contact_pressure == pytest.approx(0, abs=1e-5)


def test_marching_there_and_back_ends_where_it_began():
    state = loaded_inside(ring(SOFT, 0.5, 1.0), 0.7, 0.4)
    back = loaded_outside(ring(SOFT, 0.5, 1.0), state.outer, state.outer_pressure)
    assert (back.inner, back.inner_pressure) == pytest.approx((0.7, 0.4), abs=1e-9)
