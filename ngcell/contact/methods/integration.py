"""Points at which weighted gaps are integrated over the walls that have multipliers.

In the plane segments are found anew in each state, and their ends move with it. In three dimensions polygons are found where
multipliers are updated, and their points stay on their wall until then; their contact pairs are found anew in each state. So
there is one energy for each set of multipliers, nothing of it depends on how polygons move, and at the end, where nothing
moves any more, the rule is that of the polygons of the equilibrium.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.search import ContactPairs, NearEdges, PairSearch
from ngcell.contact.pairing.segments import find_segments, segment_pairs
from ngcell.contact.surface.walls import WallPoints, Walls

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Integration(Protocol):
    """A rule along the walls."""

    def points(self, nodes: Array) -> tuple[ContactPairs, ContactPairs | None]:
        """Return the points with their contact pairs, and the cuts that end segments where these move."""

    def renew(self, nodes: Array) -> bool:
        """Adapt the rule to deformed nodes, and tell whether it had to be."""


class SegmentIntegration:
    """The rule in the plane.

    Parameters
    ----------
    walls : Walls
        The walls.
    reach : float
        Distance up to which walls are paired [length].
    rank : array of int, shape (bodies,)
        Of a pair, the body with the lower rank has the multipliers.
    """

    def __init__(self, walls: Walls, reach: float, rank: Index) -> None:
        self._walls, self._reach, self._rank = walls, reach, rank
        self._near = NearEdges(walls, reach)

    def points(self, nodes: Array) -> tuple[ContactPairs, ContactPairs | None]:
        """Return the points of the segments of this state, and their ends."""
        edge, other = _lifting(self._walls, self._rank, *self._near.pairs(nodes))
        segments = find_segments(self._walls, nodes, edge, other)
        return segment_pairs(self._walls, nodes, segments, self._reach)

    def renew(self, nodes: Array) -> bool:
        """Do nothing: segments are always those of the state."""
        return False


class IntersectionIntegration:
    """The rule in three dimensions; parameters as in the plane."""

    def __init__(self, walls: Walls, reach: float, rank: Index) -> None:
        self._walls, self._reach, self._rank = walls, reach, rank
        self._near = NearEdges(walls, reach)
        self._search: PairSearch | None = None
        self._faced = np.zeros(0, dtype=np.int64)

    def points(self, nodes: Array) -> tuple[ContactPairs, ContactPairs | None]:
        """Return the points of the polygons last found, each with its closest point on the body that it faced there."""
        if self._search is None:
            self.renew(nodes)
        assert self._search is not None
        found = self._search.pairs(nodes)
        kept = np.flatnonzero(self._walls.body[found.other] == self._faced[found.point])
        return ContactPairs(**{name: array[kept] for name, array in vars(found).items()}), None

    def renew(self, nodes: Array) -> bool:
        """Find the polygons at deformed nodes."""
        from ngcell.contact.pairing.intersections import find_intersections, intersection_pairs

        edge, other = _lifting(self._walls, self._rank, *self._near.pairs(nodes))
        found = intersection_pairs(self._walls, nodes, find_intersections(self._walls, nodes, edge, other), self._reach)
        self._search = PairSearch(self._walls, WallPoints(found.edge, found.here, found.weight), self._reach)
        self._faced = self._walls.body[found.other]
        return True


def integration(walls: Walls, reach: float, rank: Index) -> Integration:
    """Return the rule for walls of this dimension."""
    return (SegmentIntegration if walls.dimension == 2 else IntersectionIntegration)(walls, reach, rank)


def _lifting(walls: Walls, rank: Index, edge: Index, other: Index) -> tuple[Index, Index]:
    has_multiplier = rank[walls.body[edge]] < rank[walls.body[other]]
    return edge[has_multiplier], other[has_multiplier]
