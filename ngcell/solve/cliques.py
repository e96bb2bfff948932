"""Unknowns of a matrix that can be eliminated without fill, found from its pattern.

Unknowns whose neighbours are all coupled with each other, as those within one finite element, leave no new entries
when they are eliminated (simplicial vertices; Rose, Tarjan and Lueker, SIAM J. Comput. 5, 1976, doi:10.1137/0205021).
Those with the same neighbours form a clique that is eliminated at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


#: Rows that are summed up at once: few enough that what is needed on the way takes no memory to speak of.
_AT_ONCE = 2**14


@dataclass(frozen=True, eq=False)
class Cliques:
    """Cliques of the same sizes.

    Attributes
    ----------
    inside : array of int, shape (cliques, m)
        Unknowns that are eliminated.
    around : array of int, shape (cliques, q)
        Their neighbours, increasing.
    among, between : array of int, shapes (cliques, m, m) and (cliques, m, q)
        Positions of the entries of unknowns inside with each other, and with their neighbours, in the array of values.
    """

    inside: Index
    around: Index
    among: Index
    between: Index


def find_cliques(lower: sparse.csr_array, chosen: Mask) -> list[Cliques]:
    """Return the cliques of a symmetric matrix that can be eliminated without fill, by their sizes.

    Parameters
    ----------
    lower : csr_array, shape (size, size)
        Lower triangle of the pattern; its data are positions in the array of values.
    chosen : array of bool, shape (size,)
        Unknowns that may be eliminated.
    """
    pattern = _both_triangles(lower)
    group, first = _same_neighbours(pattern)
    fitting = _simplicial(pattern[first][:, first], np.bincount(group, chosen, len(first)) > 0)
    found, degree = [], np.diff(pattern.indptr)[first[fitting]]
    for size in np.unique(degree):
        of_size = fitting[degree == size]
        members, _ = _rows(pattern, first[of_size], int(size))
        inside = (group[members] == of_size[:, None]) & chosen[members]
        for count in np.unique(inside.sum(1)):
            same = inside.sum(1) == count
            found.append(_cliques(pattern, members[same], inside[same], int(count)))
    return found


def _cliques(pattern: sparse.csr_array, members: Index, inside: Mask, count: int) -> Cliques:
    number, size = members.shape
    mine = members[inside].reshape(number, count)
    position = _rows(pattern, mine.ravel(), size)[1].reshape(number, count, size)
    chosen = np.broadcast_to(inside[:, None], position.shape)
    return Cliques(
        inside=narrowed(mine),
        around=narrowed(members[~inside].reshape(number, size - count)),
        among=narrowed(position[chosen].reshape(number, count, count)),
        between=narrowed(position[~chosen].reshape(number, count, size - count)),
    )


def narrowed(index: Index) -> NDArray[Any]:
    """Return an index in 32 bits, if it has room there: half of the memory of a wider one."""
    return index.astype(np.int32) if index.max(initial=0) <= np.iinfo(np.int32).max else index.astype(np.int64)


def _both_triangles(lower: sparse.csr_array) -> sparse.csr_array:
    """Return the whole pattern; its data are positions, too. In each row the upper triangle follows the lower one."""
    size, upper = lower.shape[0], lower.T.tocsr()
    above = upper.indices != np.repeat(np.arange(size, dtype=np.int32), np.diff(upper.indptr))
    counts = np.diff(lower.indptr), np.diff(np.concatenate([[0], np.cumsum(above)])[upper.indptr])
    is_above = np.repeat(np.tile([False, True], size), np.column_stack(counts).ravel())
    indices, data = np.empty(len(is_above), dtype=np.int32), np.empty(len(is_above), dtype=np.int32)
    indices[~is_above], data[~is_above] = lower.indices, lower.data
    indices[is_above], data[is_above] = upper.indices[above], upper.data[above]
    pointer = np.concatenate([[0], np.cumsum(counts[0] + counts[1])])
    return sparse.csr_array((data, indices, pointer), shape=lower.shape)


def _same_neighbours(pattern: sparse.csr_array) -> tuple[Index, Index]:
    """Return the group of each unknown, the same for those with the same neighbours, and the first one of each."""
    size = pattern.shape[0]
    label = np.random.default_rng(0).integers(2**64, size=size, dtype=np.uint64)
    total = np.zeros(size, dtype=np.uint64)
    for row in range(0, size, _AT_ONCE):
        start = pattern.indptr[row : row + _AT_ONCE + 1]
        summed = np.cumsum(label[pattern.indices[start[0] : start[-1]]])
        total[row : row + _AT_ONCE] = np.diff(np.append(np.uint64(0), summed)[start - start[0]])
    _, first, group = np.unique(total, return_index=True, return_inverse=True)
    return group.astype(np.int64), first.astype(np.int64)


def _simplicial(pattern: sparse.csr_array, chosen: Mask) -> Index:
    """Return the chosen unknowns whose neighbours are all coupled with each other."""
    candidate = np.flatnonzero(chosen)
    ones = sparse.csr_array((np.ones(pattern.nnz), pattern.indices, pattern.indptr), shape=pattern.shape)
    mine = ones[candidate]
    common = (mine @ ones).multiply(mine).sum(axis=1)
    return np.asarray(candidate[common == np.diff(mine.indptr).astype(float) ** 2])


def _rows(pattern: sparse.csr_array, rows: Index, size: int) -> tuple[Index, Index]:
    """Return columns and positions of rows with so many entries, shape (rows, size)."""
    place = pattern.indptr[rows].astype(np.int64)[:, None] + np.arange(size)
    return pattern.indices[place].astype(np.int64), pattern.data[place]
