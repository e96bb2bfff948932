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
    def _by_powers(self) -> tuple[Array, ...]:
        """Factors of ``1, xi, xi^2, ...`` in the polynomials, and in their derivatives of each degree."""
        by_powers = [np.asarray(np.linalg.inv(np.vander(self.nodes, increasing=True)), dtype=np.float64)]
        while len(by_powers) <= self.order:
            by_powers.append(np.arange(1, len(by_powers[-1]))[:, None] * by_powers[-1][1:])
        return tuple(by_powers)

    def by_powers(self, values: Array) -> Array:
        """Return the factors of ``1, xi, xi^2, ...`` in polynomials with these values at the nodes, along axis 0."""
        return np.asarray(np.tensordot(self._by_powers[0], values, 1))

    def values(self, xi: Array, derivative: int = 0) -> Array:
        """Return the derivative of the given degree of all polynomials at `xi`; shape (*xi.shape, order + 1)."""
        xi = np.asarray(xi)
        if derivative > self.order:
            return np.zeros((*xi.shape, self.order + 1))
        factors = self._by_powers[derivative]
        powers = np.ones((*xi.shape, len(factors)))
        for power in range(1, len(factors)):
            np.multiply(powers[..., power - 1], xi, out=powers[..., power])
        return powers @ factors
