"""How wide bodies are for elimination: what tells whether a scene is cheaper to factorise in one piece."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.solve.problem import Problem

Index = NDArray[np.int64]


def width_of_bodies(problem: Problem) -> float:
    """Return the mean number of entries in a row of the factor of the body with the most unknowns.

    It is that of the profile in the order of Cuthill and McKee (doi:10.1145/800195.805928). For a ring it is about
    twice the number of unknowns in its cross-section, however long it is.
    """
    largest = int(np.bincount(problem.part[problem.free]).argmax())
    mine = (problem.part == largest) & problem.free
    row, column = problem.pattern
    within = mine[row] & mine[column]
    number = np.cumsum(mine) - 1
    return profile_width(number[row[within]], number[column[within]], int(mine.sum()))


def profile_width(row: Index, column: Index, size: int) -> float:
    """Return the mean width of the profile of a symmetric matrix, from the entries of one triangle."""
    from scipy.sparse.csgraph import reverse_cuthill_mckee  # few runs need it, and it loads much of scipy

    pattern = sparse.csr_array((np.ones(len(row), dtype=np.int8), (row, column)), shape=(size, size))
    place = np.empty(size, dtype=np.int64)
    place[reverse_cuthill_mckee(sparse.csr_array(pattern + pattern.T), symmetric_mode=True)] = np.arange(size)
    one, other = place[row], place[column]
    first = np.arange(size)
    np.minimum.at(first, np.maximum(one, other), np.minimum(one, other))
    return float((np.arange(size) - first).mean())
