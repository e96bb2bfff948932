"""Preconditioned conjugate gradients for scenes too large to factorise in one piece.

Bodies are the natural subdomains: what couples them are closed walls only. So the preconditioner factorises each body
by itself, proximal term and its side of the closed penalty terms included (additive Schwarz; Smith, Bjorstad & Gropp,
Domain decomposition, 1996), and the penalty terms' other side, which no pattern has room for, acts through their
derivatives. A body among closed penalty terms is held by them, so no coarse space is needed: rigid or affine modes of
the cells spare no iteration on tissues in contact. In one tied solid bodies share unknowns: there each subdomain takes
two layers of unknowns of its neighbours along, without which ten times as many iterations are needed.

Directions of negative curvature, met by the gradients or in a body, are told as a direct solver tells them to the
minimiser: by a step that leads uphill.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.solve.linear import Factor, SymmetricMatrix
from ngcell.solve.one_sided import OneSidedModel
from ngcell.solve.stiffness import Stiffness, lower_entries

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_log = logging.getLogger(__name__)

#: Share of the first residual, in the norm of the preconditioner, at which a solution is good enough for a Newton step:
#: the decrement that it leaves is a share of about 1e-8 of that before.
RESIDUAL, MOST_ITERATIONS = 1e-4, 2000
#: Layers of neighbours' unknowns in a subdomain, where bodies share unknowns.
LAYERS = 2
#: Penalty terms whose products are held in memory at once.
TERMS_AT_ONCE = 1000


@dataclass(frozen=True, eq=False)
class Penalised:
    """A matrix with penalty terms.

    Attributes
    ----------
    stiffness : Stiffness
        The matrix without penalty terms.
    blocks : array of float
        The matrix with what penalty terms add within bodies.
    jacobian, penalty term : csr_array, array
        The penalty terms.
    """

    stiffness: Stiffness
    blocks: Array
    jacobian: sparse.csr_array
    penalty: Array


class IterativeMatrix:
    """A symmetric matrix whose systems are solved body by body, and by conjugate gradients between them.

    Couplings between bodies need no room in the pattern.

    Parameters
    ----------
    size : int
        Number of rows.
    free : array of bool, shape (size,)
        Rows that are solved for.
    rows, columns : array of int
        Entries of the lower triangle, repetitions allowed.
    part : array of int, shape (size,)
        Body of each row.
    """

    def __init__(self, size: int, free: NDArray[np.bool_], rows: Index, columns: Index, part: Index) -> None:
        self._whole = SymmetricMatrix(size, free, rows, columns)
        self._free, self._part = free, part
        self._subdomains = _subdomains(self._whole.lower_pattern, free, part)
        self._penalised: Penalised | None = None
        self.iterations = 0

    @property
    def size(self) -> int:
        """Number of rows."""
        return self._whole.size

    @property
    def entry_count(self) -> int:
        """Number of entries of the pattern."""
        return self._whole.entry_count

    def locate(self, rows: Index, columns: Index) -> Index:
        """Return the positions of entries of the pattern in the array of values."""
        return self._whole.locate(rows, columns)

    def forget(self) -> None:
        """Do nothing: what is factorised lasts."""

    def factorise(self, stiffness: Stiffness, jacobian: sparse.csr_array, penalty: Array) -> None:
        """Factorise all bodies, with their side of the penalty terms."""
        blocks = stiffness.values.copy()
        if stiffness.moving is not None:
            row, column, data = lower_entries(stiffness.moving)
            position, is_there = self._whole.find(row, column)
            np.add.at(blocks, position[is_there], data[is_there])
        for first in range(0, len(penalty), TERMS_AT_ONCE):
            some = slice(first, first + TERMS_AT_ONCE)
            self._add_within_bodies(blocks, Stiffness(blocks).with_penalty(jacobian[some], penalty[some]))
        self._penalised = Penalised(stiffness, blocks, jacobian, penalty)
        for subdomain in self._subdomains:
            subdomain.factorise(blocks)

    def _add_within_bodies(self, blocks: Array, product: sparse.csr_array) -> None:
        """Add the product of penalty terms within bodies.

        What has no room, as where one penalty term pulls at many faces, counts on the diagonal: blocks stay definite.
        """
        row, column, data = lower_entries(product)
        mine = self._part[row] == self._part[column]
        row, column, data = row[mine], column[mine], data[mine]
        position, is_there = self._whole.find(row, column)
        np.add.at(blocks, position[is_there], data[is_there])
        row, column, weight = row[~is_there], column[~is_there], np.abs(data[~is_there])
        for end in (row, column):
            np.add.at(blocks, self._whole.locate(end, end), weight)

    @property
    def few(self) -> int:
        """None: a solution is what costs."""
        return 0

    def multiply(self, stiffness: Stiffness, vector: Array) -> Array:
        """Return the product of the symmetric matrix and a vector."""
        return np.asarray(self._whole.multiply(stiffness.values, vector) + stiffness.moved(vector))

    def reduced(self, model: OneSidedModel) -> None:
        """Return nothing: gradients go with the whole matrix."""

    def solve(self, right: Array) -> Array:
        """Return the solution of the system, or a multiple of a direction of negative curvature; 0 in rows not free.

        With the curvature ``c = d K d < 0`` of a direction d, that is ``(right d / c) d``.
        """
        assert self._penalised is not None
        right = np.where(self._free, right, 0.0)
        solution, residual = np.zeros_like(right), right
        step, before, first = np.zeros_like(right), 1.0, 0.0
        for _ in range(MOST_ITERATIONS):
            towards, concave = self._preconditioned(residual)
            if concave is not None:
                return self._uphill(right, concave)
            slope = float(residual @ towards)
            first = first or slope
            if slope <= RESIDUAL**2 * first:
                break
            self.iterations += 1
            step = towards + slope / before * step if step.any() else towards
            before = slope
            stretched = np.where(self._free, self._product(self._penalised, step), 0.0)
            curvature = float(step @ stretched)
            if curvature <= 0:
                return self._uphill(right, step)
            solution = solution + slope / curvature * step
            residual = residual - slope / curvature * stretched
        else:
            _log.info("conjugate gradients stopped at a residual of %.1e", np.sqrt(slope / first))
        return solution

    def _product(self, penalised: Penalised, vector: Array) -> Array:
        product = self.multiply(penalised.stiffness, vector)
        return np.asarray(product + penalised.jacobian.T @ (penalised.penalty * (penalised.jacobian @ vector)))

    def _preconditioned(self, residual: Array) -> tuple[Array, Array | None]:
        """Return the sum of the solutions on all subdomains, and one with negative curvature, if there is any."""
        towards = np.zeros_like(residual)
        for subdomain in self._subdomains:
            mine = residual[subdomain.rows]
            part = subdomain.solve(mine)
            if float(mine @ part) < 0:
                concave = np.zeros_like(residual)
                concave[subdomain.rows] = part
                return towards, concave
            towards[subdomain.rows] += part
        return towards, None

    def _uphill(self, right: Array, direction: Array) -> Array:
        _log.info("negative curvature")
        assert self._penalised is not None
        curvature = float(direction @ self._product(self._penalised, direction))
        return float(right @ direction) / curvature * direction


class _Subdomain:
    """Rows of a body, and the matrix on them.

    Parameters
    ----------
    pattern : csr_array
        Lower triangle; its data are positions in the array of values.
    rows : array of int
        The rows, increasing.
    """

    def __init__(self, pattern: sparse.csr_array, rows: Index) -> None:
        self.rows = rows
        number = np.full(pattern.shape[0], -1)
        number[rows] = np.arange(len(rows))
        mine = pattern[rows]
        row, column = np.repeat(np.arange(len(rows)), np.diff(mine.indptr)), number[mine.indices]
        kept = column >= 0
        row, column, self._position = row[kept], column[kept], mine.data[kept]
        pointer = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=len(rows)))])
        lower = sparse.csr_array((np.zeros(len(row)), column, pointer), shape=(len(rows),) * 2)
        self._factor = Factor(lower, np.ones(len(rows), dtype=bool))

    def factorise(self, values: Array) -> None:
        """Factorise the part of a matrix with these values."""
        self._factor.update(values[self._position])

    def solve(self, right: Array) -> Array:
        """Return the solution on this subdomain."""
        return self._factor.solve(right)


def _subdomains(pattern: sparse.csr_array, free: NDArray[np.bool_], part: Index) -> list[_Subdomain]:
    """Return the subdomains: free rows of each body, with neighbours where the pattern couples bodies."""
    row = np.repeat(np.arange(len(part)), np.diff(pattern.indptr))
    coupled = part[row] != part[pattern.indices]
    member = [part == number for number in range(int(part.max()) + 1)]
    if coupled.any():
        ones = sparse.csr_array((np.ones(len(row)), pattern.indices, pattern.indptr), shape=pattern.shape)
        for mask in member:
            for _ in range(LAYERS):
                reached = mask.astype(float)
                mask |= (ones @ reached + ones.T @ reached) > 0
    rows = (np.flatnonzero(mask & free) for mask in member)
    return [_Subdomain(pattern, mine) for mine in rows if len(mine)]
