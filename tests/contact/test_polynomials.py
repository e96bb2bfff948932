"""Polynomials along an edge, beside exact fractions."""

from __future__ import annotations

from fractions import Fraction
from math import prod

import numpy as np
import pytest

from ngcell.contact.surface.polynomials import Lagrange


def exact(order: int, xi: float) -> list[Fraction]:
    """Lagrange polynomials at equidistant nodes."""
    nodes, place = [Fraction(node, order) for node in range(order + 1)], Fraction(xi)
    others = [[node for node in nodes if node != own] for own in nodes]
    return [prod((place - node) / (own - node) for node in rest) for own, rest in zip(nodes, others, strict=True)]


@pytest.mark.parametrize("order", range(1, 8))
def test_values_are_exact_and_add_up_to_one_to_the_last_digits(order):
    xi = np.random.default_rng(order).random(50)
    found = Lagrange(order).values(xi)
    expected = np.array([[float(value) for value in exact(order, place)] for place in xi.tolist()])
    np.testing.assert_allclose(found, expected, atol=4e-14)
    np.testing.assert_allclose(found.sum(-1), 1.0, atol=1e-15)


@pytest.mark.parametrize("order", range(1, 8))
def test_derivatives_are_those_of_the_values(order):
    basis, xi, step = Lagrange(order), np.linspace(0.01, 0.99, 13), 1e-5
    for degree in range(1, order + 2):
        rise = (basis.values(xi + step, degree - 1) - basis.values(xi - step, degree - 1)) / (2 * step)
        found, size = basis.values(xi, degree), np.abs(basis.values(basis.nodes, degree - 1)).max()
        np.testing.assert_allclose(found, rise, atol=1e-5 * size * order**2)
        np.testing.assert_allclose(found.sum(-1), 0.0, atol=1e-13 * size)


@pytest.mark.parametrize("order", range(1, 8))
def test_factors_of_powers_make_the_polynomial(order):
    basis, rng = Lagrange(order), np.random.default_rng(1)
    nodal, xi = rng.random(order + 1), rng.random(20)
    found = np.polynomial.polynomial.polyval(xi, basis.by_powers(nodal))
    np.testing.assert_allclose(found, basis.values(xi) @ nodal, atol=1e-11)
