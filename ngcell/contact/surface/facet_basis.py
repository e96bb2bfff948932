"""Polynomials and quadrature on triangles and quadrilaterals, in two coordinates of the unit triangle or square."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.polynomials import Lagrange, distinct
from ngcell.mechanics.lobatto import lobatto

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_CORNERS = {
    3: np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]),
    4: np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]),
}


@dataclass(frozen=True, eq=False)
class FacetBasis:
    """Lagrange polynomials at equidistant nodes of the unit triangle or square, and their derivatives.

    Attributes
    ----------
    order : int
        Polynomial order, in each coordinate or, on triangles, in all.
    corner_count : {3, 4}
        Whether facets are triangles or quadrilaterals.
    """

    order: int
    corner_count: int

    @cached_property
    def corners(self) -> Array:
        """Corners of the unit facet, anticlockwise, shape (corners, 2)."""
        return _CORNERS[self.corner_count]

    @property
    def centre(self) -> Array:
        """Its centre, shape (2,)."""
        return np.asarray(self.corners.mean(0))

    @cached_property
    def _powers(self) -> Index:
        index = np.array(list(np.ndindex(self.order + 1, self.order + 1)))
        return index[index.sum(1) <= self.order] if self.corner_count == 3 else index

    @cached_property
    def nodes(self) -> Array:
        """Nodes, shape (nodes, 2)."""
        return self._powers / self.order

    @cached_property
    def corner_nodes(self) -> Index:
        """Nodes at the corners, shape (corners,)."""
        apart = np.abs(self.corners[:, None] - self.nodes).sum(2)
        return np.asarray(apart.argmin(1))

    @cached_property
    def _along(self) -> Lagrange:
        """Polynomials along a side."""
        return Lagrange(self.order)

    @cached_property
    def _from_monomials(self) -> Array:
        """Factors of monomials of twice the distances from the centre in the polynomials on triangles."""
        return np.linalg.inv(((2 * (self.nodes - self.centre))[:, None] ** self._powers).prod(2))

    def values(self, xi: Array, derivative: tuple[int, int] = (0, 0)) -> Array:
        """Return a partial derivative of all polynomials at `xi`, (*shape, 2); shape (*shape, nodes).

        They add up to 1, and derivatives to 0, to the last digit.
        """
        if self.corner_count == 4:
            one, two = (self._along.values(xi[..., axis], degree) for axis, degree in enumerate(derivative))
            return np.asarray((one[..., :, None] * two[..., None, :]).reshape(*one.shape[:-1], len(self.nodes)))
        factors, place = [], 2 * (xi - self.centre)
        for axis, degree in enumerate(derivative):
            power = self._powers[:, axis]
            factor = np.ones(len(power))
            for step in range(degree):
                factor = 2 * factor * (power - step)
            factors.append(_powers_of(place[..., axis], self.order)[..., np.maximum(power - degree, 0)] * factor)
        found = (factors[0] * factors[1]) @ self._from_monomials
        return np.asarray(found + ((not any(derivative)) - found.sum(-1, keepdims=True)) / found.shape[-1])

    def in_parts(self, points: Array, parts: int) -> tuple[Array, Index]:
        """Return points of the unit facet as they lie in each of the equal parts into which its sides are divided.

        Parts of a triangle are as it is, or turned by half a turn. Returned is what `distinct` does, part by part.
        """
        corner = np.array(list(np.ndindex(parts, parts)))
        if self.corner_count == 3:
            upright = corner[corner.sum(1) < parts]
            turned = corner[corner.sum(1) < parts - 1] + 1
            placed = np.concatenate([upright[:, None] + points, turned[:, None] - points])
        else:
            placed = corner[:, None] + points
        return distinct(placed.reshape(-1, 2) / parts)

    @cached_property
    def rule(self) -> tuple[Array, Array]:
        """Points and weights of the quadrature on the unit facet.

        Squares are walls of prisms, with the second coordinate along the axis. Around the cell they take the rule on
        edges, which has points on the corner lines; along the axis that of Gauss, which is as exact. It has no points
        on seams between elements: there, points of facing meshes would lie opposite seams, and where walls bend, a
        seam is a groove in which points are caught, and the contact force changes its direction within a width of
        the overlap times the angle at the seam.

        A triangle takes three quadrilaterals that meet in its centre, each with the rule on edges: corners and sides
        are among its points. Shape functions of the wall opposite have kinks where its facets end, which no rule of
        this wall knows of: the more points, the less pressures scatter between meshes that do not match.
        """
        if self.corner_count == 4:
            legendre, weights = np.polynomial.legendre.leggauss(self.order + 1)
            return _product(lobatto(self.order + 2), ((legendre + 1) / 2, weights / 2))
        return self._triangle_rule()

    def _triangle_rule(self) -> tuple[Array, Array]:
        at, share = lobatto(self.order + 2)
        points: list[Array] = []
        weights: list[Array] = []
        for corner in range(3):
            start, ahead, behind = (self.corners[(corner + step) % 3] for step in range(3))
            quad = [start, (start + ahead) / 2, self.centre, (start + behind) / 2]
            x, y = (axis.ravel() for axis in np.meshgrid(at, at, indexing="ij"))
            shape = np.stack([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y])
            by_x = np.stack([y - 1, 1 - y, y, -y]).T @ quad
            by_y = np.stack([x - 1, -x, x, 1 - x]).T @ quad
            points.append(shape.T @ quad)
            weights.append(np.outer(share, share).ravel() * (by_x[:, 0] * by_y[:, 1] - by_x[:, 1] * by_y[:, 0]))
        return _merged(np.concatenate(points), np.concatenate(weights))

    @property
    def level_rule(self) -> tuple[Array, Array]:
        """Points and weights for squares that are ends of prisms: the rule of Gauss in both directions.

        Seams run in both directions there, and rims of one layer lie on those of the next, where the contact force
        would change its direction. It has as many points as the rule on edges: with one less, corners of a layer that
        has slid sink into the other by 2 % of the wall; with these, by less than 0.5 %.
        """
        legendre, weights = np.polynomial.legendre.leggauss(self.order + 2)
        return _product(*[((legendre + 1) / 2, weights / 2)] * 2)


def _product(one: tuple[Array, Array], two: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return the rule on the unit square of two rules on [0, 1], each points and weights."""
    points = np.stack(np.meshgrid(one[0], two[0], indexing="ij"), axis=-1).reshape(-1, 2)
    return points, np.outer(one[1], two[1]).ravel()


def _powers_of(x: Array, most: int) -> Array:
    powers = [np.ones_like(x)]
    for _ in range(most):
        powers.append(powers[-1] * x)
    return np.stack(powers, axis=-1)


def _merged(points: Array, weights: Array) -> tuple[Array, Array]:
    """Return distinct points with the sums of their weights."""
    merged, number = distinct(points)
    return merged, np.bincount(number, weights).astype(float)
