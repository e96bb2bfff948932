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


def lobatto_across(order: int) -> dict[ngsolve.ET, ngsolve.IntegrationRule]:
    """Return rules as exact as Gauss rules of order + 1 points, with the corners of cross-sections among their points.

    On quadrilaterals that is a product of Gauss-Lobatto rules, on hexahedra their product with the Gauss rule along the
    third coordinate. That is the axis of prisms: one that is held along it is integrated as the planar cell is.
    """
    points, weights = lobatto(order + 2)
    across = [(float(x), float(y)) for x in points for y in points]
    of_across = np.outer(weights, weights).ravel()
    gauss = ngsolve.IntegrationRule(ngsolve.ET.SEGM, 2 * order)
    solid = [(x, y, place[0]) for x, y in across for place in gauss.points]
    of_solid = np.outer(of_across, gauss.weights).ravel()
    return {
        ngsolve.ET.QUAD: ngsolve.IntegrationRule(points=across, weights=of_across.tolist()),
        ngsolve.ET.HEX: ngsolve.IntegrationRule(points=solid, weights=of_solid.tolist()),
    }
