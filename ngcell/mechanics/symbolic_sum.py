"""Symbolic terms that have one form, so that they are assembled at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.symbolic import Integrals, Rule, SymbolicTerm
from ngcell.mechanics.term import Configuration, Term

Array = NDArray[np.float64]


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
