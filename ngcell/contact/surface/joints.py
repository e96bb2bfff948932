"""Where facets in three dimensions meet: the sides that two of a body share. Side k starts at corner k of a facet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Joints:
    """Shared sides; all arrays have shape (joints, 2), one column a facet.

    Attributes
    ----------
    facet, side : array of int
        The two facets, and which side of each.
    """

    facet: Index
    side: Index


def find_joints(vertices: Index) -> Joints:
    """Return all sides that two facets share, from the vertices at their corners, shape (facets, corners)."""
    ends = np.sort(np.stack([vertices, np.roll(vertices, -1, axis=1)], axis=-1), axis=-1).reshape(-1, 2)
    order = np.lexsort(ends.T)
    same = np.flatnonzero((np.diff(ends[order], axis=0) == 0).all(1))
    facet, side = np.divmod(np.stack([order[same], order[same + 1]], axis=1), vertices.shape[1])
    return Joints(facet, side)
