"""Which walls face each other at rest, and the gap between them afterwards.

Facing walls are found from the reference geometry: a facet faces another body if it touches it, or nearly so, with
opposite normals. Where two user-defined bodies touch nowhere, since they are apart at rest or overlap like those of a
press-fit, the facets are those that are within reach of the other body, on either side of its walls. How much a point
counts falls with its distance at rest. The gap of a
facing wall is measured from each of its quadrature points to the nearest point of the other body's walls, wherever that
has slid, so a parted pair keeps a gap however far it is apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.near import Reach, facing, near_facets
from ngcell.contact.pairing.search import nearest_on_body
from ngcell.contact.surface.surface import Surface, SurfacePoints
from ngcell.geometry.near import components, near_pairs, ranges

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of the shortest facet within which corners are the same.
_SAME = 1e-4
#: Two facets touch face to face if their normals differ from opposite by less than about 25 degrees.
_OPPOSITE = -0.9
#: Share of the distance up to which facets face each other, within which their middles touch.
_TOUCHING = 1e-6
#: Parts into which facets that do not touch are divided: with four, means of a half-cylinder's gaps on elements of
#: one and two times the size, of order 2 to 6, agree to 0.2 %.
_PARTS = 4
#: Share of the wall's thickness by which a facet is moved to see whether it comes nearer.
_PROBE = 1e-5
#: Share of the middle half of a wall, at its ends, whose points do not count: round-off would decide where they lie.
_BORDER = 1e-6


@dataclass(frozen=True, eq=False)
class FacingWalls:
    """Pairs of facing walls and the quadrature points on them.

    Attributes
    ----------
    pairs : array of int, shape (pairs, 2)
        The two bodies of each pair, the lower number first.
    thickness : array of float, shape (pairs,)
        Thickness of the thinner body of each pair [length].
    pair : array of int, shape (points,)
        Pair that each point belongs to; every wall contributes its own points.
    facet : array of int, shape (points,)
        Facet.
    xi : array of float, shape (points,), on faces (points, 2)
        Coordinates on it.
    other : array of int, shape (points,)
        Body that the point faces.
    weight : array of float, shape (points,)
        Quadrature weight [length], on faces [length**2], times the share by which the point counts: 1 where walls
        touch, 0 where they are too far to face each other.
    is_middle : array of bool, shape (points,)
        Whether the point lies in the middle half of its wall.
    """

    pairs: Index
    thickness: Array
    pair: Index
    facet: Index
    xi: Array
    other: Index
    weight: Array
    is_middle: NDArray[np.bool_]

    def gaps(self, walls: Surface, nodes: Array) -> Array:
        """Return the gap of each point [length], open > 0, at the walls' deformed nodes."""
        return nearest_on_body(walls, nodes, walls.places(self.facet, self.xi, nodes), self.other)

    def between_held(self, free_bodies: Sequence[int]) -> NDArray[np.bool_]:
        """Return which points are on walls between bodies that something holds, shape (points,)."""
        is_held = ~np.isin(self.pairs, np.asarray(free_bodies)).any(axis=1)
        return np.asarray(np.atleast_1d(is_held)[self.pair])


def find_facing(walls: Surface, tolerance: Reach, reach: Reach = 0.0) -> FacingWalls:
    """Find the walls that face each other at rest.

    Parameters
    ----------
    walls : Surface
        The walls.
    tolerance : float or array of float, shape (bodies,)
        Distance up to which points touch [length]; of two bodies the smaller counts.
    reach : float or array of float, shape (bodies,)
        Distance, or depth, up to which points of bodies that touch nowhere face each other [length].
    """
    touching = _facing_ahead(walls, _within(walls, tolerance))
    further = _within(walls, reach) if np.max(reach) > np.min(tolerance) else touching.chosen(slice(0))
    count = int(walls.body.max(initial=0)) + 1
    known = np.isin(further.bodies(walls) @ [count, 1], touching.bodies(walls) @ [count, 1])
    found = touching.joined(further.chosen(~known))
    pairs, pair = np.unique(found.bodies(walls), axis=0, return_inverse=True)
    pair = pair.ravel()
    place = walls.places(found.facet, found.xi, walls.rest)
    is_middle = _in_middle_half(2 * pair + (walls.body[found.facet] > found.other), place)
    thickness = walls.thickness[pairs].min(1)
    return FacingWalls(pairs, thickness, pair, found.facet, found.xi, found.other, found.weight, is_middle)


@dataclass(frozen=True, eq=False)
class _Points:
    """Points of facets, and the bodies that they face; attributes as for `FacingWalls`."""

    facet: Index
    xi: Array
    other: Index
    weight: Array

    def chosen(self, which: Any) -> _Points:
        return _Points(self.facet[which], self.xi[which], self.other[which], self.weight[which])

    def joined(self, others: _Points) -> _Points:
        mine, theirs = ((one.facet, one.xi, one.other, one.weight) for one in (self, others))
        return _Points(*(np.concatenate(both) for both in zip(mine, theirs, strict=True)))

    def bodies(self, walls: Surface) -> Index:
        """Return the two bodies of each point, the lower number first, shape (points, 2)."""
        return np.sort(np.column_stack([walls.body[self.facet], self.other]), axis=1)


def _within(walls: Surface, distance: Reach) -> _Points:
    """Return the points that face a body up to a distance [length] on either side.

    Facets whose middle touches are taken as a whole. On others the weight of a point falls with the square of its
    distance, to 0 where it is too far, and the rule is finer: neither a sharp end nor a weight whose slope jumps
    within a facet may lie elsewhere with other elements.
    """
    one, two = near_facets(walls, walls.rest, distance)
    opposite = facing(walls, walls.rest, one, two, _OPPOSITE)
    of_body = np.broadcast_to(distance, walls.thickness.shape)
    facet, body = np.unique(np.column_stack([one, walls.body[two]])[opposite], axis=0).T
    limit = np.minimum(of_body[walls.body[facet]], of_body[body])
    away = np.abs(nearest_on_body(walls, walls.rest, walls.centres(walls.rest)[facet], body))
    touches = away <= _TOUCHING * limit
    whole = _rows_on(walls.quadrature, facet[touches], body[touches])
    ahead = ~touches & ((away <= limit) | ~np.isin(facet, facet[touches]))  # behind what touches lies no other
    finer = walls.divided(_PARTS) if ahead.any() else walls.quadrature
    part = _rows_on(finer, facet[ahead], body[ahead])
    gap = nearest_on_body(walls, walls.rest, walls.places(part.facet, part.xi, walls.rest), part.other)
    of_points = np.minimum(of_body[walls.body[part.facet]], of_body[part.other])
    weight = part.weight * np.maximum(1 - (gap / of_points) ** 2, 0)
    return whole.joined(replace(part, weight=weight).chosen(weight > 0))


def _rows_on(rule: SurfacePoints, facet: Index, other: Index) -> _Points:
    """Return the points of a rule on facets, which face other bodies, both (rows,)."""
    first, end = (np.searchsorted(rule.facet, facet, side=side) for side in ("left", "right"))
    row, point = ranges(np.arange(len(facet)), first, end)
    return _Points(facet[row], rule.xi[point], other[row], rule.weight[point])


def _facing_ahead(walls: Surface, found: _Points) -> _Points:
    """Return the points whose facet comes nearer to the body along its own normal.

    Where four cells meet, facets next to the corner that are shorter than the tolerance touch the cell across, too; but
    that one lies beside them.
    """
    rows, back = np.unique(np.column_stack([found.facet, found.other]), axis=0, return_inverse=True)
    facet, body = rows.T
    centre, normal = walls.centres(walls.rest)[facet], walls.chord_normals(walls.rest)[facet]
    step = _PROBE * walls.thickness[walls.body[facet]]
    gap, ahead = (nearest_on_body(walls, walls.rest, centre + by[:, None] * normal, body) for by in (0 * step, step))
    return found.chosen((gap - ahead > step / 2)[back.ravel()])


def count_corners(walls: Surface) -> int:
    """Return the number of places where walls of three bodies or more meet at rest."""
    corners = walls.basis.corner_nodes
    ends = walls.rest[:, corners].reshape(-1, walls.dimension)
    body = np.repeat(walls.body, len(corners))
    if not len(ends):
        return 0
    place = components(len(ends), *near_pairs(ends, _SAME * float(walls.sizes.min())))
    meeting = np.unique(np.column_stack([place, body]), axis=0)
    return int((np.bincount(meeting[:, 0]) >= 3).sum())


def _in_middle_half(wall: Index, point: Array) -> NDArray[np.bool_]:
    """Return which points lie in the middle half of their wall, measured along its longest direction."""
    inside = np.zeros(len(wall), dtype=bool)
    for number in np.unique(wall):
        mine = np.flatnonzero(wall == number)
        away = point[mine] - point[mine].mean(0)
        along = away @ np.linalg.svd(away, full_matrices=False)[2][0]
        low, high = along.min(), along.max()
        inside[mine] = np.abs(along - (low + high) / 2) < (1 - _BORDER) * (high - low) / 4
    return inside
