"""The boundaries of lumens in the plane, whose parts may touch each other when a cell collapses.

A lumen is a closed loop of boundary edges around a hole that holds no other body. Which of its edges may touch is
settled at rest. Edges along one smooth piece that are within a wall's thickness of each other never do: the wall
between them would have to fold sharper than it is thick. Those on both sides of a corner do. Where the lumen is not
convex, edges that do not see each other through it are the two sides of a ridge of the wall, and touch neither, unless
they are so far apart that no wall could be squeezed that thin.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.edges import EdgeSurface
from ngcell.geometry.near import near_pairs

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Angle [rad] by which a loop turns where it has a corner.
_CORNER = np.radians(30)
#: Sine of the angle by which an edge may lie behind another one that it sees.
_BEHIND = 0.1
#: Distance at rest, in thicknesses, from which on edges touch that do not see each other at rest.
_FAR = 4.0
#: Way along a lumen, in thicknesses and as a share of the whole way round, from which on two points that get near each
#: other tell that it closes.
_ALONG, _QUARTER = 6.0, 0.25
#: Ways to both sides of a corner, in thicknesses, at which it is seen to close.
_BESIDE = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0)
#: The distance of two points there over the way between them, and over that at rest, below which it closes: at a third
#: of the angle of a hexagon.
_HINGE, _SHUT = 0.3, 0.5
#: Points of a lumen that are looked at for that are this far apart at most, in thicknesses.
_SPACING = 0.5


@dataclass(frozen=True, eq=False)
class LumenSurface(EdgeSurface):
    """The edges around lumens, loop by loop in order; what `Surface` says of bodies holds for loops here.

    Attributes
    ----------
    body_of_loop : array of int, shape (loops,)
        Body around each lumen.
    """

    body_of_loop: Index

    def may_touch(self, one: Index, two: Index) -> NDArray[np.bool_]:
        """Return whether contact acts between edges of each pair: between those of one loop; see the module."""
        same = (self.body[one] == self.body[two]) & (one != two)
        thickness = self.thickness[self.body[one]]
        is_near = (self._piece[one] == self._piece[two]) & (self._way(one, two) < thickness)
        middle, normal = self._at_rest
        away = middle[two] - middle[one]
        distance = np.linalg.norm(away, axis=1)
        ahead = np.minimum(np.einsum("pd,pd->p", normal[one], away), -np.einsum("pd,pd->p", normal[two], away))
        return np.asarray(same & ~is_near & ((ahead > -_BEHIND * distance) | (distance > _FAR * thickness)))

    def points(self, nodes: Array) -> Array:
        """Return points along the lumens, loop by loop, shape (points, 2), at deformed nodes (edges, nodes, 2)."""
        return np.asarray((self.basis.values(self._samples[0]) @ nodes).reshape(-1, 2))

    @cached_property
    def loop_of_point(self) -> Index:
        """Lumen of each of these points, increasing."""
        return np.repeat(self.body, len(self._samples[0]))

    def closing_at_corners(self, points: Array) -> NDArray[np.bool_]:
        """Return which lumens have a corner that closes like a hinge, shape (loops,), where `points` are."""
        one, two, along, at_rest = self._beside_corners
        is_near = np.linalg.norm(points[one] - points[two], axis=1) < np.minimum(_HINGE * along, _SHUT * at_rest)
        return np.bincount(self.loop_of_point[one[is_near]], minlength=len(self.body_of_loop)) > 0

    def room_across(self, points: Array, most: float) -> Array:
        """Return by how much walls far from corners are farther from each other than the thickness, shape (loops,).

        Lumens with more room than `most` [length] have that.
        """
        chosen, thickness = self._evenly, self.thickness
        point, loop, places = points[chosen], self.loop_of_point[chosen], self._samples[1][chosen]
        reach = float(thickness.max()) + most
        side_by_side = np.outer(loop * (np.ptp(point[:, 0]) + 2 * reach), [1.0, 0.0])  # so that no two loops are near
        one, two = near_pairs(point + side_by_side, reach)
        of, along = loop[one], np.abs(places[one] - places[two])
        along = np.minimum(along, self._length[of] - along)
        is_across = along >= np.minimum(_ALONG * thickness[of], _QUARTER * self._length[of])
        one, two, of = one[is_across], two[is_across], of[is_across]
        room = np.full(len(self.body_of_loop), most)
        np.minimum.at(room, of, np.linalg.norm(point[one] - point[two], axis=1) - thickness[of])
        return room

    @cached_property
    def neighbours(self) -> Index:
        """The edges that share the vertex at the start and at the end of each edge, shape (edges, 2)."""
        before, after = self._turned(-1), self._turned(1)
        is_forward = self.side > 0
        return np.column_stack([np.where(is_forward, before, after), np.where(is_forward, after, before)])

    @cached_property
    def _at_rest(self) -> tuple[Array, Array]:
        """Middles [length] and outward normals of the edges at rest, both (edges, 2)."""
        return self.middles(self.rest), self.chord_normals(self.rest)

    def _turned(self, by: int) -> Index:
        """Return the edge that follows each edge in its loop, or that it follows."""
        found = np.arange(self.facet_count)
        for loop in range(len(self.body_of_loop)):
            mine = np.flatnonzero(self.body == loop)
            found[mine] = np.roll(mine, -by)
        return found

    @cached_property
    def _lengths(self) -> Array:
        """Lengths of the edges at rest [length]."""
        return np.asarray(self.weights.sum(1))

    @cached_property
    def _length(self) -> Array:
        """Way around each lumen at rest [length], shape (loops,)."""
        return np.asarray(np.bincount(self.body, self._lengths, len(self.body_of_loop)), dtype=float)

    @cached_property
    def _start(self) -> Array:
        """Way along the loop to where each edge begins [length]."""
        ends = np.cumsum(self._lengths)
        before = np.concatenate([[0.0], np.cumsum(self._length)])[self.body]
        return np.asarray(ends - self._lengths - before)

    @cached_property
    def part(self) -> Index:
        """Sides of the lumens: from one corner of a lumen to the next, ridges of the wall included.

        A point that is pressed between two sides is held by both. Were it held by the nearest one only, the energy
        would jump where the other one comes nearer.
        """
        return self._pieces(self._turn_before < -_CORNER)

    @cached_property
    def _turn_before(self) -> Array:
        """Angle by which the wall turns where each edge begins [rad]: negative where the lumen has a corner."""
        angle = self.exterior_angle
        return np.asarray(np.where(self.side > 0, angle[:, 0], angle[:, 1]))

    @cached_property
    def _has_corner_before(self) -> NDArray[np.bool_]:
        """Whether the loop has a corner where each edge begins."""
        return np.asarray(np.abs(self._turn_before) > _CORNER)

    @cached_property
    def _piece(self) -> Index:
        """Smooth piece of a loop that each edge belongs to."""
        return self._pieces(self._has_corner_before)

    def _pieces(self, begins: NDArray[np.bool_]) -> Index:
        """Return which piece each edge belongs to, if a piece begins with each of these edges."""
        piece = np.cumsum(begins | (np.diff(self.body, prepend=-1) > 0))
        for loop in range(len(self.body_of_loop)):
            mine = np.flatnonzero(self.body == loop)
            if not begins[mine[0]]:
                piece[mine] = np.where(piece[mine] == piece[mine[-1]], piece[mine[0]], piece[mine])
        return np.asarray(piece)

    def _way(self, one: Index, two: Index) -> Array:
        """Return the shorter way along the loop between edges of each pair [length]."""
        first, last = np.minimum(one, two), np.maximum(one, two)
        between = self._start[last] - self._start[first] - self._lengths[first]
        around = self._length[self.body[one]] - between - self._lengths[first] - self._lengths[last]
        return np.asarray(np.minimum(between, around))

    @cached_property
    def _beside_corners(self) -> tuple[Index, Index, Array, Array]:
        """Samples on both sides of each corner, each with each, the ways along the loop between them, and their
        distances at rest [length]."""
        loop, places = self.loop_of_point, self._samples[1]
        pairs = [np.zeros((0, 2), dtype=np.int64)]
        for corner in np.flatnonzero(self._has_corner_before):
            of, around = self.body[corner], self._length[self.body[corner]]
            mine = np.arange(*np.searchsorted(loop, [of, of + 1]))
            ahead = (places[mine] - self._start[corner]) % around
            ways = self.thickness[of] * np.array(_BESIDE)
            after, before = (mine[np.abs(way - ways[:, None]).argmin(1)] for way in (ahead, around - ahead))
            pairs.append(np.stack(np.meshgrid(before, after), axis=-1).reshape(-1, 2))
        one, two = np.concatenate(pairs).T
        along = (places[two] - places[one]) % self._length[loop[one]]
        point = self.points(self.rest)
        return one, two, along, np.linalg.norm(point[one] - point[two], axis=1)

    @cached_property
    def _samples(self) -> tuple[Array, Array]:
        """Coordinates of points on each edge, and the way along the loop to all of them [length]."""
        count = int(np.ceil((self._lengths / (_SPACING * self.thickness[self.body])).max()))
        share = (np.arange(count) + 0.5) / count
        along = np.where(self.side[:, None] > 0, share, 1 - share)
        return share, (self._start[:, None] + along * self._lengths[:, None]).ravel()

    @cached_property
    def _evenly(self) -> Index:
        """Some of these points, no farther apart on short edges than on long ones: increasing numbers."""
        most, needed = len(self._samples[0]), np.ceil(self._lengths / (_SPACING * self.thickness[self.body]))
        rank = (np.arange(most) + 0.5) / needed[:, None]
        edge, _ = np.nonzero(rank < 1)
        return np.asarray(edge * most + (rank[rank < 1] * most).astype(np.int64))
