"""Polynomials on reference elements by their Bernstein coefficients, between whose extremes all their values lie.

A reference element is a product of simplices: a quadrilateral is a line times a line, a prism a triangle times a line.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, cached_property
from itertools import product
from math import factorial, prod

import ngsolve
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Dimensions of the simplices whose product an element is.
FACTORS = {
    ngsolve.ET.TRIG: (2,),
    ngsolve.ET.QUAD: (1, 1),
    ngsolve.ET.TET: (3,),
    ngsolve.ET.PRISM: (2, 1),
    ngsolve.ET.HEX: (1, 1, 1),
}
#: Halves of a line, quarters of a triangle and eighths of a tetrahedron: pairs of corners whose middles they have.
_PIECES = {
    1: ["00 01", "01 11"],
    2: ["00 01 02", "01 11 12", "02 12 22", "01 12 02"],
    3: [
        "00 01 02 03",
        "01 11 12 13",
        "02 12 22 23",
        "03 13 23 33",
        "01 02 03 13",
        "01 02 12 13",
        "02 03 13 23",
        "02 12 13 23",
    ],
}


class Bernstein:
    """Bernstein polynomials on an element.

    Parameters
    ----------
    kind : ngsolve.ET
        The element.
    degrees : tuple of int
        Degree on each simplex that the element is a product of.

    Attributes
    ----------
    lattice : array of float, shape (coefficients, dimension)
        As many points in reference coordinates as there are polynomials; values there determine a polynomial.
    """

    def __init__(self, kind: ngsolve.ET, degrees: tuple[int, ...]) -> None:
        self._factors = list(zip(FACTORS[kind], degrees, strict=True))
        parts = [_exponents(*factor)[:, 1:] / max(factor[1], 1) for factor in self._factors]
        self.lattice = np.array([np.concatenate(rows) for rows in product(*parts)])

    def values(self, points: Array) -> Array:
        """Return the polynomials at reference points, shape (points, polynomials)."""
        return _product(
            [_values(*factor, part) for factor, part in zip(self._factors, self._split(points), strict=True)]
        )

    def gradients(self, points: Array) -> Array:
        """Return their derivatives by the reference coordinates, shape (dimension, points, polynomials)."""
        split, found = self._split(points), []
        for number, (dimension, degree) in enumerate(self._factors):
            plain = [_values(*factor, part) for factor, part in zip(self._factors, split, strict=True)]
            for slope in _slopes(dimension, degree, split[number]):
                found.append(_product([*plain[:number], slope, *plain[number + 1 :]]))
        return np.array(found)

    @cached_property
    def from_values(self) -> Array:
        """The map from values at the lattice to coefficients, shape (coefficients, coefficients)."""
        return np.asarray(np.linalg.inv(self.values(self.lattice)))

    @cached_property
    def corners(self) -> NDArray[np.int64]:
        """Coefficients that are values: those of the corners."""
        parts = [(_exponents(*factor) == factor[1]).any(1) for factor in self._factors]
        return np.flatnonzero([all(row) for row in product(*parts)])

    @cached_property
    def pieces(self) -> Array:
        """The maps from coefficients on an element to those on its pieces, shape (pieces, coefficients, coefficients).
        """
        maps = [_piece_maps(dimension) for dimension, _ in self._factors]
        found = []
        for chosen in product(*maps):
            points = np.hstack(
                [to + part @ by for (to, by), part in zip(chosen, self._split(self.lattice), strict=True)]
            )
            found.append(self.from_values @ self.values(points))
        return np.array(found)

    def centre_of(self, piece: Sequence[int]) -> Array:
        """Return the centre of a piece of a piece of ... an element in its reference coordinates."""
        maps = list(product(*[_piece_maps(dimension) for dimension, _ in self._factors]))
        place = np.concatenate([np.full(dimension, 1 / (dimension + 1)) for dimension, _ in self._factors])
        for number in reversed(piece):
            split = self._split(place[None])
            place = np.hstack([to + part @ by for (to, by), part in zip(maps[number], split, strict=True)])[0]
        return place

    def _split(self, points: Array) -> list[Array]:
        ends = np.cumsum([dimension for dimension, _ in self._factors])[:-1]
        return np.split(points, ends, axis=1)


def _piece_maps(dimension: int) -> list[tuple[Array, Array]]:
    """Return the affine maps ``to + x by`` of a simplex onto its pieces."""
    corner = np.vstack([np.zeros(dimension), np.eye(dimension)])
    pieces = [
        np.array([corner[[int(number) for number in pair]].mean(0) for pair in piece.split()])
        for piece in _PIECES[dimension]
    ]
    return [(piece[0], piece[1:] - piece[0]) for piece in pieces]


@cache
def _exponents(dimension: int, degree: int) -> NDArray[np.int64]:
    """Return the exponents of barycentric coordinates, shape (polynomials, dimension + 1)."""
    every = np.array(list(product(range(degree + 1), repeat=dimension)), dtype=np.int64).reshape(-1, dimension)
    rest = degree - every.sum(1)
    return np.asarray(np.column_stack([rest, every])[rest >= 0])


def _values(dimension: int, degree: int, points: Array) -> Array:
    exponents = _exponents(dimension, degree)
    factor = np.array([factorial(degree) / prod(map(factorial, row)) for row in exponents.tolist()])
    barycentric = np.column_stack([1 - points.sum(1), points])
    return np.asarray(factor * np.prod(barycentric[:, None, :] ** exponents, axis=2))


def _slopes(dimension: int, degree: int, points: Array) -> list[Array]:
    """Return the derivatives by each coordinate: differences of polynomials of one degree less."""
    exponents = _exponents(dimension, degree)
    lower = (
        {tuple(row): number for number, row in enumerate(_exponents(dimension, degree - 1).tolist())} if degree else {}
    )
    by_barycentric = np.zeros((dimension + 1, len(points), len(exponents)))
    values = _values(dimension, degree - 1, points) if degree else np.zeros((len(points), 0))
    for number, row in enumerate(exponents.tolist()):
        for axis in range(dimension + 1):
            if row[axis]:
                below = tuple(entry - (at == axis) for at, entry in enumerate(row))
                by_barycentric[axis, :, number] = degree * values[:, lower[below]]
    return [by_barycentric[axis + 1] - by_barycentric[0] for axis in range(dimension)]


def _product(parts: list[Array]) -> Array:
    """Return all products of one polynomial of each part, the last one changing fastest."""
    found = parts[0]
    for part in parts[1:]:
        found = (found[:, :, None] * part[:, None, :]).reshape(len(part), -1)
    return found
