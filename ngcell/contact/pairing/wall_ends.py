"""Where segments end beside the end of a wall: so that weighted gaps have no kink where the ends of two walls meet.

A segment of a wall with multipliers ends where the other wall does, or where its own does. Where both meet, as where
three cells do, the rate at which a weighted gap changes as walls slide would jump, by the gap at that end: walls come
to rest there, on a kink of the energy. So a segment's end is not the projection t of the other wall's end but c(t),
which comes to rest at a sharp end of its own edge: c has slope 0 there, all of it within a share `ROUNDED` of the edge
from there, and the same slope everywhere else. An edge that is covered is covered in whole, and neighbours on the other
wall share their end. By how much c differs from t, half of that share, is nothing beside what walls are known to.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of an edge within which an end comes to rest.
ROUNDED = 1e-4


@dataclass(frozen=True, eq=False)
class WallEnds:
    """Edges at the end of whose walls segments come to rest.

    Attributes
    ----------
    sharp : array of bool, shape (edges, 2)
        Whether a wall ends at the start, and at the end, of each edge.
    """

    sharp: NDArray[np.bool_]

    def places(self, edge: Index, projected: Array) -> Array:
        """Return c(t) of projections in [0, 1]; both arrays have the same shape."""
        at_start, at_end = self.sharp[edge, 0], self.sharp[edge, 1]
        left = 1 - projected
        along = projected - ROUNDED / 2 * at_start
        along = np.where(at_start & (projected < ROUNDED), projected**2 / (2 * ROUNDED), along)
        back = left**2 / (2 * ROUNDED)
        slope = self._slope(edge)
        return np.asarray(np.where(at_end & (left < ROUNDED), 1 - slope * back, slope * along))

    def projected(self, edge: Index, place: Array) -> Array:
        """Return the projections t that lead to places c(t)."""
        at_start, slope = self.sharp[edge, 0], self._slope(edge)
        found = place / slope + ROUNDED / 2 * at_start
        for end in (0, 1):
            ahead = self._ahead(edge, place, end)
            found = np.where(ahead < ROUNDED, np.abs(end - ahead), found)
        return np.asarray(found)

    def rates(self, edge: Index, place: Array) -> tuple[Array, Array]:
        """Return c'(t), and c''(t) over it, where c is `place`."""
        rate, bend = np.ones(place.shape), np.zeros(place.shape)
        for end in (0, 1):
            ahead = self._ahead(edge, place, end)
            rate = np.where(ahead < ROUNDED, ahead / ROUNDED, rate)
            bend = np.where(ahead < ROUNDED, (1 - 2 * end) / np.maximum(ahead, np.finfo(float).tiny), bend)
        return self._slope(edge) * rate, bend

    def _ahead(self, edge: Index, place: Array, end: int) -> Array:
        """Return how far t is from a sharp end where it is within the share, and more elsewhere."""
        ahead = np.sqrt(2 * ROUNDED * np.abs(place - end) / self._slope(edge))
        return np.asarray(np.where(self.sharp[edge, end], ahead, np.inf))

    def _slope(self, edge: Index) -> Array:
        return np.asarray(1 / (1 - ROUNDED / 2 * self.sharp[edge].sum(-1)))
