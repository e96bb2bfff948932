"""Symmetric matrices that are held in two parts: one whose pattern lasts, and one that comes and goes with contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Stiffness:
    """A symmetric matrix.

    Attributes
    ----------
    values : array of float
        What stands on a pattern that lasts.
    moving : csr_array or None
        What is added to it, both triangles.
    """

    values: Array
    moving: sparse.csr_array | None = None

    def moved(self, vector: Array) -> Array | float:
        """Return the product of the moving part and a vector; 0 where there is none."""
        return 0.0 if self.moving is None else np.asarray(self.moving @ vector)

    def with_penalty(self, jacobian: sparse.csr_array, penalty: Array) -> sparse.csr_array:
        """Return the moving part plus ``jacobian.T @ diag(penalty) @ jacobian``."""
        weights = np.repeat(penalty, np.diff(jacobian.indptr))
        forces = sparse.csr_array((weights * jacobian.data, jacobian.indices, jacobian.indptr), shape=jacobian.shape)
        product = (jacobian.T @ forces).tocsr()
        return product if self.moving is None else product + self.moving


def lower_entries(matrix: sparse.sparray) -> tuple[Index, Index, Array]:
    """Return rows, columns and values of the lower triangle of a symmetric matrix."""
    part = matrix.tocoo()
    row, column = (index.astype(np.int64) for index in part.coords)
    lower = row >= column
    return row[lower], column[lower], part.data[lower]
