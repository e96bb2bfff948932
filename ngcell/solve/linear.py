"""A symmetric matrix with a lasting pattern, factorised in place.

NGSolve's `sparsecholesky` reads the lower triangle only and reuses its symbolic factor while the matrix object stays
the same. Building a matrix from coordinates costs as much as a few factorisations, so only values are written while the
pattern holds. The factorisation does not pivot and
does not tell a matrix that is not positive definite: the caller judges directions, not factors.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import ngsolve
import ngsolve.la
import numpy as np
import pyngcore
from numpy.typing import NDArray
from scipy import sparse

from ngcell.threads import at_once, in_parallel

Array = NDArray[np.float64]
Index = NDArray[np.int64]
#: Indices in 32 bits.
Narrow = NDArray[Any]
#: Entries that are looked for at once: few enough that what is needed on the way takes no memory to speak of.
_AT_ONCE = 2**20


class PatternError(Exception):
    """An entry lies outside the pattern; the matrix has to be made anew."""


class SymmetricMatrix:
    """Lower triangle of a symmetric matrix.

    Parameters
    ----------
    size : int
        Number of rows.
    free : array of bool, shape (size,)
        Rows that are solved for.
    rows, columns : array of int
        Entries of the lower triangle, repetitions allowed.
    """

    def __init__(self, size: int, free: NDArray[np.bool_], rows: Index, columns: Index) -> None:
        keys = _keys(size, rows, columns)
        row = keys // size
        columns = (keys - size * row).astype(np.int32)  # half of the memory of wider ones
        self._take(size, free, keys, columns, np.cumsum(np.bincount(row, minlength=size)))

    def _take(self, size: int, free: NDArray[np.bool_], keys: Index, columns: Narrow, ends: Narrow) -> None:
        self.size, self._free, self._keys, self._columns = size, free, keys, columns
        self._pointer = np.concatenate([[0], ends]).astype(np.int32)
        self._loaded: tuple[Array, sparse.csr_array, sparse.csc_array] | None = None

    def grown(self, rows: Index, columns: Index) -> tuple[SymmetricMatrix, Narrow]:
        """Return a matrix with room for more entries, and where those of this one stand in it."""
        more = _keys(self.size, rows, columns)
        before = np.searchsorted(self._keys, more)
        is_new = self._keys[np.minimum(before, len(self._keys) - 1)] != more
        more, before = more[is_new], before[is_new]
        row, matrix = more // self.size, SymmetricMatrix.__new__(SymmetricMatrix)
        keys, columns = np.insert(self._keys, before, more), np.insert(self._columns, before, more - self.size * row)
        ends = self._pointer[1:] + np.cumsum(np.bincount(row, minlength=self.size))
        matrix._take(self.size, self._free, keys, columns, ends)
        added = np.cumsum(np.bincount(before, minlength=len(self._keys) + 1)[:-1], dtype=np.int32)
        return matrix, np.arange(len(self._keys), dtype=np.int32) + added

    @property
    def entry_count(self) -> int:
        """Number of entries of the pattern."""
        return len(self._keys)

    @property
    def entries(self) -> tuple[Narrow, Narrow]:
        """Rows and columns of the pattern, in the order of values."""
        row = np.repeat(np.arange(self.size, dtype=np.int32), np.diff(self._pointer))
        return row, self._columns

    @property
    def lower_pattern(self) -> sparse.csr_array:
        """The pattern, shape (size, size); its data are the positions of entries in the array of values."""
        return self._with(np.arange(self.entry_count, dtype=np.int32))

    def _with(self, values: NDArray[Any]) -> sparse.csr_array:
        """Return the lower triangle with these values."""
        return sparse.csr_array((values, self._columns, self._pointer), shape=(self.size, self.size))

    @cached_property
    def _diagonal(self) -> tuple[Index, Index]:
        """Where the entries of the diagonal stand, and their rows."""
        row, column = self.entries
        place = np.flatnonzero(row == column)
        return place, row[place]

    @cached_property
    def _factor(self) -> Factor:
        """Made when it is needed for the first time."""
        return Factor(self.lower_pattern, self._free)

    def locate(self, rows: Index, columns: Index) -> Index:
        """Return the positions of entries in the array of values.

        Raises
        ------
        PatternError
            If an entry is not part of the pattern.
        """
        positions: Index = np.empty(len(rows), dtype=np.int32)
        for first in range(0, len(rows), _AT_ONCE):
            part = slice(first, first + _AT_ONCE)
            positions[part], is_there = self.find(rows[part], columns[part])
            if not is_there.all():
                raise PatternError
        return positions

    def find(self, rows: Index, columns: Index) -> tuple[Index, NDArray[np.bool_]]:
        """Return the positions of entries, and whether they are part of the pattern."""
        wanted = rows.astype(np.int64) * self.size + columns
        if np.array_equal(wanted, self._keys):
            return np.arange(len(wanted)), np.ones(len(wanted), dtype=bool)
        position = np.minimum(np.searchsorted(self._keys, wanted), len(self._keys) - 1)
        return position, self._keys[position] == wanted

    def factorise(self, values: Array) -> None:
        """Factorise the matrix with these values."""
        self._factor.update(values)

    @property
    def few(self) -> int:
        """Number of solutions that take no more operations than a factorisation."""
        return self._factor.few

    def solve(self, right: Array) -> Array:
        """Return the solution of the factorised system; 0 in rows that are not free."""
        return self._factor.solve(right)

    def multiply(self, values: Array, vector: Array) -> Array:
        """Return the product of the symmetric matrix with these values and a vector."""
        if self._loaded is None or values is not self._loaded[0]:
            lower = self._with(values)
            self._loaded = values, lower, lower.T  # shares the values
        _, lower, upper = self._loaded
        below, above = at_once(self.size, [lambda: lower @ vector, lambda: upper @ vector])
        product = below + above
        place, row = self._diagonal
        product[row] -= values[place] * vector[row]
        return np.asarray(product)


class Factor:
    """NGSolve's matrix and its Cholesky factor.

    Parameters
    ----------
    lower : csr_array
        The pattern of the lower triangle.
    free : array of bool, shape (size,)
        Rows that are solved for.
    """

    def __init__(self, lower: sparse.csr_array, free: NDArray[np.bool_]) -> None:
        size = len(free)
        row, values = np.repeat(np.arange(size), np.diff(lower.indptr)), np.zeros(lower.nnz)
        entries = _copied(pyngcore.Array_I_S, row), _copied(pyngcore.Array_I_S, lower.indices)
        self._matrix = ngsolve.la.SparseMatrixd.CreateFromCOO(*entries, _copied(pyngcore.Array_D_S, values), size, size)
        self._values = np.asarray(self._matrix.CSR()[0])
        self._free = ngsolve.BitArray(free.tolist())
        self._inverse: ngsolve.BaseMatrix | None = None
        self._right = self._matrix.CreateColVector()
        self._left = self._matrix.CreateColVector()

    def update(self, values: Array) -> None:
        """Factorise the matrix with these values."""
        self._values[:] = values
        with in_parallel(self._matrix.height):
            if self._inverse is None:
                self._inverse = self._matrix.Inverse(self._free, "sparsecholesky")
            else:
                self._inverse.Update()

    @cached_property
    def few(self) -> int:
        """Number of solutions that take no more operations than a factorisation; asked for after the first one.

        With c entries in a column, a factorisation takes c^2 operations a column, and a solution 4 c.
        """
        assert self._inverse is not None  # the pattern of the factor stays that of the first factorisation
        entries, height = int(self._inverse.nze), int(self._matrix.height)
        return entries // (4 * height)

    def solve(self, right: Array) -> Array:
        """Return the solution; 0 in rows that are not free."""
        self._right.FV().NumPy()[:] = right
        assert self._inverse is not None  # `update` has made one
        with in_parallel(self._matrix.height):
            self._inverse.Mult(self._right, self._left)
        return np.array(self._left.FV().NumPy())


def _keys(size: int, rows: Index, columns: Index) -> Index:
    """Return the numbers of entries, row by row, each of them once.

    Numpy's `unique` hashes whole numbers: two million of them took 1.8 s, and take 0.07 s here.
    """
    keys = rows.astype(np.int64) * size
    keys += columns
    keys.sort(kind="stable")  # it merges the few runs of patterns
    is_first = np.ones(len(keys), dtype=bool)
    np.not_equal(keys[1:], keys[:-1], out=is_first[1:])
    return keys[is_first]


def _copied(kind: type, values: NDArray[Any]) -> Any:
    """Return an array of NGSolve's with these values; left to itself, NGSolve takes them from numpy one by one."""
    array = kind(len(values))
    array.NumPy()[:] = values
    return array
