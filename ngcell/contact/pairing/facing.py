"""Which walls face each other at rest, and the gap between them afterwards.

Facing walls are found from the reference geometry: an edge faces another body if it touches it, or nearly so, with
opposite normals. The gap of a facing wall is measured from each of its quadrature points to the nearest point of the
other body's walls, wherever that has slid, so a parted pair keeps a gap however far it is apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.search import near_edges, nearest_on_body
from ngcell.contact.surface.walls import Walls

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Two edges face each other if their normals differ from opposite by less than about 25 degrees.
_OPPOSITE = -0.9


@dataclass(frozen=True, eq=False)
class FacingWalls:
    """Pairs of facing walls and the quadrature points on them.

    Attributes
    ----------
    pairs : array of int, shape (pairs, 2)
        The two bodies of each pair, the lower number first.
    pair : array of int, shape (points,)
        Pair that each point belongs to; every wall contributes its own points.
    edge, quadrature point : array of int, shape (points,)
        Edge and quadrature point.
    other : array of int, shape (points,)
        Body that the point faces.
    weight : array of float, shape (points,)
        Quadrature weight [length], in three dimensions [length**2].
    is_middle : array of bool, shape (points,)
        Whether the point lies in the middle half of its wall.
    """

    pairs: Index
    pair: Index
    edge: Index
    quadrature_point: Index
    other: Index
    weight: Array
    is_middle: NDArray[np.bool_]

    def gaps(self, walls: Walls, nodes: Array) -> Array:
        """Return the gap of each point [length], open > 0, at the walls' deformed nodes."""
        point = (walls.quadrature_values @ nodes)[self.edge, self.quadrature_point]
        return nearest_on_body(walls, nodes, point, self.other)


def find_facing(walls: Walls, tolerance: float) -> FacingWalls:
    """Find the walls that face each other at rest within `tolerance` [length]."""
    one, two = near_edges(walls, walls.rest, tolerance)
    normal = walls.chord_normals(walls.rest)
    opposite = np.einsum("ed,ed->e", normal[one], normal[two]) < _OPPOSITE
    middle = walls.basis.values(walls.basis.centre[None])[0] @ walls.rest
    edges = np.unique(np.column_stack([one, walls.body[two]])[opposite], axis=0)
    edge, other = edges.T
    gap = nearest_on_body(walls, walls.rest, middle[edge], other)
    edge, other = edge[np.abs(gap) <= tolerance], other[np.abs(gap) <= tolerance]
    bodies = np.sort(np.column_stack([walls.body[edge], other]), axis=1)
    pairs, pair = np.unique(bodies, axis=0, return_inverse=True)
    count = len(walls.quadrature_points)
    edge, other, pair = (np.repeat(array, count) for array in (edge, other, pair.ravel()))
    quadrature_point = np.tile(np.arange(count), len(edge) // count)
    point = (walls.quadrature_values @ walls.rest)[edge, quadrature_point]
    is_middle = _in_middle_half(2 * pair + (walls.body[edge] > other), point)
    weight = walls.weights[edge, quadrature_point]
    parts = (part[weight != 0] for part in (pair, edge, quadrature_point, other, weight, is_middle))
    return FacingWalls(pairs, *parts)


def count_corners(walls: Walls) -> int:
    """Return the number of places where walls of three bodies or more meet at rest."""
    corners = walls.basis.corner_nodes
    ends = walls.rest[:, corners].reshape(-1, walls.dimension)
    body = np.repeat(walls.body, len(corners))
    scale = np.abs(ends).max()
    _, place = np.unique(np.round(ends / (1e-7 * scale)), axis=0, return_inverse=True)
    meeting = np.unique(np.column_stack([place.ravel(), body]), axis=0)
    return int((np.bincount(meeting[:, 0]) >= 3).sum())


def _in_middle_half(wall: Index, point: Array) -> NDArray[np.bool_]:
    """Return which points lie in the middle half of their wall, measured along its longest direction."""
    inside = np.zeros(len(wall), dtype=bool)
    for number in np.unique(wall):
        mine = np.flatnonzero(wall == number)
        away = point[mine] - point[mine].mean(0)
        along = away @ np.linalg.svd(away, full_matrices=False)[2][0]
        low, high = along.min(), along.max()
        inside[mine] = np.abs(along - (low + high) / 2) <= (high - low) / 4
    return inside
