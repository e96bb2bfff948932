"""The inner problem among the low modes of bodies: few unknowns, in which walls close and open cheaply.

A round of the inner iteration ends where walls close, and among many cells some wall closes soon: cells that
nothing holds would move far. Most of such ways are motions and bending of whole cells. So before each round the model
is minimised among the low modes of all bodies, where a round costs little, as smooth parts of an error are removed on
coarse grids (with one-sided constraints: Kornhuber, Numer. Math. 69, 1994, doi:10.1007/BF03325426).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.solve.growing import GrowingMatrix
from ngcell.solve.linear import SymmetricMatrix
from ngcell.solve.low_modes import LowModes
from ngcell.solve.one_sided import Coarse, OneSidedModel
from ngcell.solve.options import CoarseOptions
from ngcell.solve.problem import Problem
from ngcell.solve.stiffness import Stiffness

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Bodies:
    """Bodies whose low modes are of use.

    Attributes
    ----------
    part : array of int, shape (unknowns,)
        Body of each unknown.
    options : CoarseOptions
        The method's own numbers.
    """

    part: Index
    options: CoarseOptions

    @classmethod
    def of(cls, problem: Problem, options: CoarseOptions) -> Bodies | None:
        """Return bodies of planar scenes if there are many, and nothing but constraints acts between them.

        Bonds do: what is low in energy for a body alone then is not, and modes gain nothing. In prisms they gain
        as often as they lose.
        """
        is_many = problem.part.max(initial=-1) + 1 >= options.fewest
        is_fit = is_many and problem.dimension == 2 and not problem.has_history
        return cls(problem.part, options) if is_fit else None

    def space(self, matrix: SymmetricMatrix, free: Mask, walls: Mask, kept: Index) -> CoarseSpace:
        """Return the low modes of the unknowns that are kept of all, with a matrix of these."""
        return CoarseSpace(matrix, LowModes(free[kept], self.part[kept], walls[kept], self.options.modes), self.options)


class CoarseSpace:
    """The low modes of bodies, kept from model to model.

    Parameters
    ----------
    matrix : SymmetricMatrix
        The matrix of bodies without constraints.
    modes : LowModes
        The modes.
    options : CoarseOptions
        The method's own numbers.
    """

    def __init__(self, matrix: SymmetricMatrix, modes: LowModes, options: CoarseOptions) -> None:
        self._matrix, self._modes, self._options, self._is_begun = matrix, modes, options, False
        each = np.arange(len(self._modes.is_mode))
        self._among = GrowingMatrix(len(each), self._modes.is_mode, each, each)

    def forget(self) -> None:
        """Begin anew."""
        self._modes.forget()
        self._among.forget()
        self._is_begun = False

    def of(self, model: OneSidedModel) -> Coarse | None:
        """Return a model among modes; None where its matrix has no inverse."""
        values, moving = model.stiffness.values, model.stiffness.moving
        steps = 1 if self._is_begun else self._options.first_steps
        self._is_begun = self._modes.iterate(self._matrix, values, steps)
        if not self._is_begun:
            return None
        basis, energies = self._modes.basis, self._modes.energies.ravel()
        moved = None if moving is None else (basis.T @ (moving @ basis)).tocsr()
        jacobian = (model.jacobian @ basis).tocsr()
        self._among.expect(jacobian[_one_of_each(jacobian, self._options.modes)])
        free = self._modes.is_mode
        stiffness, nothing = Stiffness(energies, moved), np.zeros(len(free))
        return Coarse(basis, OneSidedModel(nothing, stiffness, model.gap, jacobian, model.penalty, free), self._among)


def _one_of_each(jacobian: sparse.csr_array, modes: int) -> Index:
    """Return a row for each pair of bodies that has one."""
    filled = np.flatnonzero(np.diff(jacobian.indptr))
    body, first = jacobian.indices // modes, jacobian.indptr[filled]
    one, other = np.minimum.reduceat(body, first), np.maximum.reduceat(body, first)
    bodies = jacobian.shape[1] // modes
    return filled[np.unique(one * np.int64(bodies) + other, return_index=True)[1]]
