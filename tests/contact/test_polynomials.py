"""Polynomials along an edge and on faces, beside exact ones."""

from __future__ import annotations

from fractions import Fraction
from math import prod

import numpy as np
import pytest

from ngcell.contact.surface.facet_basis import FacetBasis
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
    np.testing.assert_allclose(found, expected, rtol=0, atol=4e-14)
    np.testing.assert_allclose(found.sum(-1), 1.0, rtol=0, atol=1e-15)


@pytest.mark.parametrize("order", range(1, 8))
def test_derivatives_are_those_of_the_values(order):
    basis, xi, step = Lagrange(order), np.linspace(0.01, 0.99, 13), 1e-5
    for degree in range(1, order + 2):
        rise = (basis.values(xi + step, degree - 1) - basis.values(xi - step, degree - 1)) / (2 * step)
        found, size = basis.values(xi, degree), np.abs(basis.values(basis.nodes, degree - 1)).max()
        np.testing.assert_allclose(found, rise, rtol=0, atol=1e-5 * size * order**2)
        np.testing.assert_allclose(found.sum(-1), 0.0, rtol=0, atol=1e-13 * size)


@pytest.mark.parametrize("order", range(1, 8))
def test_factors_of_powers_make_the_polynomial(order):
    basis, rng = Lagrange(order), np.random.default_rng(1)
    nodal, xi = rng.random(order + 1), rng.random(20)
    found = np.polynomial.polynomial.polyval(xi, basis.by_powers(nodal))
    np.testing.assert_allclose(found, basis.values(xi) @ nodal, rtol=0, atol=1e-11)


@pytest.mark.parametrize("corners", [3, 4])
@pytest.mark.parametrize("order", range(1, 7))
def test_polynomials_on_facets_make_every_polynomial_and_its_derivatives(order, corners):
    """One of their degree, beside itself."""
    basis, rng = FacetBasis(order, corners), np.random.default_rng(order)
    xi = rng.random((40, 2))
    xi[:, 1] *= 1 if corners == 4 else 1 - xi[:, 0]
    powers = [p for p in np.ndindex(order + 1, order + 1) if corners == 4 or sum(p) <= order]
    factors = np.zeros((order + 1, order + 1))
    for power in powers:
        factors[power] = rng.uniform(-1, 1)
    nodal = np.polynomial.polynomial.polyval2d(*basis.nodes.T, factors)
    assert basis.values(xi[:0]).shape == (0, len(basis.nodes))
    for degrees in [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0)]:
        sloped = factors
        for axis, degree in enumerate(degrees):
            sloped = np.polynomial.polynomial.polyder(sloped, degree, axis=axis)
        found, sums = basis.values(xi, degrees) @ nodal, basis.values(xi, degrees).sum(-1)
        expected = np.polynomial.polynomial.polyval2d(*xi.T, sloped)
        np.testing.assert_allclose(found, expected, rtol=0, atol=2e-14 * order ** (2 + 2 * sum(degrees)))
        np.testing.assert_allclose(sums, float(not any(degrees)), rtol=0, atol=1e-14 * order ** (2 * sum(degrees)))
