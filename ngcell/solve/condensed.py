"""A symmetric matrix from which unknowns within finite elements are eliminated before it is factorised.

Contact couples unknowns on walls only. Those within elements are eliminated once for each second-order model (static
condensation; Wilson, Int. J. Numer. Meth. Eng. 8, 1974, doi:10.1002/nme.1620080115), all elements of a kind together,
and what is factorised again and again, as walls close and open, is the matrix of what is left.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.solve.cliques import Cliques, find_cliques
from ngcell.solve.coarse import Bodies, CoarseSpace
from ngcell.solve.eliminated import Eliminated
from ngcell.solve.growing import GrowingMatrix
from ngcell.solve.linear import SymmetricMatrix
from ngcell.solve.one_sided import Coarse, OneSidedModel
from ngcell.solve.stiffness import Stiffness

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Elimination:
    """Which unknowns of a pattern are eliminated, and the matrix of those that are kept.

    Parameters
    ----------
    whole : SymmetricMatrix
        The pattern.
    free : array of bool, shape (size,)
        Rows that are solved for.
    touched : array of bool, shape (size,)
        Unknowns that are kept, whatever the pattern.
    bodies : Bodies or None
        Which bodies unknowns are of, if modes of bodies are of use.

    Attributes
    ----------
    space : CoarseSpace or None
        The low modes of bodies, if they are of use.
    """

    def __init__(self, whole: SymmetricMatrix, free: Mask, touched: Mask, bodies: Bodies | None) -> None:
        lower, size = whole.lower_pattern, whole.size
        row = np.repeat(np.arange(size, dtype=np.int32), np.diff(lower.indptr))
        inside = free[row] & free[lower.indices]
        pointer = np.concatenate([[0], np.cumsum(np.bincount(row[inside], minlength=size))])
        of_free = sparse.csr_array((lower.data[inside], lower.indices[inside], pointer), shape=lower.shape)
        self.cliques = find_cliques(of_free, free & ~touched)
        del inside, of_free  # as large as all that is kept
        self.is_kept = is_kept = np.ones(size, dtype=bool)
        for cliques in self.cliques:
            is_kept[cliques.inside] = False
        self.kept = np.flatnonzero(is_kept)
        self._number = np.where(is_kept, np.cumsum(is_kept) - 1, -1)
        self._is_left = is_kept[row] & is_kept[lower.indices]
        rows, columns = self._number[row[self._is_left]], self._number[lower.indices[self._is_left]]
        self.matrix = GrowingMatrix(len(self.kept), free[self.kept], rows, columns)
        self.space = None if bodies is None else bodies.space(self.matrix.lasting, free, touched, self.kept)
        self._triangles = [self._triangle(cliques) for cliques in self.cliques]

    def _triangle(self, cliques: Cliques) -> Index:
        """Return where the entries of the lower triangle of neighbours stand among the values that are left."""
        row, column = np.tril_indices(cliques.around.shape[1])
        around = self._number[cliques.around]
        return self.matrix.locate(around[:, row].ravel(), around[:, column].ravel())

    def forget(self) -> None:
        """Make room for closed walls anew, and find modes anew."""
        self.matrix.forget()
        if self.space is not None:
            self.space.forget()

    def keeps(self, unknowns: Index) -> bool:
        """Return whether all of these are kept."""
        return bool((self._number[unknowns] >= 0).all())

    def derivatives(self, jacobian: sparse.csr_array) -> sparse.csr_array:
        """Return derivatives by the unknowns that are kept."""
        column = self._number[jacobian.indices]
        return sparse.csr_array((jacobian.data, column, jacobian.indptr), shape=(jacobian.shape[0], len(self.kept)))

    def of(self, stiffness: Stiffness) -> Condensed:
        """Return a matrix, condensed."""
        left, parts = stiffness.values[self._is_left], list[Eliminated]()
        for cliques, position in zip(self.cliques, self._triangles, strict=True):
            part, change = Eliminated.of(cliques, stiffness.values)
            left = left - np.bincount(position, change.ravel(), len(left))
            parts.append(part)
        moving = stiffness.moving
        if moving is not None:
            columns = self.derivatives(moving)
            moving = self.derivatives(columns.T.tocsr())  # symmetric
        return Condensed(self, Stiffness(left, moving), parts)


@dataclass(frozen=True, eq=False)
class Condensed:
    """The matrix of the unknowns that are kept.

    Attributes
    ----------
    elimination : Elimination
        Which they are.
    stiffness : Stiffness
        Their matrix.
    parts : list of Eliminated
        What is eliminated, for each size of cliques.
    """

    elimination: Elimination
    stiffness: Stiffness
    parts: list[Eliminated]

    def right(self, right: Array) -> Array:
        """Return the right-hand side for the unknowns that are kept."""
        left = right
        for part in self.parts:
            left = left - np.bincount(part.cliques.around.ravel(), part.taken(right).ravel(), len(right))
        return left[self.elimination.kept]

    def alone(self, right: Array) -> list[Array]:
        """Return the solutions of what is eliminated, the rest at 0: for each size of cliques, shape (cliques, m)."""
        return [part.alone(right) for part in self.parts]

    def solution(self, alone: list[Array], kept: Array) -> Array:
        """Return the whole solution from that of the unknowns that are kept, and those of `alone`."""
        whole = np.zeros(len(self.elimination.is_kept))
        whole[self.elimination.kept] = kept
        for part, own in zip(self.parts, alone, strict=True):
            whole[part.cliques.inside] = own - part.following(whole)
        return whole

    def change(self, right: Array, alone: list[Array]) -> float:
        """Return the change of ``x K x / 2 - right x`` as what is eliminated finds its minimum, the rest at 0."""
        pairs = zip(self.elimination.cliques, alone, strict=True)
        return -0.5 * sum(float(np.vdot(right[cliques.inside], own)) for cliques, own in pairs)


@dataclass(frozen=True, eq=False)
class Reduced:
    """A model of the unknowns that are kept, and the matrix that solves for it."""

    model: OneSidedModel
    matrix: GrowingMatrix
    condensed: Condensed
    right: Array
    space: CoarseSpace | None

    def whole(self, step: Array) -> Array:
        """Return the step of all unknowns."""
        return self.condensed.solution(self._alone, step)

    @property
    def change(self) -> float:
        """Change of the model as what is eliminated finds its minimum."""
        return self.condensed.change(self.right, self._alone)

    @cached_property
    def coarse(self) -> Coarse | None:
        """The model among low modes of bodies; None without penalty terms, or among few bodies."""
        return None if self.space is None or not len(self.model.gap) else self.space.of(self.model)

    @cached_property
    def _alone(self) -> list[Array]:
        return self.condensed.alone(self.right)


class CondensedMatrix:
    """A symmetric matrix with a lasting pattern that eliminates unknowns within elements before it factorises.

    Parameters
    ----------
    size, free, rows, columns
        See `SymmetricMatrix`.
    touched : array of int
        Unknowns that penalty terms may touch. Others that they do touch are kept from then on.
    near : float
        Gap up to which walls are next to closing [length].
    bodies : Bodies, optional
        Which bodies unknowns are of, if modes of bodies are of use.
    """

    def __init__(
        self,
        size: int,
        free: Mask,
        rows: Index,
        columns: Index,
        touched: Index,
        near: float,
        bodies: Bodies | None = None,
    ) -> None:
        self._whole = SymmetricMatrix(size, free, rows, columns)
        self._free, self._near, self._bodies = free, near, bodies
        self._touched = np.zeros(size, dtype=bool)
        self._touched[touched] = True
        self._elimination = self._first = Elimination(self._whole, free, self._touched, bodies)
        self._found: tuple[Stiffness, Condensed] | None = None
        self._solved: Condensed | None = None

    @property
    def entry_count(self) -> int:
        """Number of entries of the pattern."""
        return self._whole.entry_count

    def locate(self, rows: Index, columns: Index) -> Index:
        """Return the positions of entries of the pattern in the array of values."""
        return self._whole.locate(rows, columns)

    def forget(self) -> None:
        """Make room for closed walls anew, and keep what was kept at first."""
        self._elimination, self._found, self._solved = self._first, None, None
        self._elimination.forget()

    def factorise(self, stiffness: Stiffness, jacobian: sparse.csr_array, penalty: Array) -> None:
        """Factorise the matrix of what is left, with penalty terms."""
        self._solved = self._condensed(stiffness, jacobian)
        derivatives = self._elimination.derivatives(jacobian)
        self._elimination.matrix.factorise(self._solved.stiffness, derivatives, penalty)

    @property
    def few(self) -> int:
        """Number of solutions that take no more operations than a factorisation."""
        return self._elimination.matrix.few

    def solve(self, right: Array) -> Array:
        """Return the solution of the factorised system; 0 in rows that are not free."""
        assert self._solved is not None  # `factorise` has made it
        right, solved = np.where(self._free, right, 0.0), self._solved
        return solved.solution(solved.alone(right), solved.elimination.matrix.solve(solved.right(right)))

    def multiply(self, stiffness: Stiffness, vector: Array) -> Array:
        """Return the product of the symmetric matrix and a vector."""
        return np.asarray(self._whole.multiply(stiffness.values, vector) + stiffness.moved(vector))

    def reduced(self, model: OneSidedModel) -> Reduced:
        """Return the model of the unknowns that are kept."""
        condensed = self._condensed(model.stiffness, model.jacobian)
        matrix, jacobian = self._elimination.matrix, self._elimination.derivatives(model.jacobian)
        matrix.expect(jacobian[np.flatnonzero(model.gap < self._near)])
        right = -model.gradient
        free = self._free[self._elimination.kept]
        left = OneSidedModel(-condensed.right(right), condensed.stiffness, model.gap, jacobian, model.penalty, free)
        return Reduced(left, matrix, condensed, right, self._elimination.space)

    def _condensed(self, stiffness: Stiffness, jacobian: sparse.csr_array) -> Condensed:
        """Return a matrix, condensed; all unknowns that contact touches are kept."""
        parts = [jacobian] if stiffness.moving is None else [jacobian, stiffness.moving]
        if not all(self._elimination.keeps(part.indices) for part in parts):
            touched = self._touched.copy()
            touched[self._elimination.kept] = True
            for part in parts:
                touched[part.indices] = True
            self._elimination, self._found = Elimination(self._whole, self._free, touched, self._bodies), None
        if self._found is None or self._found[0] is not stiffness:
            self._found = stiffness, self._elimination.of(stiffness)
        return self._found[1]
