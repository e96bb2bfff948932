"""Which parts of a lumen are near each other.

A point looks for the nearest point on each side of its own lumen, on edges that it may touch. Where these end, next to
edges that it may not touch, the nearest point is an end of what was looked at and no contact; it is left out. So is a
corner that is the nearest point of one side, unless it is that of both sides that meet there: then one of them has it.
As long as a lumen is open, nothing is looked for in it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.near import Reach, near_facets
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.pairing.search import PairSearch
from ngcell.contact.surface.lumens import LumenSurface
from ngcell.contact.surface.surface import SurfacePoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Distances change by up to this much where coordinates of two points change by half of 1 each.
_DIAGONAL = np.sqrt(2.0)
#: Room up to which it is measured, in thicknesses: nobody looks again before a shape changes by half of it.
_AHEAD = 1.5
#: Coordinate up to which a point is the end of its edge: round-off of the projection, no more.
_END = 1e-9


class Closing:
    """Tells which lumens close, and looks again only where one has changed its shape.

    Parameters
    ----------
    lumens : LumenSurface
        The lumens.

    Attributes
    ----------
    surface : LumenSurface
        The lumens.
    """

    def __init__(self, lumens: LumenSurface) -> None:
        self.surface, self._ahead = lumens, _AHEAD * float(lumens.thickness.max())
        self._seen: tuple[Array, Array] | None = None

    def lumens(self, nodes: Array, reach: float = 0.0) -> NDArray[np.bool_]:
        """Return which lumens close: at a corner, or where walls are nearer than the thickness and `reach` [length].

        `nodes` are deformed positions of shape (edges, nodes, 2); the result has shape (loops,).
        """
        points = self.surface.points(nodes)
        room = self._least_room(points)
        if (room <= reach).any():
            room = self.surface.room_across(points, max(self._ahead, reach))
            self._seen = points, room
        return (room < reach) | self.surface.closing_at_corners(points)

    def _least_room(self, points: Array) -> Array:
        """Return how much room is left across lumens at least, shape (loops,) [length]: none where nobody has looked.

        Walls come nearer to each other by no more than two points change the shape of their lumen.
        """
        if self._seen is None:
            return np.full(len(self.surface.body_of_loop), -np.inf)
        before, room = self._seen
        return room - 2 * _change_of_shape(before, points, self.surface.loop_of_point)


class LumenSearch(PairSearch):
    """The search for closest points of the same lumen; parameters as for `PairSearch`, with what tells which close."""

    def __init__(self, closing: Closing, points: SurfacePoints, reach: Reach) -> None:
        super().__init__(closing.surface, points, reach)
        self._lumens, self._closing = closing.surface, closing

    def pairs(self, nodes: Array) -> ContactPairs:
        """Return all contact pairs of a deformed state."""
        pairs, lumens = super().pairs(nodes), self._lumens
        xi, part = pairs.secondary_xi, lumens.part
        beside = lumens.neighbours[pairs.secondary, (xi >= 0.5).astype(int)]
        is_end = np.minimum(xi, 1 - xi) < _END
        beside = np.where(is_end, beside, pairs.secondary)
        is_corner = part[beside] != part[pairs.secondary]
        left_out = is_end & (~lumens.may_touch(pairs.primary, beside) | (is_corner & ~_shared(pairs, beside, part)))
        return pairs.chosen(self._closing.lumens(nodes)[lumens.body[pairs.primary]] & ~left_out)


def _shared(pairs: ContactPairs, beside: Index, part: Index) -> NDArray[np.bool_]:
    """Return which pairs, at an end next to the edge `beside`, have that end for the nearest point of the part beyond
    it, too; of the two pairs only the one with the lower part."""
    mine, beyond = part[pairs.secondary], part[beside]
    first = pairs.point * (int(part.max(initial=0)) + 1)
    key, wanted = first + mine, first + beyond
    order = np.argsort(key)
    other = order[np.minimum(np.searchsorted(key, wanted, sorter=order), max(len(order) - 1, 0))]
    is_there = key[other] == wanted
    same = (pairs.secondary[other] == beside) & (beside[other] == pairs.secondary)
    return np.asarray(is_there & same & (mine < beyond))


def near_in_closing(closing: Closing, nodes: Array, reach: Reach, margin: float) -> tuple[Index, Index]:
    """Return ordered pairs of edges nearer than reach and margin [length], in lumens that may close within the margin.

    Corners are seen as they close, and not before.
    """
    closes = closing.lumens(nodes, _DIAGONAL * margin)
    if not closes.any():
        nothing = np.zeros(0, dtype=np.int64)
        return nothing, nothing
    one, two = near_facets(closing.surface, nodes, reach + margin)
    is_near = closes[closing.surface.body[one]]
    return one[is_near], two[is_near]


def _change_of_shape(before: Array, after: Array, loop: Index) -> Array:
    """Return the largest way of a point of each loop beside a motion of the rigid loop, shape (loops,) [length]."""
    start = np.flatnonzero(np.diff(loop, prepend=-1))
    count = np.diff(start, append=len(loop))
    one, two = (points @ np.array([1.0, 1.0j]) for points in (before, after))
    one, two = (point - np.repeat(np.add.reduceat(point, start) / count, count) for point in (one, two))
    turn = np.add.reduceat(one.conj() * two, start)
    size = np.abs(turn)
    turn = np.where(size > 0, turn, 1.0) / np.where(size > 0, size, 1.0)
    return np.asarray(np.maximum.reduceat(np.abs(two - np.repeat(turn, count) * one), start))
