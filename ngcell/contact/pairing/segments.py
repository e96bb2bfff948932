"""Where a wall of one body faces a wall of another: segments between the projections of vertices.

A segment is the part of a secondary-facing edge whose points have their foot on one edge of the other body. It ends
where an end of either edge ends, so shape functions of both sides are smooth on it, and a Gauss rule integrates
products of the two sides on straight walls exactly, whatever the meshes: the condition of the patch test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.search import ContactPairs, closest_on_edges
from ngcell.contact.surface.walls import Walls

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Edges face each other while the normals of their chords differ from opposite by less than about 37 degrees. A corner
#: that presses with a steeper angle acts at its tip.
FACING = -0.8
#: Share of an edge below which a segment is left out.
_SLIVER = 1e-9
_PROJECTION_STEPS = 5


@dataclass(frozen=True, eq=False)
class Segments:
    """Parts of edges that face other edges; all arrays have one entry a segment.

    Attributes
    ----------
    edge, other : array of int
        The edge that has the multiplier, and the one it faces.
    at : array of float, shape (n, 2)
        Where on `edge` the start and the end of `other` are projected to, cut off at 0 and 1.
    """

    edge: Index
    other: Index
    at: Array


def find_segments(walls: Walls, nodes: Array, edge: Index, other: Index) -> Segments:
    """Return the segments of pairs of edges at deformed nodes, shape (edges, order + 1, 2) [length]."""
    normal = walls.chord_normals(nodes)
    facing = np.einsum("ed,ed->e", normal[edge], normal[other]) < FACING
    edge, other = edge[facing], other[facing]
    at = np.column_stack([_projected(walls, nodes, edge, other, end) for end in (0, 1)])
    kept = np.ptp(at, axis=1) > _SLIVER
    return Segments(edge[kept], other[kept], at[kept])


def _projected(walls: Walls, nodes: Array, edge: Index, other: Index, end: int) -> Array:
    """Return where on `edge` the normal through an end of `other` meets it, in [0, 1]."""
    vertex = nodes[other, -end]
    tangent = np.einsum("i,eid->ed", walls.basis.values(np.array(float(end)), 1), nodes[other])
    start = nodes[edge, 0]
    chord = np.einsum("ed,ed->e", nodes[edge, -1] - start, tangent)
    xi = np.clip(np.einsum("ed,ed->e", vertex - start, tangent) / chord, 0, 1)
    along = np.einsum("eid,ed->ei", nodes[edge] - vertex[:, None], tangent)
    for _ in range(_PROJECTION_STEPS if walls.basis.order > 1 else 0):
        value = np.einsum("ei,ei->e", walls.basis.values(xi), along)
        rate = np.einsum("ei,ei->e", walls.basis.values(xi, 1), along)
        steepest = np.where(chord < 0, np.minimum(rate, 0.1 * chord), np.maximum(rate, 0.1 * chord))
        xi = np.clip(xi - value / steepest, 0, 1)
    return xi


def segment_pairs(walls: Walls, nodes: Array, segments: Segments, reach: float) -> tuple[ContactPairs, ContactPairs]:
    """Return the Gauss points of all segments that come nearer than `reach` [length], and the cuts that end them.

    A cut is a vertex of the other wall and the point that it is projected to. Its weight is the rate at which the
    segment grows with that point's coordinate [length]: positive at the upper end, negative at the lower one.
    """
    count = walls.basis.order + 2
    place, share = np.polynomial.legendre.leggauss(count)
    low, span = segments.at.min(1), np.ptp(segments.at, axis=1)
    here = (low[:, None] + span[:, None] * (place + 1) / 2).ravel()
    edge, other = (np.repeat(array, count) for array in (segments.edge, segments.other))
    point = np.einsum("pi,pid->pd", walls.basis.values(here), nodes[edge])
    xi, distance = closest_on_edges(walls, nodes[other], point)
    near = distance.reshape(-1, count).min(1) < reach
    weight = (span[:, None] * share / 2).ravel() * _speed(walls, edge, here)
    chosen = np.flatnonzero(np.repeat(near, count))
    points = _feet(edge[chosen], here[chosen], weight[chosen], other[chosen], xi[chosen])
    segment, end = np.nonzero(near[:, None] & (segments.at > 0) & (segments.at < 1))
    at = segments.at[segment, end]
    grows = np.where(at > segments.at[segment, 1 - end], 1.0, -1.0)
    edge = segments.edge[segment]
    cuts = _feet(edge, at, grows * _speed(walls, edge, at), segments.other[segment], end.astype(float))
    return points, cuts


def _feet(edge: Index, here: Array, weight: Array, other: Index, xi: Array) -> ContactPairs:
    count = len(edge)
    return ContactPairs(
        point=np.arange(count),
        edge=edge,
        here=here,
        weight=weight,
        other=other,
        xi=xi,
        at_end=np.zeros(count, dtype=bool),
        sign=np.ones(count),
    )


def _speed(walls: Walls, edge: Index, xi: Array) -> Array:
    return np.asarray(np.linalg.norm(np.einsum("pi,pid->pd", walls.basis.values(xi, 1), walls.rest[edge]), axis=1))
