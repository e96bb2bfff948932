"""What memory a run will take, foreseen from the entries of its matrix.

The entries of the matrix decide, those of closed walls left out: its factor has about four times as many. Measured on
63 000 unknowns (order 2, in three dimensions, 4.4 million entries), released from a tied solid: 2.6 GiB by the direct
solver, 2.2 by the iterative one, and 1.5 without a tied solid; 214 200 unknowns (16.8 million entries) took the
iterative one 5.7 GiB without one, by a version that took more than the present one. A planar entry takes less, as
factors of planar matrices grow more slowly: 35 cells of order 5 (8.4 million entries), with the four coarser meshes
that led there, took 1.8 GiB, and 1024 of order 4 (30 million) 7.7. Where cells are filled, their fillings widen the
factor: 100 of order 4 (8.5 million) took 3.2 GiB.
"""

from __future__ import annotations

import numpy as np

from ngcell.mechanics.inclusion import InclusionEnergy
from ngcell.problem.problem import Problem
from ngcell.solve.minimise import Minimiser

#: Memory for each entry [byte], of the direct solver in each dimension and of the iterative one, that of planar cells
#: that are filled, and of a run of hardly any [GiB].
_FOR_AN_ENTRY = {("direct", 2): 270, ("direct", 3): 573, ("iterative", 3): 480}
_OF_FILLED_CELLS = 370
_AT_LEAST = 0.25


def solver_name(minimiser: Minimiser) -> str:
    """Return "direct" or "iterative", whichever solves for the bodies."""
    return "iterative" if minimiser.is_iterative else "direct"


def entry_count(problem: Problem) -> int:
    """Return the number of entries of the matrix of released bodies without contact, lower triangle only."""
    # Sorted: numpy's `unique` hashes whole numbers, which takes ten times as long where they are many.
    row, column = problem.pattern
    keys = np.sort(row.astype(np.int64) * problem.space.unknowns + column)
    return int(np.count_nonzero(np.diff(keys))) + bool(len(keys))


def foreseen_memory(entries: float, dimension: int, solver: str = "direct", *, is_filled: bool = False) -> float:
    """Return the most memory that a run with a matrix of so many entries takes with this solver [GiB]."""
    each = _OF_FILLED_CELLS if is_filled and dimension == 2 else _FOR_AN_ENTRY[solver, dimension]
    return _AT_LEAST + each * entries / 2**30


def is_filled(problem: Problem) -> bool:
    """Return whether cells have solid fillings."""
    return any(isinstance(term, InclusionEnergy) for term in problem.terms)
