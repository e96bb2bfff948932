"""Points at which weighted gaps are integrated over the walls that have multipliers.

In the plane segments are found anew in each state, and their ends move with it. In three dimensions polygons are found
where multipliers are updated, and their points stay on their wall until then; their contact pairs are found anew in
each state. So there is one energy for each set of multipliers, nothing of it depends on how polygons move, and at the
end, where nothing moves any more, the rule is that of the polygons of the equilibrium.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.edge_multipliers import EdgeFunctions
from ngcell.contact.methods.multipliers import SHARP, MultiplierSpace
from ngcell.contact.pairing.intersections import find_intersections, intersection_pairs
from ngcell.contact.pairing.near import NearFacets, Reach
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.pairing.search import PairSearch
from ngcell.contact.pairing.segments import SegmentEnds, find_segments, segment_pairs
from ngcell.contact.pairing.wall_ends import WallEnds
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.facets import FacetSurface
from ngcell.contact.surface.surface import Surface, SurfacePoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Integration(Protocol):
    """A rule along the walls."""

    def points(self, nodes: Array) -> tuple[ContactPairs, SegmentEnds | None]:
        """Return the points with their contact pairs, and the cuts that end segments where these move."""

    def renew(self, nodes: Array) -> bool:
        """Adapt the rule to deformed nodes, and tell whether it had to be."""


def wall_ends(walls: EdgeSurface) -> WallEnds:
    """Return the ends of walls, where multipliers are broken, too."""
    return WallEnds(np.abs(walls.exterior_angle) >= SHARP)


def rule_of_ends(
    walls: Surface, space: MultiplierSpace, ends: SegmentEnds, points: ContactPairs, nodes: Array
) -> tuple[Array, Array, Array]:
    """Return tangents and factors of a rule whose points move along with the ends of segments.

    They are those of `ngcell.contact.gap.moving_ends.Cuts`: `along`, `by_gap` and `by_slope`.
    """
    found = points.chosen(ends.point.ravel())
    (along,) = walls.tangents(found.primary, found.primary_xi, nodes)
    share = found.weight[:, None] / space.weight[space.row[found.primary]]
    functions = space.values(found.primary_xi), EdgeFunctions(space.degree).slopes(found.primary_xi)
    values, slopes = ((share * each).reshape(*ends.point.shape, space.row.shape[1]) for each in functions)
    follows, grows = ends.follows[..., None], ends.grows[..., None]
    by_gap, by_slope = grows * values + follows * slopes, follows * values
    return along.reshape(*ends.point.shape, 2), by_gap.transpose(0, 2, 1), by_slope.transpose(0, 2, 1)


class SegmentIntegration:
    """The rule in the plane.

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    reach : float or array of float, shape (bodies,)
        Distance up to which walls are paired [length].
    rank : array of int, shape (bodies,)
        Of a pair, the body with the lower rank has the multipliers.
    limit : float
        Product of normals below which facets face each other.
    """

    def __init__(self, walls: EdgeSurface, reach: Reach, rank: Index, limit: float) -> None:
        self._walls, self._reach, self._rank, self._limit = walls, reach, rank, limit
        self._near = NearFacets(walls, reach)
        self._ends = wall_ends(walls)

    def points(self, nodes: Array) -> tuple[ContactPairs, SegmentEnds | None]:
        """Return the points of the segments of this state, and their ends."""
        primary, secondary = _with_multipliers(self._walls, self._rank, *self._near.pairs(nodes))
        segments = find_segments(self._walls, nodes, primary, secondary, self._limit, self._ends)
        return segment_pairs(self._walls, nodes, segments, self._reach, self._ends)

    def renew(self, nodes: Array) -> bool:
        """Do nothing: segments are always those of the state."""
        return False


class IntersectionIntegration:
    """The rule in three dimensions; parameters as in the plane."""

    def __init__(self, walls: FacetSurface, reach: Reach, rank: Index, limit: float) -> None:
        self._walls, self._reach, self._rank, self._limit = walls, reach, rank, limit
        self._near = NearFacets(walls, reach)
        self._search: PairSearch | None = None
        self._faced = np.zeros(0, dtype=np.int64)

    def points(self, nodes: Array) -> tuple[ContactPairs, SegmentEnds | None]:
        """Return the points of the polygons last found, each with its closest point on the body that it faced there."""
        if self._search is None:
            self.renew(nodes)
        assert self._search is not None
        found = self._search.pairs(nodes)
        return found.chosen(self._walls.body[found.secondary] == self._faced[found.point]), None

    def renew(self, nodes: Array) -> bool:
        """Find the polygons at deformed nodes."""
        walls = self._walls
        primary, secondary = _with_multipliers(walls, self._rank, *self._near.pairs(nodes))
        polygons = find_intersections(walls, nodes, primary, secondary, self._limit)
        found = intersection_pairs(walls, nodes, polygons, self._reach)
        points = SurfacePoints(found.primary, found.primary_xi, found.weight)
        self._search = PairSearch(walls, points, self._reach)
        self._faced = walls.body[found.secondary]
        return True


@singledispatch
def integration(walls: Surface, reach: Reach, rank: Index, limit: float) -> Integration:
    """Return the rule for a surface; parameters as for `SegmentIntegration`."""
    raise NotImplementedError(type(walls))


integration.register(EdgeSurface, SegmentIntegration)
integration.register(FacetSurface, IntersectionIntegration)


def _with_multipliers(walls: Surface, rank: Index, one: Index, two: Index) -> tuple[Index, Index]:
    """Return the pairs of facets whose first one has the multipliers."""
    has_multiplier = rank[walls.body[one]] < rank[walls.body[two]]
    return one[has_multiplier], two[has_multiplier]
