"""Which unknowns are solved for: all of them, or those that stand for the unknowns tied to them.

A tie is a map of unknowns and no energy: unknowns keep their numbers, those of a tied wall follow a master,
``u = sign u[master]``, and are not free.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.tie import Tie

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class UnknownMap(Protocol):
    """How all unknowns follow from those that are solved for."""

    free: NDArray[np.bool_]

    @property
    def lets_bodies_part(self) -> bool:
        """Whether each body moves by itself."""

    def expand(self, displacement: Array) -> Array:
        """Return the displacement of all unknowns."""

    def gather(self, force: Array) -> Array:
        """Return forces on all unknowns as forces on those that are solved for."""

    def reactions(self, force: Array) -> Array:
        """Return the part of nodal forces that the supports bear, shape (unknowns,); zero elsewhere."""

    def fold(self, row: Index, column: Index) -> tuple[Index, Index, NDArray[Any] | None]:
        """Return where entries of a lower triangle go, and the factors they take with them; None where all are 1."""

    def fold_matrix(self, matrix: sparse.csr_array) -> sparse.csr_array:
        """Return a symmetric matrix in the unknowns that are solved for."""

    def fold_curvature(self, matrix: sparse.coo_array) -> sparse.coo_array:
        """Return a symmetric matrix of entries, repetitions allowed, in the unknowns that are solved for."""

    def fold_columns(self, jacobian: sparse.csr_array) -> sparse.csr_array:
        """Return derivatives by all unknowns as those by the unknowns that are solved for."""


class OwnUnknowns:
    """Every unknown stands for itself.

    Parameters
    ----------
    fixed : array of bool, shape (unknowns,)
        Unknowns with prescribed displacement.
    """

    lets_bodies_part = True

    def __init__(self, fixed: NDArray[np.bool_]) -> None:
        self._fixed, self.free = fixed, ~fixed

    def expand(self, displacement: Array) -> Array:
        """Return the displacement as it is."""
        return displacement

    def gather(self, force: Array) -> Array:
        """Return the forces as they are."""
        return force

    def reactions(self, force: Array) -> Array:
        """Return the forces on fixed unknowns."""
        return np.where(self._fixed, force, 0.0)

    def fold(self, row: Index, column: Index) -> tuple[Index, Index, NDArray[Any] | None]:
        """Return the entries, mirrored where they are of the upper triangle; a copy only where some are."""
        if (row >= column).all():
            return row, column, None
        return np.maximum(row, column), np.minimum(row, column), None

    def fold_matrix(self, matrix: sparse.csr_array) -> sparse.csr_array:
        """Return the matrix as it is."""
        return matrix

    def fold_curvature(self, matrix: sparse.coo_array) -> sparse.coo_array:
        """Return the matrix as it is."""
        return matrix

    def fold_columns(self, jacobian: sparse.csr_array) -> sparse.csr_array:
        """Return the derivatives as they are."""
        return jacobian


class TiedUnknowns:
    """Unknowns of tied walls follow their masters.

    Parameters
    ----------
    tie : Tie
        The tie of scalar unknowns.
    space : DisplacementSpace
        The unknowns.
    fixed : array of bool, shape (unknowns,)
        Unknowns with prescribed displacement.
    """

    lets_bodies_part = False

    def __init__(self, tie: Tie, space: DisplacementSpace, fixed: NDArray[np.bool_]) -> None:
        first = space.size * np.arange(space.dimension)
        self._master = (tie.master + first[:, None]).ravel().astype(np.int32)  # half of the memory of wider ones
        self._sign, self._fixed = np.tile(tie.sign, space.dimension), fixed
        held = np.zeros(space.unknowns, dtype=bool)
        np.logical_or.at(held, self._master, fixed)
        self.free = ~held & (self._master == np.arange(space.unknowns))

    def expand(self, displacement: Array) -> Array:
        """Return the displacement with tied unknowns following their masters."""
        return np.asarray(self._sign * displacement[self._master])

    def gather(self, force: Array) -> Array:
        """Return the sum of the forces on all unknowns that follow each master."""
        return np.asarray(np.bincount(self._master, weights=self._sign * force, minlength=len(force)), dtype=float)

    def reactions(self, force: Array) -> Array:
        """Return the forces on fixed masters; that on a tied node is borne by one of its fixed members."""
        reaction, member = np.zeros_like(force), np.flatnonzero(self._fixed)
        held, first = np.unique(self._master[member], return_index=True)
        reaction[member[first]] = self._sign[member[first]] * self.gather(force)[held]
        return reaction

    def fold(self, row: Index, column: Index) -> tuple[Index, Index, NDArray[Any]]:
        """Return the entries of the masters.

        An off-diagonal entry that is folded onto the diagonal stands for itself and its mirror image.
        """
        master, sign = self._master, self._sign.astype(np.int8)
        is_off_diagonal, signs = row != column, sign[row] * sign[column]
        row, column = master[row], master[column]
        signs[is_off_diagonal & (row == column)] *= 2
        return np.maximum(row, column), np.minimum(row, column), signs

    def fold_matrix(self, matrix: sparse.csr_array) -> sparse.csr_array:
        """Return the matrix in the masters."""
        return (self._spread.T @ matrix @ self._spread).tocsr()

    def fold_curvature(self, matrix: sparse.coo_array) -> sparse.coo_array:
        """Return the matrix in the masters."""
        return self.fold_matrix(matrix.tocsr()).tocoo()

    def fold_columns(self, jacobian: sparse.csr_array) -> sparse.csr_array:
        """Return the derivatives by the masters."""
        return (jacobian @ self._spread).tocsr()

    @cached_property
    def _spread(self) -> sparse.csr_array:
        """The map from masters to all unknowns."""
        size = len(self._sign)
        return sparse.csr_array((self._sign, (np.arange(size), self._master)), shape=(size, size))
