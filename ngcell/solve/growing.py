"""A symmetric matrix to which the couplings of closed walls are added, and its factor.

The symbolic part of a factor is kept while all entries have room in it. Room for all walls that are near would be dear:
it takes several times the operations of a matrix with room for those that are closed. So there is room for walls that
are closed or next to closing, and where others close it is made anew, at the price of two or three factorisations.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.solve.linear import SymmetricMatrix
from ngcell.solve.one_sided import OneSidedModel
from ngcell.solve.stiffness import Stiffness, lower_entries

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


class GrowingMatrix:
    """A matrix on a pattern that lasts, with others added to it.

    Parameters
    ----------
    size, free, rows, columns
        The pattern that lasts; see `SymmetricMatrix`.

    Attributes
    ----------
    lasting : SymmetricMatrix
        A matrix of the lasting pattern alone.
    """

    def __init__(self, size: int, free: Mask, rows: Index, columns: Index) -> None:
        self.lasting = SymmetricMatrix(size, free, rows, columns)
        self._expected: sparse.csr_array | None = None
        self._roomy: tuple[SymmetricMatrix, Index] | None = None

    def locate(self, rows: Index, columns: Index) -> Index:
        """Return the positions of entries of the lasting pattern in the array of values."""
        return self.lasting.locate(rows, columns)

    def expect(self, jacobian: sparse.csr_array) -> None:
        """Let the next pattern have room for these penalty terms."""
        self._expected = jacobian

    def forget(self) -> None:
        """Make the next pattern anew."""
        self._expected = self._roomy = None

    def factorise(self, stiffness: Stiffness, jacobian: sparse.csr_array, penalty: Array) -> None:
        """Factorise the matrix with penalty terms."""
        row, column, data = lower_entries(stiffness.with_penalty(jacobian, penalty))
        matrix, place = self._roomy = self._roomy or self._with_room(row, column)
        position, is_there = matrix.find(row, column)
        if not is_there.all():
            matrix, place = self._roomy = self._with_room(row, column)
            position = matrix.locate(row, column)
        summed = np.zeros(matrix.entry_count)
        summed[place] = stiffness.values
        summed[position] += data
        matrix.factorise(summed)

    def _with_room(self, row: Index, column: Index) -> tuple[SymmetricMatrix, Index]:
        """Return a matrix with room for these entries and for those expected, and where the lasting ones stand in it.
        """
        parts = [(row, column)]
        if self._expected is not None:
            ones = self._expected.copy()
            ones.data[:] = 1.0  # no product of derivatives vanishes by accident
            parts.append(lower_entries(ones.T @ ones)[:2])
        return self.lasting.grown(*map(np.concatenate, zip(*parts, strict=True)))

    @property
    def few(self) -> int:
        """Number of solutions that take no more operations than a factorisation."""
        return self._factorised.few

    def solve(self, right: Array) -> Array:
        """Return the solution of the factorised system; 0 in rows that are not free."""
        return self._factorised.solve(right)

    @property
    def _factorised(self) -> SymmetricMatrix:
        assert self._roomy is not None  # `factorise` has made it
        return self._roomy[0]

    def multiply(self, stiffness: Stiffness, vector: Array) -> Array:
        """Return the product of the symmetric matrix and a vector."""
        return np.asarray(self.lasting.multiply(stiffness.values, vector) + stiffness.moved(vector))

    def reduced(self, model: OneSidedModel) -> None:
        """Return nothing: all of it is factorised."""
