"""The closest point of a curved facet: Newton's method on the squared distance, kept inside the facet.

Each step minimises the quadratic model over the unit triangle or square, which is exact in a plane: its minimum lies
inside, or on one of the sides.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.classification import Classification
from ngcell.contact.surface.facets import FacetSurface

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_STEPS = 60
#: Change of coordinates below which a projection has settled.
_SETTLED = 1e-13
#: Share of a facet by which a foot may miss stationarity, and a point a side: round-off of the projection, no more.
_TOLERANCE = 1e-8


def nearest_candidates(
    walls: FacetSurface, nodes: Array, group: Index, facet: Index, point: Array, reach: float | Array
) -> Index:
    """Return the candidates that may hold the nearest point of the same body, by balls and boxes around facets."""
    low, high = nodes.min(1), nodes.max(1)
    # Polynomials leave the box of their nodes by little.
    reaching = np.abs(walls.domains - walls.basis.corners).max((1, 2)) + (0.1 if walls.basis.order > 1 else 0.0)
    spare = reaching * np.linalg.norm(high - low, axis=1)
    outside = np.maximum(np.maximum(low[facet] - point, point - high[facet]), 0)
    least = np.maximum(np.linalg.norm(outside, axis=1) - spare[facet], 0)
    near = np.flatnonzero(least < reach)
    _, member = np.unique(group[near] * (walls.body.max(initial=0) + 1) + walls.body[facet[near]], return_inverse=True)
    member, bodies = member.ravel(), int(member.max(initial=-1)) + 1
    for most in (walls.centres(nodes)[:, None], nodes):
        place = most[facet[near]]
        bound = np.full(bodies, np.inf)
        np.minimum.at(bound, member, np.linalg.norm(place - point[near, None], axis=2).min(1))
        kept = least[near] <= bound[member] * (1 + 1e-9)
        near, member = near[kept], member[kept]
    return near


def closest_points(walls: FacetSurface, nodes: Array, facet: Index, point: Array) -> tuple[Array, Array]:
    """Return coordinates, (n, 2), and distance of the closest points on curved facets."""
    basis, corners, nodes = walls.basis, walls.domains[facet], nodes[facet]
    lattice = np.linalg.norm(nodes - point[:, None], axis=2).argmin(1)
    xi = basis.nodes[lattice]
    moving = np.arange(len(point))
    for _ in range(_STEPS):
        if not len(moving):
            break
        after = _improved(walls, nodes[moving], corners[moving], point[moving], xi[moving])
        change = np.abs(after - xi[moving]).max(1)
        xi[moving] = after
        moving = moving[change > _SETTLED]
    position = np.einsum("pi,pid->pd", basis.values(xi), nodes)
    return xi, np.linalg.norm(point - position, axis=1)


def classified(walls: FacetSurface, nodes: Array, facet: Index, xi: Array, point: Array) -> Classification:
    """Tell feet of normals from points on sides and at corners."""
    basis = walls.basis
    one, two = walls.tangents(facet, xi, nodes)
    away = point - walls.places(facet, xi, nodes)
    normal = np.cross(one, two) * walls.side[facet, None]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = np.einsum("pd,pd->p", away, normal)
    aside = np.linalg.norm(away - height[:, None] * normal, axis=1)
    size = np.sqrt(np.linalg.norm(np.cross(one, two), axis=1))
    on_side, along = _sides(walls.domains[facet], xi), np.roll(basis.corners, -1, axis=0) - basis.corners
    at_end = (aside > _TOLERANCE * size) & on_side.any(1)
    slide_direction, is_loose = np.zeros_like(xi), np.zeros(len(facet), dtype=bool)
    loose = walls.is_loose_side[facet]
    for side, direction in enumerate(along):
        tangent = one * direction[0] + two * direction[1]
        slope = np.einsum("pd,pd->p", away, tangent) / np.einsum("pd,pd->p", tangent, tangent)
        on_this = on_side[:, side]
        slide_direction[at_end & on_this & (np.abs(slope) < _TOLERANCE)] = direction
        is_loose |= on_this & loose[:, side]
    slid_past = at_end & is_loose & (height < 0) & (aside > np.abs(height))
    return Classification(at_end, np.where(height < 0, -1.0, 1.0), slide_direction, slid_past)


def _improved(walls: FacetSurface, nodes: Array, corners: Array, point: Array, xi: Array) -> Array:
    """Return the minimum of the quadratic model of half of the squared distance over the unit facet."""
    value, one, two, bend_one, mixed, bend_two = (
        np.einsum("pi,pid->pd", walls.basis.values(xi, degree), nodes)
        for degree in ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    )
    away = point - value
    gradient = -np.stack([np.einsum("pd,pd->p", away, tangent) for tangent in (one, two)], axis=1)
    metric = np.einsum("pad,pbd->pab", *[np.stack([one, two], axis=1)] * 2)
    curved = np.einsum("pd,pabd->pab", away, np.stack([bend_one, mixed, mixed, bend_two], axis=1).reshape(-1, 2, 2, 3))
    hesse = metric - curved
    # Far from the facet, or beyond a centre of curvature, the model is that of a plane.
    convex = (hesse[:, 0, 0] > 0.1 * metric[:, 0, 0]) & (np.linalg.det(hesse) > 0.1 * np.linalg.det(metric))
    hesse = np.where(convex[:, None, None], hesse, metric)
    return _smallest_inside(corners, hesse, gradient - np.einsum("pab,pb->pa", hesse, xi))


def _smallest_inside(corners: Array, hesse: Array, gradient: Array) -> Array:
    """Return where ``x hesse x / 2 + gradient x`` is smallest in convex polygons, shape (n, 2)."""
    best = np.asarray(-np.linalg.solve(hesse, gradient[..., None])[..., 0], dtype=np.float64)
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
