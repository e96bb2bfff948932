"""The smallest J = det F over whole elements, not over points of them.

With reference coordinates xi, ``J = det(dx/dxi) / det(dX/dxi)`` is a ratio of two polynomials. On an element, and on
every piece of one, each lies between the extremes of its Bernstein coefficients; where those of the lower one are
positive, so does the ratio lie above the smallest ratio of coefficients: ``c_i - m d_i >= 0`` for all i makes
``c - m d >= 0`` everywhere. Pieces whose bound is below the smallest value found so far are divided further, until
bound and value agree. So what is returned is a lower bound, and no element that folds between points is missed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.bernstein import FACTORS, Bernstein
from ngcell.results.places import element_type, map_points

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of the smallest J, or of `_SMALL` where it is smaller, to which the bound is made sharp.
_SHARP, _SMALL = 0.01, 0.01
#: Most divisions of an element, and most coefficients that are divided at once.
_MOST_ROUNDS, _MOST_COEFFICIENTS = 16, 2_000_000


@dataclass(frozen=True)
class SmallestJacobian:
    """The smallest ratio of deformed to reference volume, and where it is.

    Attributes
    ----------
    value : float
        A lower bound of J over all elements [1], sharp to a hundredth, unless J is far below zero.
    element : int
        Element that has it.
    point : array of float, shape (dimension,)
        Where about, in the reference state [length].
    """

    value: float
    element: int
    point: Array


def smallest_jacobian(space: DisplacementSpace, displacement: Array) -> SmallestJacobian:
    """Return the smallest J of a displacement of all unknowns, shape (unknowns,) [length].

    Raises
    ------
    GeometryError
        If the mesh has elements of several kinds, or pyramids.
    """
    kind = element_type(space)
    order = max(space.order, space.mesh.GetCurveOrder())
    nodes = _positions(kind, order)
    places = map_points(space, kind, nodes.lattice)
    rest = ngsolve.CF((ngsolve.x, ngsolve.y, ngsolve.z)[: space.dimension])(places)
    moved = rest + space.function(displacement)(places)
    shape = (-1, len(nodes.lattice), space.dimension)
    before, after = (_determinants(kind, order, at.reshape(shape)) for at in (rest, moved))
    value, element, within = _smallest_ratio(after, before, _determinant(kind, order))
    place = map_points(space, kind, within[None])[element : element + 1]
    return SmallestJacobian(value, element, ngsolve.CF((ngsolve.x, ngsolve.y, ngsolve.z)[: space.dimension])(place)[0])


@cache
def _positions(kind: ngsolve.ET, order: int) -> Bernstein:
    """The polynomials of positions."""
    return Bernstein(kind, (order,) * len(FACTORS[kind]))


@cache
def _determinant(kind: ngsolve.ET, order: int) -> Bernstein:
    """The polynomials of det(dx/dxi): in a simplex, a derivative by each of its coordinates is one degree lower."""
    dimension = sum(FACTORS[kind])
    return Bernstein(kind, tuple(dimension * order - own for own in FACTORS[kind]))


@cache
def _slopes(kind: ngsolve.ET, order: int) -> Array:
    """The map from nodes of positions to derivatives at the lattice of determinants."""
    nodes = _positions(kind, order)
    return np.asarray(nodes.gradients(_determinant(kind, order).lattice) @ nodes.from_values)


def _determinants(kind: ngsolve.ET, order: int, nodes: Array) -> Array:
    """Return the Bernstein coefficients of det(dx/dxi) from nodes of elements, (elements, nodes, dimension)."""
    gradient = np.einsum("apn,end->epda", _slopes(kind, order), nodes, optimize=True)
    return np.asarray(np.linalg.det(gradient) @ _determinant(kind, order).from_values.T)


def _smallest_ratio(upper: Array, lower: Array, basis: Bernstein) -> tuple[float, int, Array]:
    """Return a lower bound of the ratio of polynomials with these coefficients, its element and its place."""
    sign = np.sign(lower[:, basis.corners].sum(1))[:, None]
    cells = _Cells(sign * upper, sign * lower, np.arange(len(upper)), np.zeros((len(upper), 0), dtype=np.int64))
    least, floor = np.inf, _Lowest()
    for number in range(_MOST_ROUNDS):
        least = min(least, float(cells.ratio(basis.corners).min()))
        bound = cells.ratio()
        open_ones = np.flatnonzero(bound < least - _SHARP * max(abs(least), _SMALL))
        is_last = number == _MOST_ROUNDS - 1 or open_ones.size * upper.shape[1] > _MOST_COEFFICIENTS
        open_ones = open_ones[:0] if is_last else open_ones
        floor = floor.below(np.delete(bound, open_ones), cells.without(open_ones))
        if not len(open_ones):
            break
        cells = cells.divided(open_ones, basis.pieces)
    return floor.value, floor.element, basis.centre_of(floor.path)


@dataclass(frozen=True)
class _Lowest:
    """The lowest bound of pieces that need not be divided."""

    value: float = np.inf
    element: int = 0
    path: tuple[int, ...] = ()

    def below(self, bound: Array, cells: _Cells) -> _Lowest:
        """Return the lower one of itself and of the lowest of pieces."""
        if not len(bound) or bound.min() >= self.value:
            return self
        at = int(bound.argmin())
        return _Lowest(float(bound[at]), int(cells.element[at]), tuple(cells.path[at].tolist()))


@dataclass(frozen=True, eq=False)
class _Cells:
    """Pieces of elements: coefficients of both polynomials, the element of each, and which piece of it they are."""

    upper: Array
    lower: Array
    element: Index
    path: Index

    def ratio(self, chosen: Index | slice = slice(None)) -> Array:
        """Return the smallest ratio of coefficients; minus infinity where the lower ones are not positive."""
        upper, lower = self.upper[:, chosen], self.lower[:, chosen]
        ratio = upper / np.where(lower > 0, lower, 1.0)
        return np.where((lower > 0).all(1), ratio.min(1), -np.inf)

    def without(self, numbers: Index) -> _Cells:
        """Return all others."""
        rest = np.delete(np.arange(len(self.element)), numbers)
        return _Cells(self.upper[rest], self.lower[rest], self.element[rest], self.path[rest])

    def divided(self, numbers: Index, pieces: Array) -> _Cells:
        """Return the pieces of some."""
        upper, lower = (
            np.einsum("pij,ej->epi", pieces, part[numbers], optimize=True).reshape(-1, part.shape[1])
            for part in (self.upper, self.lower)
        )
        path = np.repeat(self.path[numbers], len(pieces), axis=0)
        own = np.tile(np.arange(len(pieces)), len(numbers))
        return _Cells(upper, lower, np.repeat(self.element[numbers], len(pieces)), np.column_stack([path, own]))
