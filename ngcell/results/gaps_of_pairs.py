"""Gaps of walls pair by pair of bodies: what means over any of them are made of.

Means are over walls between held bodies. Which bodies nothing holds may differ from mesh to mesh; by how much a mean
has changed is asked of the same walls on both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.facing import FacingWalls

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class GapsOfPairs:
    """Gaps of the facing walls of each pair of bodies.

    Attributes
    ----------
    bodies : array of int, shape (pairs, 2)
        The two bodies.
    is_held : array of bool, shape (pairs,)
        Whether something holds both.
    length : array of float, shape (pairs,)
        Length of the walls [length**(dimension - 1)].
    integral : array of float, shape (pairs,)
        Integral of the gap over it [length**dimension].
    largest : array of float, shape (pairs,)
        Largest gap [length].
    facet : array of int, shape (n, 2)
        Pair and facet of the walls' parts.
    of_facet : array of float, shape (n,)
        Integral of the gap over each of these [length**dimension].
    """

    bodies: Index
    is_held: NDArray[np.bool_]
    length: Array
    integral: Array
    largest: Array
    facet: Index
    of_facet: Array

    def mean_and_largest(self, chosen: NDArray[np.bool_]) -> tuple[float, float]:
        """Return mean and largest gap of chosen pairs [length]; 0 where there are none, or all overlap."""
        length = float(self.length[chosen].sum())
        mean = float(self.integral[chosen].sum()) / length if length else 0.0
        return mean, float(self.largest[chosen].max(initial=0.0))

    def moved_from(self, before: GapsOfPairs) -> float:
        """Return the mean over held pairs of what their gaps have changed by [length], facet by facet, or as a whole
        where other facets face each other; 0 where pairs differ."""
        length = float(self.length[self.is_held].sum())
        if not length or not np.array_equal(self.bodies, before.bodies):
            return 0.0
        if np.array_equal(self.facet, before.facet):
            changed, is_held = self.of_facet - before.of_facet, self.is_held[self.facet[:, 0]]
        else:
            changed, is_held = self.integral - before.integral, self.is_held
        return float(np.abs(changed)[is_held].sum()) / length

    def over_those_of(self, other: GapsOfPairs) -> tuple[float, float] | None:
        """Return mean and largest gap of the pairs that are held in another state; None if pairs differ."""
        return self.mean_and_largest(other.is_held) if np.array_equal(self.bodies, other.bodies) else None


def gaps_of_pairs(facing: FacingWalls, gap: Array, free_bodies: tuple[int, ...]) -> GapsOfPairs:
    """Return gaps pair by pair from those of all facing points [length], shape (points,)."""
    count = len(facing.pairs)
    largest = np.full(count, -np.inf)
    np.maximum.at(largest, facing.pair, gap)
    each = np.column_stack([facing.pair, facing.facet])
    facet, place = np.unique(each, axis=0, return_inverse=True)
    return GapsOfPairs(
        bodies=facing.pairs,
        is_held=np.asarray(~np.isin(facing.pairs, np.asarray(free_bodies)).any(axis=1)),
        length=np.bincount(facing.pair, facing.weight, count).astype(float),
        integral=np.bincount(facing.pair, facing.weight * gap, count).astype(float),
        largest=largest,
        facet=facet,
        of_facet=np.bincount(place.ravel(), facing.weight * gap, len(facet)).astype(float),
    )
