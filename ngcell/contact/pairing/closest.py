"""The closest point of a curved face: Newton's method on the squared distance, kept inside the face.

Each step minimises the quadratic model over the unit triangle or square, which is exact in a plane: its minimum lies
inside, or on one of the sides.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.walls import Walls

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_STEPS = 6
#: Change of coordinates below which a projection has settled.
_SETTLED = 1e-13
#: Share of a face by which a foot may miss stationarity, and a point a side: round-off of the projection, no more.
_TOLERANCE = 1e-8


def nearest_candidates(walls: Walls, nodes: Array, group: Index, other: Index, point: Array, reach: float) -> Index:
    """Return the candidates that may hold the nearest point of the same body, by balls and boxes around faces.

    Parameters
    ----------
    walls : Walls
        The walls.
    nodes : array of float, shape (faces, nodes, 3)
        Deformed positions of their nodes [length].
    group, other : array of int, shape (candidates,)
        Number of the point, and face.
    point : array of float, shape (candidates, 3)
        The points [length].
    reach : float
        Distance beyond which nothing is a candidate [length].
    """
    low, high = nodes.min(1), nodes.max(1)
    # Polynomials leave the box of their nodes by little.
    reaching = np.abs(walls.domains - walls.basis.corners).max((1, 2)) + (0.1 if walls.basis.order > 1 else 0.0)
    spare = reaching * np.linalg.norm(high - low, axis=1)
    outside = np.maximum(np.maximum(low[other] - point, point - high[other]), 0)
    least = np.maximum(np.linalg.norm(outside, axis=1) - spare[other], 0)
    near = np.flatnonzero(least < reach)
    _, member = np.unique(group[near] * (walls.body.max() + 1) + walls.body[other[near]], return_inverse=True)
    member, bodies = member.ravel(), int(member.max(initial=-1)) + 1
    centre = walls.basis.values(walls.basis.centre[None])[0] @ nodes
    for most in (centre[:, None], nodes):
        place = most[other[near]]
        bound = np.full(bodies, np.inf)
        np.minimum.at(bound, member, np.linalg.norm(place - point[near, None], axis=2).min(1))
        kept = least[near] <= bound[member] * (1 + 1e-9)
        near, member = near[kept], member[kept]
    return near


def closest_on_faces(walls: Walls, nodes: Array, face: Index, point: Array) -> tuple[Array, Array]:
    """Return coordinates, (n, 2), and distance of the closest points on curved faces.

    Parameters
    ----------
    nodes : array of float, shape (n, nodes, 3)
        Deformed nodes of the face of each point [length].
    face : array of int, shape (n,)
        Number of this face.
    point : array of float, shape (n, 3)
        The points [length].
    """
    basis, corners = walls.basis, walls.domains[face]
    lattice = np.linalg.norm(nodes - point[:, None], axis=2).argmin(1)
    xi = basis.nodes[lattice]
    moving = np.arange(len(point))
    for _ in range(_STEPS if len(point) else 0):
        after = _improved(walls, nodes[moving], corners[moving], point[moving], xi[moving])
        change = np.abs(after - xi[moving]).max(1)
        xi[moving] = after
        moving = moving[change > _SETTLED]
    position = np.einsum("pi,pid->pd", basis.values(xi), nodes)
    return xi, np.linalg.norm(point - position, axis=1)


def classified(walls: Walls, nodes: Array, face: Index, xi: Array, point: Array) -> tuple[Array, ...]:
    """Tell feet from points on sides and at corners.

    Parameters
    ----------
    face : array of int, shape (n,)
        Faces.
    xi : array of float, shape (n, 2)
        Closest points on them.
    point : array of float, shape (n, 3)
        The points that these are closest to [length].

    Returns
    -------
    at_end : array of bool, shape (n,)
        Whether the closest point is no foot of a normal.
    glide : array of float, shape (n, 2)
        Direction in which it may slide along a side; 0 at corners and feet.
    sign : array of float, shape (n,)
        +1 outside the body, -1 inside.
    slid_past : array of bool, shape (n,)
        Whether the point lies behind the face, and further aside than deep, where the walls end.
    """
    basis, mine = walls.basis, nodes[face]
    one, two = (np.einsum("pi,pid->pd", basis.values(xi, along), mine) for along in ((1, 0), (0, 1)))
    away = point - np.einsum("pi,pid->pd", basis.values(xi), mine)
    normal = np.cross(one, two) * walls.side[face, None]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = np.einsum("pd,pd->p", away, normal)
    aside = np.linalg.norm(away - height[:, None] * normal, axis=1)
    size = np.sqrt(np.linalg.norm(np.cross(one, two), axis=1))
    on_side, along = _sides(walls.domains[face], xi), np.roll(basis.corners, -1, axis=0) - basis.corners
    at_end = (aside > _TOLERANCE * size) & on_side.any(1)
    glide, is_loose = np.zeros_like(xi), np.zeros(len(face), dtype=bool)
    loose = walls.loose_sides[face]
    for side, direction in enumerate(along):
        tangent = one * direction[0] + two * direction[1]
        slope = np.einsum("pd,pd->p", away, tangent) / np.einsum("pd,pd->p", tangent, tangent)
        here = on_side[:, side]
        glide[at_end & here & (np.abs(slope) < _TOLERANCE)] = direction
        is_loose |= here & loose[:, side]
    slid_past = at_end & is_loose & (height < 0) & (aside > np.abs(height))
    return at_end, glide, np.where(height < 0, -1.0, 1.0), slid_past


def _improved(walls: Walls, nodes: Array, corners: Array, point: Array, xi: Array) -> Array:
    """Return the minimum of the quadratic model of half of the squared distance over the unit face."""
    value, one, two, bend_one, mixed, bend_two = (
        np.einsum("pi,pid->pd", walls.basis.values(xi, degree), nodes)
        for degree in ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    )
    away = point - value
    gradient = -np.stack([np.einsum("pd,pd->p", away, tangent) for tangent in (one, two)], axis=1)
    metric = np.einsum("pad,pbd->pab", *[np.stack([one, two], axis=1)] * 2)
    curved = np.einsum("pd,pabd->pab", away, np.stack([bend_one, mixed, mixed, bend_two], axis=1).reshape(-1, 2, 2, 3))
    hesse = metric - curved
    # Far from the face, or beyond a centre of curvature, the model is that of a plane.
    convex = (hesse[:, 0, 0] > 0.1 * metric[:, 0, 0]) & (np.linalg.det(hesse) > 0.1 * np.linalg.det(metric))
    hesse = np.where(convex[:, None, None], hesse, metric)
    return _smallest_inside(corners, hesse, gradient - np.einsum("pab,pb->pa", hesse, xi))


def _smallest_inside(corners: Array, hesse: Array, gradient: Array) -> Array:
    """Return where ``x hesse x / 2 + gradient x`` is smallest in convex polygons, shape (n, 2)."""
    best = -np.linalg.solve(hesse, gradient[..., None])[..., 0]
    out = np.flatnonzero((_heights(corners, best) < 0).any(1))
    if not len(out):
        return best
    corners, hesse, gradient = corners[out], hesse[out], gradient[out]
    ahead = np.roll(corners, -1, axis=1) - corners
    slope = np.einsum("psa,pab,psb->ps", corners, hesse, ahead) + np.einsum("pa,psa->ps", gradient, ahead)
    share = np.clip(-slope / np.einsum("psa,pab,psb->ps", ahead, hesse, ahead), 0, 1)
    trial = corners + share[..., None] * ahead
    value = np.einsum("psa,pab,psb->ps", trial, hesse, trial) / 2 + np.einsum("psa,pa->ps", trial, gradient)
    best[out] = np.take_along_axis(trial, value.argmin(1)[:, None, None], axis=1)[:, 0]
    return best


def _sides(corners: Array, xi: Array) -> NDArray[np.bool_]:
    """Return which sides of polygons points lie on, shape (n, sides)."""
    return np.asarray(_heights(corners, xi) < _TOLERANCE)


def _heights(corners: Array, xi: Array) -> Array:
    """Return how far points lie inside of the sides of polygons, times their length, shape (n, sides)."""
    ahead, away = np.roll(corners, -1, axis=1) - corners, xi[:, None] - corners
    return np.asarray(ahead[..., 0] * away[..., 1] - ahead[..., 1] * away[..., 0])
