"""The closest point of curved edges: chords narrow the choice, Newton's method on the squared distance finishes it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.classification import TIE, Classification
from ngcell.contact.pairing.unit_roots import unit_roots
from ngcell.contact.surface.edges import EdgeSurface

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Exterior angle of a joint [rad] below which the distances of its edges may be tied.
BLUNT = 2 * (2 * TIE) ** 0.5
#: Share of an edge beyond which a foot counts as past its end: round-off of the projection, no more.
END_TOLERANCE = 1e-9


def nearest_candidates(
    walls: EdgeSurface, nodes: Array, group: Index, facet: Index, point: Array, reach: float | Array
) -> Index:
    """Return the candidates whose chord is, up to the edge's sagitta, the nearest of the same part."""
    chords = nodes[:, -1] - nodes[:, 0]
    lengths2 = np.einsum("pd,pd->p", chords, chords)
    # Column by column: there are many candidates, and rows of two numbers are slow to gather.
    (x, y), (along, across) = (np.ascontiguousarray(rows.T)[:, facet] for rows in (nodes[:, 0], chords))
    x, y = point[:, 0] - x, point[:, 1] - y
    xi = np.minimum(np.maximum((x * along + y * across) / lengths2[facet], 0), 1)
    x, y = x - xi * along, y - xi * across
    distance = np.sqrt(x * x + y * y)
    sagitta = _sagittas(nodes, lengths2)[facet]
    near = np.flatnonzero(distance < reach + sagitta)
    part, distance, sagitta = walls.part[facet[near]], distance[near], sagitta[near]
    found, member = np.unique(group[near] * (part.max(initial=0) + 1) + part, return_inverse=True)
    bound = np.full(len(found), np.inf)
    np.minimum.at(bound, member, distance + sagitta)
    return np.asarray(near[distance - sagitta <= bound[member]])


def _sagittas(nodes: Array, lengths2: Array) -> Array:
    """Return an upper bound of the distance [length] of each edge from its chord, from squared lengths of chords."""
    detour = 0.5 * np.linalg.norm(np.diff(nodes, axis=1), axis=2).sum(1) - 0.5 * np.sqrt(lengths2)
    return np.asarray(np.sqrt(np.maximum(detour * np.sqrt(lengths2), 0)) * 1.5 + 1e-12 * np.sqrt(lengths2))


def closest_points(walls: EdgeSurface, nodes: Array, facet: Index, point: Array) -> tuple[Array, Array]:
    """Return coordinate and distance of the closest points on curved edges."""
    nodes = nodes[facet]
    chord = nodes[:, -1] - nodes[:, 0]
    xi = np.einsum("pd,pd->p", point - nodes[:, 0], chord) / np.einsum("pd,pd->p", chord, chord)
    xi = np.clip(xi, 0, 1)

    if walls.basis.order > 1:
        curves = walls.basis.by_powers((nodes - point[:, None]).transpose(1, 2, 0))
        xi = unit_roots(_slopes_of_distance(curves), xi)
    position = np.einsum("pi,pid->pd", walls.basis.values(xi), nodes)
    return xi, np.linalg.norm(point - position, axis=1)


def _slopes_of_distance(curves: Array) -> Array:
    """Return half of the derivative of the squared distance from the origin, as polynomials, shape (2 order, n).

    Curves have shape (order + 1, 2, n): factors of the powers of their coordinate.
    """
    order = len(curves) - 1
    products = np.zeros((2 * order, curves.shape[2]))
    for power in range(1, order + 1):
        products[power - 1 : power + order] += power * (curves * curves[power]).sum(1)
    return products


def classified(walls: EdgeSurface, nodes: Array, facet: Index, xi: Array, point: Array) -> Classification:
    """Tell feet of normals from ends of edges."""
    mine = nodes[facet]
    position = np.einsum("pi,pid->pd", walls.basis.values(xi), mine)
    slope = np.einsum("pi,pid->pd", walls.basis.values(xi, 1), mine)
    speed2 = np.einsum("pd,pd->p", slope, slope)
    away = point - position
    aside = np.einsum("pd,pd->p", away, slope) / speed2
    height = walls.side[facet] * (away[:, 0] * slope[:, 1] - away[:, 1] * slope[:, 0]) / speed2
    at_end = (np.abs(aside) > END_TOLERANCE) & ((xi <= 0) | (xi >= 1))  # between ends it is round-off of small edges
    is_loose = np.where(xi < 0.5, walls.is_loose_end[facet, 0], walls.is_loose_end[facet, 1])
    slid_past = at_end & is_loose & (height < 0) & (np.abs(aside) > np.abs(height))
    sign = np.where(height < 0, -1.0, 1.0)
    doubtful = np.flatnonzero(at_end & ~is_loose & (height < 0))
    if len(doubtful):
        # The nearest point of a body is a convex corner only for points outside, however the corner's edges bend.
        exterior_angle = walls.exterior_angle_at(nodes)[facet[doubtful], (xi[doubtful] >= 0.5).astype(int)]
        sign[doubtful[exterior_angle > BLUNT]] = 1.0
    return Classification(at_end, sign, np.zeros((len(facet), 0)), slid_past)
