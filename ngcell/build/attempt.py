"""Ways from one mesh to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ngcell.contact.methods.terms import ContactTerm
from ngcell.problem.problem import Problem
from ngcell.solve.minimise import Minimiser

Minimisers = Sequence[Minimiser]


@dataclass(frozen=True, eq=False)
class Attempt:
    """A way from one mesh to the next.

    Attributes
    ----------
    softer : sequence of Minimiser
        Those that come first, of walls of smaller bulk moduli.
    minimisers : sequence of Minimiser
        Those that a step goes through; the last is of the problem that is meant.
    is_as_stiff : bool
        Whether contact begins as stiff as it has become on the mesh before.
    """

    softer: Minimisers
    minimisers: Minimisers
    is_as_stiff: bool = False


def recall_stiffness(mine: Problem, coarse: Problem) -> None:
    """Let contact begin as stiff as it has become on a coarser mesh."""
    for term, before in zip(mine.terms, coarse.terms, strict=True):
        if isinstance(term, ContactTerm) and isinstance(before, ContactTerm):
            term.recall(before.memory())
