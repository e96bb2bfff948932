"""The matrix of a minimiser, and where the parts of a second-order model stand in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.cliques import narrowed
from ngcell.solve.coarse import Bodies
from ngcell.solve.condensed import CondensedMatrix
from ngcell.solve.iterative import IterativeMatrix
from ngcell.solve.problem import Problem, SymmetricOperator

Array = NDArray[np.float64]
Index = NDArray[np.int64]
#: Entries of the metric that are added at once: few enough for a processor's cache.
_AT_ONCE = 2**16
SystemMatrix = CondensedMatrix | IterativeMatrix


@dataclass(frozen=True, eq=False)
class Metric:
    """The lower triangle of a matrix that measures displacements, as a part of the matrix.

    Attributes
    ----------
    at : array of int
        Where its entries stand among the values.
    row, column : array of int
        Their rows and columns.
    entries : array of float
        The entries.
    """

    at: Index
    row: Index
    column: Index
    entries: Array

    def add(self, values: Array, weight: Array | float) -> Array:
        """Add a multiple to values, or ``sqrt(weight_i weight_j) M_ij`` where each unknown has a weight of its own, and
        return them."""
        root = np.sqrt(weight) if isinstance(weight, np.ndarray) else None
        for first in range(0, len(self.at), _AT_ONCE):
            part = slice(first, first + _AT_ONCE)
            factor = weight if root is None else root[self.row[part]] * root[self.column[part]]
            values[self.at[part]] += factor * self.entries[part]
        return values


@dataclass(frozen=True, eq=False)
class System:
    """A matrix with a lasting pattern.

    Attributes
    ----------
    matrix : CondensedMatrix or IterativeMatrix
        The matrix.
    bulk : array of int or None
        Where the entries of the problem's pattern stand among the values; None where they are these, in this order.
    metric : Metric
        What the proximal term and damping are multiples of.
    """

    matrix: SystemMatrix
    bulk: Index | None
    metric: Metric

    def of_pattern(self, stiffness: Array) -> Array:
        """Return the values of a matrix from those on the problem's pattern; a copy."""
        if self.bulk is None:
            return stiffness.copy()
        return np.asarray(np.bincount(self.bulk, weights=stiffness, minlength=self.matrix.entry_count), dtype=float)


def direct_system(problem: Problem, touched: Index, near: float, bodies: Bodies | None) -> System:
    """Return a matrix that is factorised.

    Penalty terms touch the unknowns `touched`; walls of a smaller gap than `near` [length] are next to closing. It uses
    low modes of `bodies`, if there are any.
    """

    def matrix(row: Index, column: Index) -> SystemMatrix:
        return CondensedMatrix(len(problem.free), problem.free, row, column, touched, near, bodies)

    return _system(problem, matrix)


def iterative_system(problem: Problem) -> System:
    """Return a matrix whose systems are solved by iterations."""

    def matrix(row: Index, column: Index) -> SystemMatrix:
        return IterativeMatrix(len(problem.free), problem.free, row, column, problem.part)

    return _system(problem, matrix)


def _system(problem: Problem, matrix_of: Callable[[Index, Index], SystemMatrix]) -> System:
    """Return a matrix with room for all entries, and where they stand."""
    (row, column, entries), pattern = lower_triangle(problem.metric), problem.pattern
    matrix = matrix_of(*map(np.concatenate, zip(pattern, (row, column), strict=True)))
    metric, bulk = Metric(matrix.locate(row, column), row, column, entries), matrix.locate(*pattern)
    is_all = np.array_equal(bulk, np.arange(matrix.entry_count))
    return System(matrix, None if is_all else bulk, metric)


def lower_triangle(matrix: SymmetricOperator) -> tuple[Index, Index, Array]:
    """Return rows, columns and values of the lower triangle."""
    found = matrix.tocsr()
    row = np.repeat(np.arange(found.shape[0], dtype=found.indices.dtype), np.diff(found.indptr))
    lower = row >= found.indices
    return narrowed(row[lower]), narrowed(found.indices[lower]), found.data[lower]
