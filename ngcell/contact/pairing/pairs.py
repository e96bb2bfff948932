"""Points of walls and their closest points on other bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ContactPairs:
    """Points of walls and their closest points on other bodies; all arrays have one entry a contact pair.

    Attributes
    ----------
    point : array of int
        Number of the primary point among those that were asked for.
    primary : array of int
        Facet that the point lies on.
    primary_xi : array of float
        Coordinates of the point on it: one on edges, two on faces.
    weight : array of float
        Quadrature weight of the point [length], on faces [length**2].
    secondary : array of int
        Facet that the closest point lies on.
    secondary_xi : array of float
        Coordinates of the closest point on it.
    at_end : array of bool
        Whether the closest point lies on the rim of the secondary facet and is no foot of a normal.
    sign : array of float
        +1 outside the secondary body, -1 inside.
    slide_direction : array of float, shape (n, 2), of edges (n, 0)
        Coordinate direction of the side of a face along which the closest point may slide; 0 at corners and at feet.
    """

    point: Index
    primary: Index
    primary_xi: Array
    weight: Array
    secondary: Index
    secondary_xi: Array
    at_end: NDArray[np.bool_]
    sign: Array
    slide_direction: Array

    def __len__(self) -> int:
        return len(self.primary)

    def chosen(self, which: NDArray[np.int64] | NDArray[np.bool_]) -> ContactPairs:
        """Return some of the pairs, by their numbers or by a mask."""
        return ContactPairs(*(array[which] for array in vars(self).values()))


def joined(parts: Sequence[ContactPairs]) -> ContactPairs:
    """Return the pairs of several sets, one after the other."""
    arrays = zip(*(vars(each).values() for each in parts), strict=True)
    return ContactPairs(*(np.concatenate(alike) for alike in arrays))


def feet(primary: Index, primary_xi: Array, weight: Array, secondary: Index, secondary_xi: Array) -> ContactPairs:
    """Return pairs whose closest points are feet of normals, outside of the secondary body, numbered in order."""
    count = len(primary)
    return ContactPairs(
        point=np.arange(count),
        primary=primary,
        primary_xi=primary_xi,
        weight=weight,
        secondary=secondary,
        secondary_xi=secondary_xi,
        at_end=np.zeros(count, dtype=bool),
        sign=np.ones(count),
        slide_direction=np.zeros((count, 2 * (secondary_xi.ndim - 1))),
    )
