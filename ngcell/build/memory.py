"""What memory a run will take, foreseen from the entries of its matrix.

The matrix of the direct solver has room for all walls that may come to touch, and its entries decide: its pattern is
made from coordinates, and the factor of it has about twice as many. Measured on three tissues of 7 200, 16 200 and
63 000 unknowns (order 2, in three dimensions, 0.6, 1.5 and 6.1 million entries), the most that a run took is a straight
line in them, to 3 %. The iterative solver needs no such room: its entries are those within bodies. Measured on 63 000
unknowns (4.4 million entries): once walls were closed a run with a tied solid had taken 2.2 GiB, and one without 1.5;
214 200 unknowns (16.8 million entries) took 5.7 GiB without one.
"""

from __future__ import annotations

import numpy as np

from ngcell.problem.problem import Problem
from ngcell.solve.minimise import Minimiser

#: Memory for each entry [byte], of the direct and of the iterative solver, and of a run of hardly any [GiB].
_FOR_AN_ENTRY = {"direct": 420, "iterative": 480}
_AT_LEAST = 0.25


def solver_name(minimiser: Minimiser) -> str:
    """Return "direct" or "iterative", whichever solves for the bodies."""
    return "iterative" if minimiser.is_iterative else "direct"


def entry_count(problem: Problem, minimiser: Minimiser) -> int:
    """Return the number of entries of the matrix that a release starts with, lower triangle only.

    Parameters
    ----------
    problem : Problem
        The released bodies.
    minimiser : Minimiser
        Their minimiser.
    """
    parts = [problem.pattern]
    if not minimiser.is_iterative:
        rest = problem.at(np.zeros(problem.space.unknowns))
        parts.append(problem.couplings(rest, minimiser.options.wide_margin * minimiser.longest_step))
    # Sorted: numpy's `unique` hashes whole numbers, which takes ten times as long where they are many.
    keys = np.sort(np.concatenate([row * problem.space.unknowns + column for row, column in parts]))
    return int(np.count_nonzero(np.diff(keys))) + bool(len(keys))


def foreseen_memory(entries: float, solver: str = "direct") -> float:
    """Return the most memory that a run with a matrix of so many entries takes with this solver [GiB]."""
    return _AT_LEAST + _FOR_AN_ENTRY[solver] * entries / 2**30
