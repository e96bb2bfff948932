"""The matrix of a minimiser, and where the parts of a second-order model stand in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.cliques import narrowed
from ngcell.solve.condensed import CondensedMatrix
from ngcell.solve.iterative import IterativeMatrix
from ngcell.solve.problem import Problem

Array = NDArray[np.float64]
Index = NDArray[np.int64]
#: Entries of the mass matrix that are added at once: few enough for a processor's cache.
_AT_ONCE = 2**16
SystemMatrix = CondensedMatrix | IterativeMatrix


@dataclass(frozen=True, eq=False)
class System:
    """A matrix with a lasting pattern.

    Attributes
    ----------
    matrix : CondensedMatrix or IterativeMatrix
        The matrix.
    bulk, metric : array of int
        Where the entries of the problem's pattern and of its mass matrix stand among the values.
    metric_row, metric_column : array of int
        Rows and columns of the entries of the mass matrix.
    metric_values : array of float
        The entries of the mass matrix.
    """

    matrix: SystemMatrix
    bulk: Index
    metric: Index
    metric_row: Index
    metric_column: Index
    metric_values: Array

    def of_pattern(self, stiffness: Array) -> Array:
        """Return the values of a matrix from those on the problem's pattern."""
        return np.asarray(np.bincount(self.bulk, weights=stiffness, minlength=self.matrix.entry_count), dtype=float)

    def add_metric(self, values: Array, weight: Array | float) -> Array:
        """Add a multiple of the mass matrix to values, or ``sqrt(weight_i weight_j) M_ij`` where each unknown has a
        weight of its own, and return them."""
        root = np.sqrt(weight) if isinstance(weight, np.ndarray) else None
        for first in range(0, len(self.metric), _AT_ONCE):
            part = slice(first, first + _AT_ONCE)
            factor = weight if root is None else root[self.metric_row[part]] * root[self.metric_column[part]]
            values[self.metric[part]] += factor * self.metric_values[part]
        return values


def direct_system(problem: Problem, touched: Index, near: float) -> System:
    """Return a matrix that is factorised.

    Penalty terms touch the unknowns `touched`; walls of a smaller gap than `near` [length] are next to closing.
    """
    bulk, metric, values = _entries(problem)
    rows, columns = (np.concatenate(part) for part in zip(bulk, metric, strict=True))
    matrix = CondensedMatrix(len(problem.free), problem.free, rows, columns, touched, near)
    return _located(matrix, bulk, metric, values)


def iterative_system(problem: Problem) -> System:
    """Return a matrix whose systems are solved by iterations."""
    bulk, metric, values = _entries(problem)
    rows, columns = (np.concatenate(part) for part in zip(bulk, metric, strict=True))
    matrix = IterativeMatrix(len(problem.free), problem.free, rows, columns, problem.part)
    return _located(matrix, bulk, metric, values)


def _located(matrix: SystemMatrix, bulk: tuple[Index, Index], metric: tuple[Index, Index], values: Array) -> System:
    at, row, column = (narrowed(index) for index in (matrix.locate(*metric), *metric))
    return System(matrix, narrowed(matrix.locate(*bulk)), at, row, column, values)


def _entries(problem: Problem) -> tuple[tuple[Index, Index], tuple[Index, Index], Array]:
    """Return the entries of the pattern and of the mass matrix, lower triangles, and the values of the latter."""
    mass = problem.mass.tocoo()
    row, column = (index.astype(np.int64) for index in mass.coords)
    lower = row >= column
    return problem.pattern, (row[lower], column[lower]), mass.data[lower]
