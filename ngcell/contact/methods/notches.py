"""Points that press into notches: concave joints of two edges, whose edges hold them one by one.

Between two edges at a concave joint the distance to a wall is the smaller of the distances to both: it has a kink where
they are alike, and there points come to rest. Each model of the energy sees one of the edges, and its step goes on to
the other. A point that presses near the joint is therefore held by each edge, extended along the tangent at its end,
with a multiplier of its own: gaps and their derivatives are then smooth, and the kink is where both conditions act.

A point is taken up where iterations have gone over a joint and back, which they do once more at the most: its pressure
stays with the edge that it is on, the other edge has none yet. It is released where multipliers are updated.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.gap.by_surface import gap_kinematics
from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.pairing.closest_on_edges import BLUNT, closest_points
from ngcell.contact.pairing.pairs import ContactPairs, feet, joined
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.surface import Surface, SurfacePoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Notches:
    """The points that are held by both edges of a notch.

    Parameters
    ----------
    walls : Surface
        The walls. In three dimensions no point is held so.
    points : SurfacePoints
        The points that may be.

    Attributes
    ----------
    point : array of int, shape (n,)
        Numbers of the points that are.
    edges : array of int, shape (n, 2)
        The edges that hold each; the first is that on which its closest point was found.
    """

    def __init__(self, walls: Surface, points: SurfacePoints) -> None:
        self._walls, self._points = walls, points
        self._bodies = int(walls.body.max(initial=0)) + 1
        self._beside = _beside(walls) if isinstance(walls, EdgeSurface) else None
        self.clear()

    def clear(self) -> None:
        """Hold no point."""
        self.point, self.edges = np.zeros(0, dtype=np.int64), np.zeros((0, 2), dtype=np.int64)
        self._visited = np.full((len(self._points.facet) * self._bodies, 2), -1)

    def __len__(self) -> int:
        return len(self.point)

    @property
    def bodies(self) -> Index:
        """Bodies of the edges, shape (n,)."""
        return np.asarray(self._walls.body[self.edges[:, 0]])

    def pairs(self, found: ContactPairs, nodes: Array) -> ContactPairs:
        """Return the pairs of all points; at the end those of held ones with the first edges, then with the second.

        `found` has the closest points on each body. A point that is held counts as such as long as its closest point is
        on one of its edges. With the second edge it has a number beyond those of all points.
        """
        if not len(self):
            return found
        row = self._row(found.point, self._walls.body[found.secondary])
        mine = self._row(self.point, self.bodies)
        order = np.argsort(row)
        held = np.flatnonzero(np.isin(mine, row))
        place = order[np.searchsorted(row[order], mine[held])]
        near = (found.secondary[place, None] == self.edges[held]).any(1)
        others = np.ones(len(row), dtype=bool)
        others[place[near]] = False
        point, edges = self.point[held[near]], self.edges[held[near]]
        number = np.concatenate([point, point + len(self._points.facet)])
        return joined([found.chosen(others), self._with(number, np.tile(point, 2), edges.T.ravel(), nodes)])

    def held(self, pairs: ContactPairs) -> Index:
        """Return which pairs are those of held points, from what `pairs` has returned."""
        second = int((pairs.point >= len(self._points.facet)).sum())
        return np.arange(len(pairs) - 2 * second, len(pairs))

    def _row(self, point: Index, body: Index) -> Index:
        return point * self._bodies + body

    def _with(self, number: Index, point: Index, edge: Index, nodes: Array) -> ContactPairs:
        walls, facet, own = self._walls, self._points.facet[point], self._points.xi[point]
        xi = np.zeros_like(own)
        if len(point):
            assert isinstance(walls, EdgeSurface)
            xi, _ = closest_points(walls, nodes, edge, walls.places(facet, own, nodes))
        found = feet(facet, own, np.zeros(len(point)), edge, xi)
        return ContactPairs(number, *list(vars(found).values())[1:])

    def found(self, row: Index, point: Index, edge: Index, positions: Array) -> bool:
        """Take up points that have gone to and fro over the joint of a notch, and tell whether there are any.

        Parameters
        ----------
        row, point, edge : array of int, shape (m,)
            Numbers of conditions that press, their points, and the edges with the closest points.
        """
        if self._beside is None:
            return False
        last, before = self._visited[row].T
        moved = edge != last
        self._visited[row[moved]] = np.column_stack([edge, last])[moved]
        back = np.flatnonzero(moved & (edge == before))
        back = back[self._meet_in_notch(edge[back], last[back], positions)]
        self.point = np.concatenate([self.point, point[back]])
        self.edges = np.concatenate([self.edges, np.column_stack([edge, last])[back]])
        return len(back) > 0

    def left(self, far: Mask, pressed: Array, positions: Array) -> Mask:
        """Release points that are far, or that one edge alone would hold, and return which these were.

        `pressed` has the pressures of both edges over the stiffness of their penalty terms [length], shape (n, 2): by
        less than that the gap to the other edge has to be larger for this edge to count.
        """
        apart = np.abs(np.subtract(*(self._gaps(edge, positions) for edge in self.edges.T)))
        alone = (pressed.min(1, initial=np.inf) <= 0) & (apart >= pressed.max(1, initial=0.0))
        is_left = far | alone | ~self._meet_in_notch(self.edges[:, 0], self.edges[:, 1], positions)
        self.point, self.edges = self.point[~is_left], self.edges[~is_left]
        return np.asarray(is_left)

    def _gaps(self, edge: Index, positions: Array) -> Array:
        pairs = self._with(self.point, self.point, edge, self._walls.nodes(positions))
        return extended(self._walls, pairs, positions, np.arange(len(pairs))).gaps(positions)

    def _meet_in_notch(self, one: Index, two: Index, positions: Array) -> Mask:
        """Return whether edges meet at a concave joint."""
        assert self._beside is not None
        angle = self._walls.exterior_angle_at(self._walls.nodes(positions))[one]
        return np.asarray(((self._beside[one] == two[:, None]) & (angle < -BLUNT)).any(1))


def extended(walls: Surface, pairs: ContactPairs, positions: Array, held: Index) -> GapKinematics:
    """Return the kinematics of pairs; edges of those that are held go on along the tangents at their ends."""
    kinematics = gap_kinematics(walls, pairs, positions)
    if len(held):
        xi = pairs.secondary_xi[held]
        kinematics.correction[held[(xi <= 0) | (xi >= 1)]] = 0.0
    return kinematics


def _beside(walls: EdgeSurface) -> Index:
    """Return the edge that follows at the start and at the end of each edge, -1 for none; shape (edges, 2)."""
    vertex = walls.vertices.ravel()
    order = np.argsort(vertex, kind="stable")
    same = np.flatnonzero(np.diff(vertex[order]) == 0)
    one, two = order[same], order[same + 1]
    beside = np.full(len(vertex), -1)
    beside[one], beside[two] = two // 2, one // 2
    return beside.reshape(-1, 2)
