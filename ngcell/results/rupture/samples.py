"""Points in all elements, with what each stands for: rules fine enough for averages over short lengths."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.errors import CaseError
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.places import element_type, map_points

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: More points than this are a length that is far too short for the bodies.
MOST_POINTS = 3_000_000


@dataclass(frozen=True, eq=False)
class Samples:
    """Points of reference elements, mapped to all elements.

    Attributes
    ----------
    space : DisplacementSpace
        The unknowns.
    points : array of float, shape (points, dimension)
        In the reference element.
    weights : array of float, shape (points,)
        Weights there; zeros where nothing is integrated.
    """

    space: DisplacementSpace
    points: Array
    weights: Array

    def __post_init__(self) -> None:
        check_count(len(self.points), self.space)

    @cached_property
    def places(self) -> NDArray[np.void]:
        """The points as NGSolve has them, element by element."""
        return map_points(self.space, element_type(self.space), self.points)

    @cached_property
    def volume(self) -> Array:
        """Area or volume at rest that each point stands for, shape (elements * points,); 0 in what fills lumens."""
        dimension = self.space.dimension
        jacobian = np.asarray(ngsolve.specialcf.JacobianMatrix(dimension)(self.places))
        size = np.abs(np.linalg.det(jacobian.reshape(-1, dimension, dimension)))
        volume, filling = size * np.tile(self.weights, self.space.mesh.ne), self.space.bodies.is_filling
        return volume if filling is None else np.where(filling[self.element], 0.0, volume)

    @property
    def element(self) -> Index:
        """Element of each point."""
        return np.asarray(self.places["nr"], dtype=np.int64)

    @cached_property
    def rest(self) -> Array:
        """Places at rest, shape (elements * points, dimension) [length]."""
        coordinates = ngsolve.CF((ngsolve.x, ngsolve.y, ngsolve.z)[: self.space.dimension])
        return np.asarray(coordinates(self.places)).reshape(-1, self.space.dimension)

    def deformation_gradient(self, displacement: Array) -> Array:
        """Return F [1], in the plane that of plane strain, shape (elements * points, 3, 3)."""
        gradient, dimension = np.tile(np.eye(3), (len(self.places), 1, 1)), self.space.dimension
        own = ngsolve.Grad(self.space.function(displacement))(self.places).reshape(-1, dimension, dimension)
        gradient[:, :dimension, :dimension] += own
        return gradient

    def with_projected_volume(self, displacement: Array, gradient: Array) -> Array:
        """Return deformation gradients whose volume ratio is projected to one order less, in its logarithm.

        The volume ratio of a displacement goes up and down within elements, about that which a pressure of one order
        less would see; times the bulk modulus it would be most of the mean stress. NaN where an element is inverted.
        """
        planar = ngsolve.Id(self.space.dimension) + ngsolve.Grad(self.space.function(displacement))
        self._log_volume.Set(ngsolve.log(ngsolve.Det(planar)), bonus_intorder=2 * self.space.order)
        volume = np.exp(np.asarray(self._log_volume(self.places)).ravel())
        return np.asarray(gradient * np.cbrt(volume / np.linalg.det(gradient))[:, None, None])

    @cached_property
    def _log_volume(self) -> ngsolve.GridFunction:
        return ngsolve.GridFunction(ngsolve.L2(self.space.mesh, order=self.space.order - 1))


def check_count(on_element: int, space: DisplacementSpace) -> None:
    """Raise CaseError if so many points on each element are too many."""
    count = on_element * int(space.mesh.ne)
    if count > MOST_POINTS:
        raise CaseError(
            f"material.rupture_length takes {count} points; allowed: a longer one, or a smaller mesh.size, so that "
            f"elements are not much larger than it (at most {MOST_POINTS} points)"
        )


def gauss(count: int, parts: int = 1) -> tuple[Array, Array]:
    """Return points and weights of a Gauss rule with `count` points in each of so many equal parts of [0, 1]."""
    points, weights = np.polynomial.legendre.leggauss(count)
    starts = np.arange(parts)[:, None]
    return ((starts + (points + 1) / 2) / parts).ravel(), np.tile(weights / 2, parts) / parts


def parts_for(size: float, length: float) -> int:
    """Return into how many parts elements of a size are cut, for averages over a length: two a length."""
    return max(1, ceil(2 * size / length - 1e-9))


def rule(kind: ngsolve.ET, count: int, parts: int) -> tuple[Array, Array]:
    """Return a rule on a plane reference element, cut into parts along each edge, with `count` Gauss points in each."""
    if kind == ngsolve.ET.QUAD:
        one, weight = gauss(count, parts)
        points = np.array([(x, y) for x in one for y in one])
        return points, np.outer(weight, weight).ravel()
    plain = ngsolve.IntegrationRule(kind, 2 * count - 1)
    return _cut_triangle(np.array(plain.points, dtype=float)[:, :2], np.array(plain.weights, dtype=float), parts)


def lattice(kind: ngsolve.ET, parts: int) -> Array:
    """Return points on a plane reference element, its outline included, so many parts along each edge."""
    steps = np.linspace(0, 1, parts + 1)
    grid = np.array([(x, y) for x in steps for y in steps])
    return grid if kind == ngsolve.ET.QUAD else grid[grid.sum(1) <= 1 + 1e-9]


def _cut_triangle(points: Array, weights: Array, parts: int) -> tuple[Array, Array]:
    corners = [(i, j) for i in range(parts) for j in range(parts - i)]
    upright = np.array([(np.array(corner) + points) / parts for corner in corners])
    turned = [(i, j) for i, j in corners if i + j < parts - 1]
    inverted = np.array([(np.array(corner) + 1 - points) / parts for corner in turned]).reshape(-1, len(points), 2)
    found = np.concatenate([upright, inverted])
    return found.reshape(-1, 2), np.tile(weights, len(found)) / parts**2
