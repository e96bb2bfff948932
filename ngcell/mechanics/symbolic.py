"""Energies that NGSolve can express: terms that are given as integrals, and the one form that all of them share.

Assembling one form of many integrals costs a single loop over the elements; so the sum of terms puts all symbolic ones
together. Each can also be evaluated by itself, with a form of its own.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any

import ngsolve
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.mechanics.last_found import LastFound
from ngcell.mechanics.space import DisplacementSpace, csr_matrix
from ngcell.mechanics.term import Configuration, Index, Term
from ngcell.threads import in_parallel

Array = NDArray[np.float64]
Integrals = Iterable[ngsolve.comp.SumOfIntegrals]
Rule = tuple[int, ...]


class EnergyForm:
    """An energy given as integrals, its gradient and its tangent.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    integrals : callable
        Returns the integrals of a displacement, an NGSolve function.
    remembers : bool
        Whether nothing but the displacement changes them, so that the last energy and gradient may be told again.
    """

    def __init__(
        self,
        space: DisplacementSpace,
        integrals: Callable[[ngsolve.CoefficientFunction], Integrals],
        *,
        remembers: bool = False,
    ) -> None:
        self._unknowns = space.unknowns
        self._form = ngsolve.BilinearForm(space.vector, symmetric=True)
        for integral in integrals(space.vector.TrialFunction()):
            self._form += ngsolve.Variation(integral)
        self._state = ngsolve.GridFunction(space.vector).vec
        self._force = self._state.CreateVector()
        self._is_assembled = False
        self._energy, self._gradient = LastFound[float](remembers), LastFound[Array](remembers)

    def energy(self, displacement: Array) -> float:
        """Return the energy; NaN where an element is inverted."""
        return self._energy.of(displacement, lambda: float(self._form.Energy(self._at(displacement))))

    def gradient(self, displacement: Array) -> Array:
        """Return its gradient, shape (unknowns,)."""
        return self._gradient.of(displacement, lambda: self._applied(displacement)).copy()

    def _applied(self, displacement: Array) -> Array:
        with in_parallel(self._unknowns):
            self._form.Apply(self._at(displacement), self._force)
        return np.array(self._force.FV().NumPy())

    def tangent(self, displacement: Array) -> sparse.csr_array:
        """Return its second derivative, shape (unknowns, unknowns)."""
        return csr_matrix(self._assembled(displacement))

    @property
    def pattern(self) -> tuple[Index, Index]:
        """Rows and columns of the lower triangle of the tangent."""
        row, column = self._entries()
        return row[self._lower], column[self._lower]

    def _entries(self) -> tuple[Index, Index]:
        matrix = self._form.mat if self._is_assembled else self._assembled(np.zeros(self._unknowns))
        _, column, pointer = (np.asarray(part) for part in matrix.CSR())
        row = np.repeat(np.arange(matrix.height, dtype=np.int32), np.diff(pointer.astype(np.int64)).astype(np.int64))
        return row, column.astype(np.int32)

    @cached_property
    def _lower(self) -> NDArray[np.bool_]:
        row, column = self._entries()
        return row >= column

    def lower_tangent(self, displacement: Array) -> Array:
        """Return the second derivative on `pattern`."""
        values: Array = np.asarray(self._assembled(displacement).CSR()[0])[self._lower]
        return values

    def _assembled(self, displacement: Array) -> ngsolve.la.BaseMatrix:
        with in_parallel(self._unknowns):
            self._form.AssembleLinearization(self._at(displacement))
        self._is_assembled = True
        return self._form.mat

    def _at(self, displacement: Array) -> ngsolve.BaseVector:
        self._state.FV().NumPy()[:] = displacement
        return self._state


class SymbolicTerm(Term):
    """A term given as integrals; a user's own energy defines `space` and `integrals`, and nothing else.

    Attributes
    ----------
    space : DisplacementSpace
        The unknowns.
    remembers : bool
        Whether nothing but the displacement changes the integrals: no parameter, no load factor.
    """

    space: DisplacementSpace
    remembers: bool = False
    _formed: tuple[Rule, EnergyForm] | None = None
    _finer: tuple[Rule, SymbolicTerm | None] | None = None

    @abstractmethod
    def integrals(self, displacement: ngsolve.CoefficientFunction) -> Integrals:
        """Return the energy of a displacement, an NGSolve function, as integrals over regions of the mesh."""

    def beyond_integrals(self, displacement: Array) -> Array | None:
        """Return what the gradient has besides the derivative of the integrals, shape (unknowns,); as a rule nothing.
        """
        return None

    def finer(self, extra_degrees: int) -> SymbolicTerm | None:
        """Return the term integrated by a rule of higher order; None where its own rule is not to be judged."""
        return None

    @property
    def rule(self) -> Rule:
        """How many times the rule of each part has been made finer."""
        return (0,)

    def take_finer_rule(self, at: Configuration) -> bool:
        """Integrate by a finer rule from now on if that of this equilibrium misses too much; tell whether it does."""
        return False

    @property
    def form(self) -> EnergyForm:
        """The term by itself, by its present rule."""
        if self._formed is None or self._formed[0] != self.rule:
            self._formed = (self.rule, EnergyForm(self.space, self.integrals, remembers=self.remembers))
        return self._formed[1]

    def release(self) -> None:
        """Give the memory of the form back."""
        self._formed = None

    @property
    def finer_degrees(self) -> int:
        """Degrees that the rule by which the present one is judged integrates exactly besides the usual ones."""
        return (1 + max(self.rule)) * more_degrees(self.space)

    @property
    def finer_form(self) -> EnergyForm | None:
        """The term by itself, by a rule that integrates polynomials of twice the usual degree exactly, or more."""
        if self._finer is None or self._finer[0] != self.rule:
            self._finer = (self.rule, self.finer(self.finer_degrees))
        term = self._finer[1]
        return None if term is None else term.form

    def value(self, at: Configuration) -> float:
        """Return the energy; NaN where an element is inverted."""
        return self.form.energy(at.displacement)

    def gradient(self, at: Configuration) -> Array:
        """Return its gradient, shape (unknowns,)."""
        gradient, beyond = self.form.gradient(at.displacement), self.beyond_integrals(at.displacement)
        return gradient if beyond is None else gradient + beyond

    @property
    def pattern(self) -> tuple[Index, Index]:
        """Rows and columns of the lower triangle that `tangent` fills."""
        return self.form.pattern

    def tangent(self, at: Configuration) -> Array:
        """Return the second derivative on `pattern`."""
        return self.form.lower_tangent(at.displacement)


class OwnEnergy(SymbolicTerm):
    """An energy that a script adds: integrals of the displacement, as NGSolve expressions.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    integrals : callable
        Returns one integral, or several, of the displacement and the mesh: `lambda u, mesh: k/2 * u[0]**2 *
        ngsolve.ds(...)`.

    Notes
    -----
    What it stores counts as stored energy, and its forces as internal.
    """

    def __init__(self, space: DisplacementSpace, integrals: Callable[[Any, ngsolve.Mesh], Any]) -> None:
        self.space, self._integrals = space, integrals

    def integrals(self, displacement: ngsolve.CoefficientFunction) -> Integrals:
        """Return the integrals that the script gives."""
        given = self._integrals(displacement, self.space.mesh)
        return given if isinstance(given, (list, tuple)) else [given]


def more_degrees(space: DisplacementSpace) -> int:
    """Return by how many degrees a finer rule is exact beyond the usual one."""
    return 2 * space.order + 2
