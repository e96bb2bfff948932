"""Points at which weighted gaps are integrated over the walls that carry multipliers.

In the plane segments are found anew in each state, and their ends move with it. In space polygons are found where
multipliers are learned, and their points stay on their wall until then; their partners are found anew in each state. So
there is one energy for each set of multipliers, nothing of it hangs on how polygons move, and at the end, where nothing
moves any more, the rule is that of the polygons of the equilibrium.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.search import NearEdges, Partners, PartnerSearch
from ngcell.contact.segments import find_segments, segment_partners
from ngcell.contact.walls import WallPoints, Walls

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Integration(Protocol):
    """A rule along the walls."""

    def points(self, nodes: Array) -> tuple[Partners, Partners | None]:
        """Return the points with their partners, and the cuts that end segments where these move."""

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
        Of a pair, the body with the lower rank carries the multipliers.
    """

    def __init__(self, walls: Walls, reach: float, rank: Index) -> None:
        self._walls, self._reach, self._rank = walls, reach, rank
        self._near = NearEdges(walls, reach)

    def points(self, nodes: Array) -> tuple[Partners, Partners | None]:
        """Return the points of the segments of this state, and their ends."""
        edge, other = _carried(self._walls, self._rank, *self._near.pairs(nodes))
        segments = find_segments(self._walls, nodes, edge, other)
        return segment_partners(self._walls, nodes, segments, self._reach)

    def renew(self, nodes: Array) -> bool:
        """Do nothing: segments are always those of the state."""
        return False


class OverlayIntegration:
    """The rule in space; parameters as in the plane."""

    def __init__(self, walls: Walls, reach: float, rank: Index) -> None:
        self._walls, self._reach, self._rank = walls, reach, rank
        self._near = NearEdges(walls, reach)
        self._search: PartnerSearch | None = None
        self._faced = np.zeros(0, dtype=np.int64)

    def points(self, nodes: Array) -> tuple[Partners, Partners | None]:
        """Return the points of the polygons last found, each with its closest point on the body that it faced there."""
        if self._search is None:
            self.renew(nodes)
        assert self._search is not None
        found = self._search.partners(nodes)
        kept = np.flatnonzero(self._walls.body[found.other] == self._faced[found.point])
        return Partners(**{name: array[kept] for name, array in vars(found).items()}), None

    def renew(self, nodes: Array) -> bool:
        """Find the polygons at deformed nodes."""
        from ngcell.contact.overlays import find_overlays, overlay_partners

        edge, other = _carried(self._walls, self._rank, *self._near.pairs(nodes))
        found = overlay_partners(self._walls, nodes, find_overlays(self._walls, nodes, edge, other), self._reach)
        self._search = PartnerSearch(self._walls, WallPoints(found.edge, found.here, found.weight), self._reach)
        self._faced = self._walls.body[found.other]
        return True


def integration(walls: Walls, reach: float, rank: Index) -> Integration:
    """Return the rule for walls of this dimension."""
    return (SegmentIntegration if walls.dimension == 2 else OverlayIntegration)(walls, reach, rank)


def _carried(walls: Walls, rank: Index, edge: Index, other: Index) -> tuple[Index, Index]:
    carries = rank[walls.body[edge]] < rank[walls.body[other]]
    return edge[carries], other[carries]
