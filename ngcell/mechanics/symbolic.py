"""Energies that NGSolve can express: terms that are given as integrals, and the one form that all of them share.

Assembling one form of many integrals costs a single loop over the elements; so the sum of terms puts all symbolic ones
together. Each can also be evaluated by itself, with a form of its own.

Which sums may use threads
--------------------------
A nearly symmetric tissue chooses between equilibria by the last digits of sums, so a number of threads must not change
these. Compared bit by bit on 2592 and on 12 753 unknowns, one thread against two, over repeats: NGSolve's gradient
(`Apply`) and tangent (`AssembleLinearization`) never differ, since elements of one colour share no unknown and colours
follow each other in the same order. The energy (`Energy`, one sum that threads share) differs by 7e-18 of 0.047, the
Cholesky factor and its solutions (updates in the order in which threads finish) by 1e-18 to 2e-17 of 1e-3. So threads
are used here, for gradient and tangent, and nowhere else: a run has the same bits with any number of them.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import ngsolve
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.mechanics.last_found import LastFound
from ngcell.mechanics.space import DisplacementSpace, csr_matrix
from ngcell.mechanics.term import Configuration, Index, Term

Array = NDArray[np.float64]
Integrals = Iterable[ngsolve.comp.SumOfIntegrals]
Rule = tuple[int, ...]


class _Threads:
    """How many threads assemble."""

    count = 1


@contextmanager
def assembly_threads(count: int) -> Iterator[None]:
    """Let gradients and tangents be assembled by so many threads, which changes no digit of them."""
    ngsolve.SetNumThreads(1)
    before, _Threads.count = _Threads.count, count
    try:
        yield
    finally:
        _Threads.count = before


@contextmanager
def _in_parallel() -> Iterator[None]:
    """Let NGSolve use all threads; outside it has one, since its Cholesky factor starts threads by itself."""
    if _Threads.count == 1:
        yield
        return
    ngsolve.SetNumThreads(_Threads.count)
    try:
        with ngsolve.TaskManager():
            yield
    finally:
        ngsolve.SetNumThreads(1)


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
        with _in_parallel():
            self._form.Apply(self._at(displacement), self._force)
        return np.array(self._force.FV().NumPy())

    def tangent(self, displacement: Array) -> sparse.csr_array:
        """Return its second derivative, shape (unknowns, unknowns)."""
        return csr_matrix(self._assembled(displacement))

    @cached_property
    def pattern(self) -> tuple[Index, Index]:
        """Rows and columns of the lower triangle of the tangent."""
        matrix = csr_matrix(self._form.mat if self._is_assembled else self._assembled(np.zeros(self._unknowns)))
        row = np.repeat(np.arange(matrix.shape[0], dtype=np.int32), np.diff(matrix.indptr))
        column = matrix.indices.astype(np.int32)
        self._lower = row >= column
        return row[self._lower], column[self._lower]

    def lower_tangent(self, displacement: Array) -> Array:
        """Return the second derivative on `pattern`."""
        matrix = self._assembled(displacement)
        _ = self.pattern
        values: Array = np.asarray(matrix.CSR()[0])[self._lower]
        return values

    def _assembled(self, displacement: Array) -> ngsolve.la.BaseMatrix:
        with _in_parallel():
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

    @property
    def finer_degrees(self) -> int:
        """Degrees that the rule by which the present one is judged integrates exactly besides the usual ones."""
        return max(1, *self.rule) * more_degrees(self.space)

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


class SymbolicSum(SymbolicTerm):
    """Symbolic terms with one form.

    Parameters
    ----------
    parts : sequence of SymbolicTerm
        The terms, at least one.
    """

    def __init__(self, parts: Sequence[SymbolicTerm]) -> None:
        self.parts = tuple(parts)
        self.space, self.remembers = parts[0].space, all(part.remembers for part in parts)

    def integrals(self, displacement: ngsolve.CoefficientFunction) -> Integrals:
        """Return the integrals of all parts."""
        return [integral for part in self.parts for integral in part.integrals(displacement)]

    @property
    def rule(self) -> Rule:
        """The rules of all parts."""
        return tuple(extra for part in self.parts for extra in part.rule)

    def beyond_integrals(self, displacement: Array) -> Array | None:
        """Return what the gradients of the parts have besides."""
        found = [part.beyond_integrals(displacement) for part in self.parts]
        given = [force for force in found if force is not None]
        return sum(given[1:], start=given[0]) if given else None

    def unstored(self, at: Configuration) -> float:
        """Return what is not stored in bodies."""
        return sum(part.unstored(at) for part in self.parts)


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


def parts_of(terms: Sequence[Any]) -> tuple[Any, ...]:
    """Return terms with those that are one put apart again."""
    return tuple(part for term in terms for part in (term.parts if isinstance(term, SymbolicSum) else (term,)))


def fused(terms: Sequence[Term]) -> tuple[Term, ...]:
    """Return terms with the same sum, in which all symbolic ones are one term, the first; it is left as it is if it is.
    """
    symbolic = [term for term in terms if isinstance(term, SymbolicTerm)]
    others = tuple(term for term in terms if not isinstance(term, SymbolicTerm))
    if len(symbolic) == 1 and isinstance(symbolic[0], SymbolicSum):
        return (symbolic[0], *others)
    return (SymbolicSum(parts_of(symbolic)), *others) if symbolic else others
