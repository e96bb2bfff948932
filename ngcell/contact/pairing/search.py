"""Who is near whom: for each point of a wall, the closest point on every other body in reach.

Edges whose midpoints are near are found once and kept while nothing has moved by more than a margin;
their chords narrow the choice, and a few Newton steps on the curved, deformed edge finish it. A point
may have one contact pair on each of several bodies: where three cells meet it answers to both neighbours, and never
flips between them.

The gap that comes out of this is the signed distance to the outline of the other body. No candidate is refused for the
direction of its normal: that would cut holes into the outline, and energy would jump where a corner slides past
another. A contact pair is either the foot of a normal or a joint of two edges, behind which (the foot would lie beyond
either end) the gap is the distance to the joint. Only where an outline ends, because what follows is no wall, may a
point lie behind an edge and further aside than deep: it has slid past the end, overlaps nothing, and is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.surface.walls import WallPoints, Walls
from ngcell.geometry.near import near_pairs

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_PROJECTION_STEPS = 4
#: Share by which the distance of tied candidates is told apart.
_TIE = 1e-7
#: Exterior angle of a joint [rad] below which the distances of its edges may be tied.
_BLUNT = 2 * (2 * _TIE) ** 0.5
#: Share of an edge beyond which a foot counts as past its end: round-off of the projection, no more.
_END_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class ContactPairs:
    """Points of walls and their closest points on other bodies; all arrays have one entry a contact pair.

    Attributes
    ----------
    point : array of int
        Number of the primary point among those that were asked for.
    edge : array of int
        Primary edge.
    here : array of float
        Coordinate of the point on it, in [0, 1]; in three dimensions two.
    weight : array of float
        Quadrature weight of the point [length].
    other : array of int
        Secondary edge.
    xi : array of float
        Coordinate of the closest point on the secondary edge, in [0, 1].
    at_end : array of bool
        Whether the closest point is an end of the secondary edge and no foot of a normal.
    sign : array of float
        +1 outside the secondary body, -1 inside.
    glide : array of float, optional
        In three dimensions: direction on the secondary face in which the closest point may slide along its side, two coordinates;
        0 at corners and feet.
    """

    point: Index
    edge: Index
    here: Array
    weight: Array
    other: Index
    xi: Array
    at_end: NDArray[np.bool_]
    sign: Array
    glide: Array | None = None

    def __len__(self) -> int:
        return len(self.edge)


class NearEdges:
    """Ordered pairs of edges of different bodies within reach, kept while nothing has moved far.

    Parameters
    ----------
    walls : Walls
        The walls.
    reach : float
        Distance up to which no pair is missed [length].
    """

    def __init__(self, walls: Walls, reach: float) -> None:
        self._walls = walls
        self._reach = reach
        self._pairs: tuple[Index, Index] | None = None
        self._found_at: Array | None = None

    def pairs(self, nodes: Array) -> tuple[Index, Index]:
        """Return the pairs at deformed nodes of shape (edges, order + 1, 2) [length]; some may be out of reach."""
        margin = self._reach
        if self._pairs is None or np.abs(nodes - self._found_at).max() > margin / 2:
            self._pairs, self._found_at = near_edges(self._walls, nodes, self._reach + 2 * margin), nodes
        return self._pairs


class PairSearch:
    """The search for closest points.

    Parameters
    ----------
    walls : Walls
        The walls.
    points : WallPoints
        The points that look for contact pairs, edge by edge.
    reach : float
        Distance up to which contact pairs are found [length].
    """

    def __init__(self, walls: Walls, points: WallPoints, reach: float) -> None:
        self._walls = walls
        self._points = points
        self.reach = reach
        self._count = np.bincount(points.edge, minlength=walls.edge_count)
        self._first = np.cumsum(self._count) - self._count
        self._values = walls.basis.values(points.xi)
        self._near = NearEdges(walls, reach)

    def pairs(self, nodes: Array) -> ContactPairs:
        """Return all contact pairs of a deformed state.

        Parameters
        ----------
        nodes : array of float, shape (edges, order + 1, 2)
            Deformed positions of the walls' nodes [length].
        """
        walls = self._walls
        number, other = self._candidates(nodes)
        place = np.einsum("pi,pid->pd", self._values, nodes[self._points.edge])[number]
        keep = _best(walls, nodes, number, other, place, self.reach)
        number, other, place = number[keep], other[keep], place[keep]
        xi, distance = _closest(walls, nodes, other, place)
        group = number * (walls.body.max() + 1) + walls.body[other]
        best = _smallest_of_group(group, _joints_apart(walls, nodes, other, place, distance))
        best = best[distance[best] <= self.reach]
        return _classified(walls, nodes, self._points, number[best], other[best], xi[best], place[best])

    def _candidates(self, nodes: Array) -> tuple[Index, Index]:
        """Return points and edges near their own edge."""
        edge, other = self._near.pairs(nodes)
        count = self._count[edge]
        number = np.repeat(self._first[edge] - np.cumsum(count) + count, count) + np.arange(count.sum())
        return number, np.repeat(other, count)


def near_edges(walls: Walls, nodes: Array, reach: float) -> tuple[Index, Index]:
    """Return all ordered pairs of edges of different bodies that are nearer than `reach` [length]."""
    middle = walls.middles(nodes)
    half = np.linalg.norm(nodes - middle[:, None], axis=2).max(1)
    one, two = near_pairs(middle, reach + 2 * float(half.max(initial=0.0)))
    distance = np.linalg.norm(middle[one] - middle[two], axis=1)
    near = (walls.body[one] != walls.body[two]) & (distance < reach + half[one] + half[two])
    one, two = one[near], two[near]
    return np.concatenate([one, two]), np.concatenate([two, one])


def adjacency(walls: Walls, nodes: Array, reach: float) -> sparse.csr_array:
    """Return which edges are the same or nearer than `reach` [length], shape (edges, edges)."""
    one, two = near_edges(walls, nodes, reach)
    near = sparse.csr_array((np.ones(len(one)), (one, two)), shape=(walls.edge_count,) * 2)
    return (near + sparse.eye_array(walls.edge_count)).tocsr()


def nearest_on_body(walls: Walls, nodes: Array, point: Array, body: Index) -> Array:
    """Return the signed distance [length] of each point to the walls of a body, positive outside.

    Parameters
    ----------
    walls : Walls
        The walls.
    nodes : array of float, shape (edges, order + 1, 2)
        Deformed positions of the walls' nodes [length].
    point : array of float, shape (points, 2)
        The points [length].
    body : array of int, shape (points,)
        The body asked for.
    """
    order = np.argsort(walls.body, kind="stable")
    first = np.searchsorted(walls.body[order], np.arange(walls.body.max() + 2))
    count = (first[1:] - first[:-1])[body]
    row = np.repeat(np.arange(len(point)), count)
    within = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    other = order[first[body[row]] + within]
    keep = _best(walls, nodes, row, other, point[row], np.inf)
    row, other = row[keep], other[keep]
    xi, distance = _closest(walls, nodes, other, point[row])
    best = _smallest_of_group(row, _joints_apart(walls, nodes, other, point[row], distance))
    nowhere = np.zeros(len(point))
    points = WallPoints(np.zeros(len(point), dtype=np.int64), np.zeros((len(point), *xi.shape[1:])), nowhere)
    found = _classified(walls, nodes, points, row[best], other[best], xi[best], point[row[best]])
    signed = distance[best]
    signed[found.point] *= found.sign
    return signed


def _best(walls: Walls, nodes: Array, group: Index, other: Index, point: Array, reach: float) -> Index:
    """Return the candidates that may hold the nearest point of the same body."""
    if walls.dimension == 2:
        return _best_chords(group, walls.body[other], point, nodes[other], reach)
    from ngcell.contact.pairing.closest import nearest_candidates

    return nearest_candidates(walls, nodes, group, other, point, reach)


def _best_chords(group: Index, body: Index, point: Array, nodes: Array, reach: float) -> Index:
    """Return the candidates whose chord is, up to the edge's sagitta, the nearest of the same body."""
    chord = nodes[:, -1] - nodes[:, 0]
    length2 = np.einsum("pd,pd->p", chord, chord)
    offset = point - nodes[:, 0]
    xi = np.clip(np.einsum("pd,pd->p", offset, chord) / length2, 0, 1)
    distance = np.linalg.norm(offset - xi[:, None] * chord, axis=1)
    sagitta = 0.5 * np.linalg.norm(np.diff(nodes, axis=1), axis=2).sum(1) - 0.5 * np.sqrt(length2)
    sagitta = np.sqrt(np.maximum(sagitta * np.sqrt(length2), 0)) * 1.5 + 1e-12 * np.sqrt(length2)
    near = np.flatnonzero(distance < reach + sagitta)
    key = group[near] * (body.max() + 1 if len(body) else 1) + body[near]
    _, member = np.unique(key, return_inverse=True)
    bound = np.full(member.max() + 1 if len(member) else 0, np.inf)
    np.minimum.at(bound, member, distance[near] + sagitta[near])
    return near[distance[near] - sagitta[near] <= bound[member]]


def _closest(walls: Walls, nodes: Array, other: Index, point: Array) -> tuple[Array, Array]:
    """Return coordinate and distance of the closest point on the edge `other` of each point."""
    if walls.dimension == 2:
        return closest_on_edges(walls, nodes[other], point)
    from ngcell.contact.pairing.closest import closest_on_faces

    return closest_on_faces(walls, nodes[other], other, point)


def closest_on_edges(walls: Walls, nodes: Array, point: Array) -> tuple[Array, Array]:
    """Return coordinate and distance of the closest point on curved edges; `nodes` has one edge a point."""
    chord = nodes[:, -1] - nodes[:, 0]
    xi = np.einsum("pd,pd->p", point - nodes[:, 0], chord) / np.einsum("pd,pd->p", chord, chord)
    xi = np.clip(xi, 0, 1)
    for _ in range(_PROJECTION_STEPS if walls.basis.order > 1 else 0):
        position, slope, bend = (np.einsum("pi,pid->pd", walls.basis.values(xi, degree), nodes) for degree in range(3))
        away = point - position
        gradient = np.einsum("pd,pd->p", away, slope)
        steepness = np.einsum("pd,pd->p", slope, slope)
        curvature = np.maximum(steepness - np.einsum("pd,pd->p", away, bend), 0.1 * steepness)
        xi = np.clip(xi + gradient / curvature, 0, 1)
    position = np.einsum("pi,pid->pd", walls.basis.values(xi), nodes)
    return xi, np.linalg.norm(point - position, axis=1)


def _joints_apart(walls: Walls, nodes: Array, other: Index, point: Array, distance: Array) -> Array:
    """Return distances with ties broken: at a joint, which two edges share, the one that sees the point outside wins.

    At a convex corner a point outside may still lie behind the extended line of one of the two edges.
    """
    height = np.einsum("pd,pd->p", point - nodes[other, 0], walls.chord_normals(nodes)[other])
    return distance - _TIE * np.clip(height, -distance, distance)


def _smallest_of_group(group: Index, value: Array) -> Index:
    """Return, for each group, the position of its smallest value."""
    order = np.lexsort((value, group))
    first = np.ones(len(order), dtype=bool)
    first[1:] = np.diff(group[order]) != 0
    return np.asarray(order[first])


def _classified(
    walls: Walls, nodes: Array, points: WallPoints, number: Index, other: Index, xi: Array, place: Array
) -> ContactPairs:
    own = (number, points.edge[number], points.xi[number], points.weight[number])
    if walls.dimension == 3:
        from ngcell.contact.pairing.closest import classified

        at_end, glide, sign, slid_past = classified(walls, nodes, other, xi, place)
        return ContactPairs(*(array[~slid_past] for array in (*own, other, xi, at_end, sign, glide)))
    mine = nodes[other]
    position = np.einsum("pi,pid->pd", walls.basis.values(xi), mine)
    slope = np.einsum("pi,pid->pd", walls.basis.values(xi, 1), mine)
    speed2 = np.einsum("pd,pd->p", slope, slope)
    away = place - position
    aside = np.einsum("pd,pd->p", away, slope) / speed2
    height = walls.side[other] * (away[:, 0] * slope[:, 1] - away[:, 1] * slope[:, 0]) / speed2
    at_end = np.abs(aside) > _END_TOLERANCE
    ends_here = np.where(xi < 0.5, walls.is_loose_end[other, 0], walls.is_loose_end[other, 1])
    slid_past = at_end & ends_here & (height < 0) & (np.abs(aside) > np.abs(height))
    kept = ~slid_past
    sign = np.where(height < 0, -1.0, 1.0)
    doubtful = np.flatnonzero(at_end & ~ends_here & (height < 0))
    if len(doubtful):
        # The nearest point of a body is a convex corner only for points outside, however the corner's edges bend.
        exterior_angle = walls.exterior_angle_at(nodes)[other[doubtful], (xi[doubtful] >= 0.5).astype(int)]
        sign[doubtful[exterior_angle > _BLUNT]] = 1.0
    return ContactPairs(*(array[kept] for array in (*own, other, xi, at_end, sign)))
