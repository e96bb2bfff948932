"""Gauss-Lobatto rules: the ends of an edge, and the corners of a quadrilateral, are among their points."""

from __future__ import annotations

import ngsolve
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def lobatto(count: int) -> tuple[Array, Array]:
    """Return points and weights of the Gauss-Lobatto rule on [0, 1], exact to degree ``2 count - 3``."""
    last = np.polynomial.legendre.Legendre.basis(count - 1)
    points = np.concatenate([[-1.0], np.sort(last.deriv().roots().real), [1.0]])
    weights = 2 / (count * (count - 1) * last(points) ** 2)
    return (points + 1) / 2, weights / 2


def lobatto_on_quadrilaterals(count: int) -> ngsolve.IntegrationRule:
    """Return the product of two such rules on the reference quadrilateral, `count` points in each direction."""
    points, weights = lobatto(count)
    grid = [(float(x), float(y)) for x in points for y in points]
    return ngsolve.IntegrationRule(points=grid, weights=np.outer(weights, weights).ravel().tolist())
