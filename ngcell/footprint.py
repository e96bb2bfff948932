"""What memory a run will take, foreseen from the entries of its matrix.

The matrix has room for all walls that may come to touch, and its entries decide: its pattern is made from coordinates,
and the factor of it has about twice as many. Measured on three tissues of 7 200, 16 200 and 63 000 unknowns (order 2,
in space, 0.6, 1.5 and 6.1 million entries), the most that a run took is a straight line in them, to 3 %.
"""

from __future__ import annotations

import numpy as np

from ngcell.contact.assembly import Assembly
from ngcell.solve.minimise import WIDE_MARGIN

#: Memory for each entry [byte], and of a run of hardly any [GiB].
_FOR_AN_ENTRY, _AT_LEAST = 420, 0.25


def entry_count(assembly: Assembly, longest_step: float) -> int:
    """Return the number of entries of the matrix that a release starts with, lower triangle only.

    Parameters
    ----------
    assembly : Assembly
        The released bodies.
    longest_step : float
        Longest step of the minimiser [length].
    """
    rest = assembly.at(np.zeros(assembly.space.unknowns))
    parts = assembly.pattern, assembly.couplings(rest, WIDE_MARGIN * longest_step)
    return len(np.unique(np.concatenate([row * assembly.space.unknowns + column for row, column in parts])))


def foreseen_memory(entries: int) -> float:
    """Return the most memory that a run with a matrix of so many entries takes [GiB]."""
    return _AT_LEAST + _FOR_AN_ENTRY * entries / 2**30
