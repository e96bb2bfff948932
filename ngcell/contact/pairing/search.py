"""Which wall is near whom: for each point of a wall, the closest point on every other body in reach.

Facets that are near each other are found once and kept while nothing has moved by more than a margin; simple bounds
narrow the choice, and Newton's method on the curved, deformed facet finishes it. A point may have one contact pair on
each of several bodies: where three cells meet it has a gap to both neighbours, and never flips between them.

The gap that comes out of this is the signed distance to the surface of the other body. No candidate is refused for the
direction of its normal: that would cut holes into the surface, and energy would jump where a corner slides past
another. A contact pair is either the foot of a normal or a joint of two facets, behind which (the foot would lie beyond
either end) the gap is the distance to the joint. Only where a surface ends, because what follows is no wall, may a
point lie behind a facet and further aside than deep: it has slid past the end, overlaps nothing, and is left out.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.classification import TIE
from ngcell.contact.pairing.closest import classified, closest_points, nearest_candidates
from ngcell.contact.pairing.near import NearFacets, Reach, reach_between
from ngcell.contact.pairing.pairs import ContactPairs, joined
from ngcell.contact.surface.surface import Surface, SurfacePoints
from ngcell.geometry.near import ranges
from ngcell.threads import at_once, parts_of

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class PairSearch:
    """The search for closest points.

    Parameters
    ----------
    walls : Surface
        The walls.
    points : SurfacePoints
        The points that look for contact pairs, facet by facet.
    reach : float or array of float, shape (bodies,)
        Distance up to which contact pairs are found [length].
    """

    def __init__(self, walls: Surface, points: SurfacePoints, reach: Reach) -> None:
        self._walls = walls
        self._points = points
        self.reach = reach
        self._count = np.bincount(points.facet, minlength=walls.facet_count)
        self._first = np.cumsum(self._count) - self._count
        self._values = walls.basis.values(points.xi)
        self._near = NearFacets(walls, reach)
        self._sorted: tuple[tuple[Index, Index], tuple[Index, Index]] | None = None

    def pairs(self, nodes: Array) -> ContactPairs:
        """Return all contact pairs of a deformed state.

        Parameters
        ----------
        nodes : array of float, shape (facets, nodes, dimension)
            Deformed positions of the walls' nodes [length].
        """
        facet, other = self._near_facets(nodes)
        place = np.einsum("pi,pid->pd", self._values, nodes[self._points.facet])
        # Points of a facet stay together: which pairs they have depends on all its neighbours.
        ends = np.searchsorted(facet, [part.start for part in parts_of(self._walls.facet_count, nodes.size)][1:])
        shares = zip(np.split(facet, ends), np.split(other, ends), strict=True)
        return joined(at_once(nodes.size, [partial(self._pairs_among, nodes, place, *share) for share in shares]))

    def _near_facets(self, nodes: Array) -> tuple[Index, Index]:
        """Return facets, in increasing order, and others that are near them."""
        found = self._near.pairs(nodes)
        if self._sorted is None or found is not self._sorted[0]:
            order = np.argsort(found[0], kind="stable")
            self._sorted = found, (found[0][order], found[1][order])
        return self._sorted[1]

    def _pairs_among(self, nodes: Array, place: Array, facet: Index, other: Index) -> ContactPairs:
        """Return the contact pairs of the points of facets, at their places, with other facets."""
        walls, points = self._walls, self._points
        number, other = self._candidates(facet, other)
        place = place[number]
        reach = reach_between(walls, self.reach, points.facet[number], other)
        chosen, xi, distance = _nearest(walls, nodes, number, other, place, reach)
        within = distance <= reach[chosen]
        chosen, xi = chosen[within], xi[within]
        number, other, place = number[chosen], other[chosen], place[chosen]
        found = classified(walls, nodes, other, xi, place)
        own = (number, points.facet[number], points.xi[number], points.weight[number])
        pairs = ContactPairs(*own, other, xi, found.at_end, found.sign, found.slide_direction)
        return pairs.chosen(~found.slid_past)

    def _candidates(self, facet: Index, other: Index) -> tuple[Index, Index]:
        """Return points of facets, and the facets near the facet of each."""
        count = self._count[facet]
        number = np.repeat(self._first[facet] - np.cumsum(count) + count, count) + np.arange(count.sum())
        return number, np.repeat(other, count)


def nearest_on_body(walls: Surface, nodes: Array, point: Array, body: Index) -> Array:
    """Return the signed distance [length] of each point to the walls of a body, positive outside.

    Parameters
    ----------
    walls : Surface
        The walls.
    nodes : array of float, shape (facets, nodes, dimension)
        Deformed positions of the walls' nodes [length].
    point : array of float, shape (points, dimension)
        The points [length].
    body : array of int, shape (points,)
        The body asked for.
    """
    order = np.argsort(walls.body, kind="stable")
    first = np.searchsorted(walls.body[order], np.arange(walls.body.max(initial=0) + 2))
    row, place = ranges(np.arange(len(point)), first[body], first[body + 1])
    other = order[place]
    chosen, xi, signed = _nearest(walls, nodes, row, other, point[row], np.inf)
    found = classified(walls, nodes, other[chosen], xi, point[row[chosen]])
    signed[~found.slid_past] *= found.sign[~found.slid_past]
    return signed


def _nearest(
    walls: Surface, nodes: Array, number: Index, other: Index, place: Array, reach: float | Array
) -> tuple[Index, Array, Array]:
    """Return which candidates hold the nearest point of each part to each point, with its coordinates and distance.

    Candidates are the point with a number at a place, shape (candidates, dimension), and another facet.
    """
    kept = nearest_candidates(walls, nodes, number, other, place, reach)
    number, other, place = number[kept], other[kept], place[kept]
    xi, distance = closest_points(walls, nodes, other, place)
    group = number * (walls.part.max(initial=0) + 1) + walls.part[other]
    best = _smallest_of_group(group, _joints_apart(walls, nodes, other, place, distance))
    return kept[best], xi[best], distance[best]


def _joints_apart(walls: Surface, nodes: Array, other: Index, point: Array, distance: Array) -> Array:
    """Return distances with ties broken: where two facets meet, the one that sees the point outside is chosen.

    At a convex corner a point outside may still lie behind the extended line of one of the two facets.
    """
    height = np.einsum("pd,pd->p", point - nodes[other, 0], walls.chord_normals(nodes)[other])
    return np.asarray(distance - TIE * np.clip(height, -distance, distance))


def _smallest_of_group(group: Index, value: Array) -> Index:
    """Return, for each group, the position of its smallest value."""
    order = np.lexsort((value, group))
    first = np.ones(len(order), dtype=bool)
    first[1:] = np.diff(group[order]) != 0
    return np.asarray(order[first])
