"""Points near each other, and what is connected, in plain numpy.

scipy's k-d tree and graph routines would do, but loading them takes longer than all searches of a small scene.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Most boxes along an axis, by dimension, so that the number of a box is exact.
_MOST_BOXES = {2: 2**30, 3: 2**20}


def near_pairs(points: Array, reach: float) -> tuple[Index, Index]:
    """Return all pairs of points at most `reach` [length] apart, each once, the lower number first, sorted.

    The points are sorted into boxes of side `reach`, row by row. The second point of a pair is in the same row of boxes
    as the first, in its box or the next one, or in a row beside (in the plane the one above, in three dimensions one of
    four), in one of three boxes: all are ranges of the sorted points.

    Parameters
    ----------
    points : array of float, shape (points, dimension)
        The points [length].
    reach : float
        Largest distance of a pair [length], > 0.
    """
    if len(points) < 2:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    low, high = points.min(0), points.max(0)
    side = max(reach, float((high - low).max() / _MOST_BOXES[points.shape[1]]))
    boxes = np.floor((points - low) / side).astype(np.int64) + 1
    widths = boxes.max(0) + 2  # an empty box on either side keeps rows apart
    strides = np.cumprod([1, *widths[:-1]])
    box = boxes @ strides
    rows = (int(np.dot(step, strides[1:])) for step in product((-1, 0, 1), repeat=len(strides) - 1))
    order = np.argsort(box, kind="stable")
    box = box[order]
    place = np.arange(len(box))
    found = [ranges(place, place + 1, np.searchsorted(box, box + 1, "right"))]
    found += [
        ranges(
            place,
            np.searchsorted(box, box + translation - 1, "left"),
            np.searchsorted(box, box + translation + 1, "right"),
        )
        for translation in rows
        if translation > 0
    ]
    one, two = (order[np.concatenate(parts)] for parts in zip(*found, strict=True))
    near = ((points[one] - points[two]) ** 2).sum(1) <= reach * reach
    lower, upper = np.minimum(one, two)[near], np.maximum(one, two)[near]
    sorting = np.lexsort((upper, lower))
    return lower[sorting], upper[sorting]


def components(count: int, one: Index, two: Index) -> Index:
    """Return the component of each of `count` nodes of a graph with edges from `one` to `two`, shape (count,).

    Components are numbered in the order of their first nodes. Roots are hooked to lower neighbouring roots, and chains
    of roots shortened, until every edge has one root.
    """
    root = np.arange(count)
    while (apart := root[one] != root[two]).any():
        here, there = root[one[apart]], root[two[apart]]
        np.minimum.at(root, np.maximum(here, there), np.minimum(here, there))
        while (shorter := root[root]).tobytes() != root.tobytes():
            root = shorter
    return np.asarray(np.unique(root, return_inverse=True)[1].ravel(), dtype=np.int64)


def ranges(of: Index, first: Index, end: Index) -> tuple[Index, Index]:
    """Return each number of `of` as often as its range is long, and beside it the numbers of the range."""
    length = np.maximum(end - first, 0)
    within = np.arange(length.sum()) - np.repeat(np.cumsum(length) - length, length)
    return np.repeat(of, length), np.repeat(first, length) + within
