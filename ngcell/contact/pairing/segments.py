"""Where a wall of one body faces a wall of another: segments between the projections of vertices.

A segment is the part of an edge whose points have their foot on one and the same edge of the other body. It ends where
either edge ends, so shape functions of both sides are smooth on it, and a Gauss rule integrates
products of the two sides on straight walls exactly, whatever the meshes: the condition of the patch test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.options import DEFAULT_OPTIONS
from ngcell.contact.pairing.closest_on_edges import closest_points
from ngcell.contact.pairing.near import Reach, facing, reach_between
from ngcell.contact.pairing.pairs import ContactPairs, feet
from ngcell.contact.pairing.unit_roots import unit_roots
from ngcell.contact.pairing.wall_ends import WallEnds
from ngcell.contact.surface.edges import EdgeSurface

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of an edge below which a segment is left out.
_SLIVER = 1e-9


@dataclass(frozen=True, eq=False)
class Segments:
    """Parts of edges that face other edges; all arrays have one entry a segment.

    Attributes
    ----------
    primary, secondary : array of int
        The edge that is integrated over, and the one it faces.
    at : array of float, shape (n, 2)
        Where on the primary edge the start and the end of the secondary one are projected to, cut off at 0 and 1.
    """

    primary: Index
    secondary: Index
    at: Array


@dataclass(frozen=True, eq=False)
class SegmentEnds:
    """Ends of segments that move as walls slide: n of them, each of a segment with m points.

    Attributes
    ----------
    cuts : ContactPairs
        The vertices of the other wall, and the points that they are projected to. The weight is the rate at which the
        segment grows with that point's coordinate [length]: positive at the upper end, negative at the lower one.
    point : array of int, shape (n, m)
        The points of the segment.
    follows, grows : array of float, shape (n, m)
        By how much the coordinate of each of them, and its weight over itself, changes with the coordinate of the end.
    """

    cuts: ContactPairs
    point: Index
    follows: Array
    grows: Array


def find_segments(
    walls: EdgeSurface,
    nodes: Array,
    primary: Index,
    secondary: Index,
    limit: float = DEFAULT_OPTIONS.facing,
    ends: WallEnds | None = None,
) -> Segments:
    """Return the segments of pairs of edges at deformed nodes, shape (edges, order + 1, 2) [length].

    Those whose normals multiply to `limit` or more do not face each other, and have none. At `ends` segments come to
    rest.
    """
    opposed = facing(walls, nodes, primary, secondary, limit)
    primary, secondary = primary[opposed], secondary[opposed]
    at = np.column_stack([_projected(walls, nodes, primary, secondary, end) for end in (0, 1)])
    if ends is not None:
        at = np.column_stack([ends.places(primary, column) for column in at.T])
    kept = np.ptp(at, axis=1) > _SLIVER
    return Segments(primary[kept], secondary[kept], at[kept])


def _projected(walls: EdgeSurface, nodes: Array, primary: Index, secondary: Index, end: int) -> Array:
    """Return where on the primary edge the normal through an end of the secondary one meets it, in [0, 1]."""
    vertex = nodes[secondary, -end]
    tangent = np.einsum("i,eid->ed", walls.basis.values(np.array(float(end)), 1), nodes[secondary])
    start = nodes[primary, 0]
    chord = np.einsum("ed,ed->e", nodes[primary, -1] - start, tangent)
    xi = np.clip(np.einsum("ed,ed->e", vertex - start, tangent) / chord, 0, 1)
    if walls.basis.order == 1:
        return np.asarray(xi)
    way_past = np.einsum("eid,ed->ie", nodes[primary] - vertex[:, None], tangent) * np.sign(chord)
    return unit_roots(walls.basis.by_powers(way_past), xi)


def segment_pairs(
    walls: EdgeSurface, nodes: Array, segments: Segments, reach: Reach, ends: WallEnds | None = None
) -> tuple[ContactPairs, SegmentEnds]:
    """Return the Gauss points of all segments that come nearer than `reach` [length], and the cuts that end them.

    At `ends` of walls segments come to rest.
    """
    count = walls.basis.order + 2
    place, share = np.polynomial.legendre.leggauss(count)
    place = (place + 1) / 2
    low, span = segments.at.min(1), np.ptp(segments.at, axis=1)
    own = (low[:, None] + span[:, None] * place).ravel()
    primary, secondary = (np.repeat(array, count) for array in (segments.primary, segments.secondary))
    xi, distance = closest_points(walls, nodes, secondary, walls.places(primary, own, nodes))
    near = distance.reshape(-1, count).min(1) < reach_between(walls, reach, segments.primary, segments.secondary)
    weight = (span[:, None] * share / 2).ravel() * walls.rest_measure(primary, own)
    chosen = np.flatnonzero(np.repeat(near, count))
    points = feet(primary[chosen], own[chosen], weight[chosen], secondary[chosen], xi[chosen])
    segment, end = np.nonzero(near[:, None] & (segments.at > 0) & (segments.at < 1))
    at, edge = segments.at[segment, end], segments.primary[segment]
    upper = at > segments.at[segment, 1 - end]
    rate, slope = np.where(upper, 1.0, -1.0), np.ones(len(at))
    if ends is not None:
        slope, _ = ends.rates(edge, at)
    cuts = feet(edge, at, rate * slope * walls.rest_measure(edge, at), segments.secondary[segment], end.astype(float))
    point = count * (np.cumsum(near) - 1)[segment, None] + np.arange(count)
    follows = np.where(upper[:, None], place, 1 - place) * slope[:, None]
    grows = follows * _growth(walls, points.chosen(point.ravel())).reshape(point.shape)
    return points, SegmentEnds(cuts, point, follows, grows + (rate * slope / span[segment])[:, None])


def _growth(walls: EdgeSurface, points: ContactPairs) -> Array:
    """Return the derivative of the rest measure along each point's edge over itself."""
    (tangent,) = walls.tangents(points.primary, points.primary_xi, walls.rest)
    bend = np.einsum("pi,pid->pd", walls.basis.values(points.primary_xi, 2), walls.rest[points.primary])
    return np.asarray(np.einsum("pd,pd->p", tangent, bend) / np.einsum("pd,pd->p", tangent, tangent))
