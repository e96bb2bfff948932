"""Polynomials and quadrature along an edge."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Lagrange:
    """Lagrange polynomials of order `order` at equidistant nodes of [0, 1], and their derivatives."""

    order: int

    @property
    def centre(self) -> Array:
        """Middle of the edge."""
        return np.array(0.5)

    @property
    def corner_nodes(self) -> Index:
        """Nodes at the ends."""
        return np.array([0, self.order])

    @cached_property
    def nodes(self) -> Array:
        """Nodes, shape (order + 1,)."""
        return np.linspace(0.0, 1.0, self.order + 1)

    @cached_property
    def _by_powers(self) -> Array:
        """Factors of ``1, xi, xi^2, ...`` in the polynomials."""
        return np.asarray(np.linalg.inv(np.vander(self.nodes, increasing=True)), dtype=np.float64)

    @cached_property
    def _about_centre(self) -> tuple[Array, ...]:
        """Factors of ``1, s, s^2, ...``, with ``s = 2 xi - 1``, in the polynomials and in each of their derivatives by
        xi: small ones, in which less is lost to round-off than in those of powers of xi."""
        factors = [np.asarray(np.linalg.inv(np.vander(2 * self.nodes - 1, increasing=True)), dtype=np.float64)]
        while len(factors) <= self.order:
            factors.append(2 * np.arange(1, len(factors[-1]))[:, None] * factors[-1][1:])
        return tuple(factors)

    def by_powers(self, values: Array) -> Array:
        """Return the factors of ``1, xi, xi^2, ...`` in polynomials with these values at the nodes, along axis 0."""
        return np.asarray(np.tensordot(self._by_powers, values, 1))

    def in_parts(self, points: Array, parts: int) -> tuple[Array, Index]:
        """Return points of the edge as they lie in each of equal parts of it, one after the other, by `distinct`."""
        return distinct((np.arange(parts)[:, None] + points).ravel() / parts)

    def values(self, xi: Array, derivative: int = 0) -> Array:
        """Return the derivative of the given degree of all polynomials at `xi`; shape (*xi.shape, order + 1).

        They add up to 1, and derivatives to 0, to the last digit: round-off is that of the edge, wherever it lies.
        """
        xi = np.asarray(xi)
        if derivative > self.order:
            return np.zeros((*xi.shape, self.order + 1))
        factors, place = self._about_centre[derivative], 2 * xi - 1
        powers = np.ones((*xi.shape, len(factors)))
        for power in range(1, len(factors)):
            np.multiply(powers[..., power - 1], place, out=powers[..., power])
        found = powers @ factors
        return np.asarray(found + ((derivative == 0) - found.sum(-1, keepdims=True)) / (self.order + 1))


def distinct(points: Array) -> tuple[Array, Index]:
    """Return the distinct ones of points, shape (n,) or (n, coordinates), and which of these each point is, (n,)."""
    _, first, number = np.unique(points.round(12), axis=0, return_index=True, return_inverse=True)
    return points[first], number.ravel()
