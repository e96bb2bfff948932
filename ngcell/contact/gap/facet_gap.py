"""The normal gap in three dimensions and its first two derivatives, with contact pairs held fixed.

With ``a`` from the closest secondary point to the primary point, and ``t``, ``t'`` the deformed secondary tangents,

    g = side a . (t x t') / |t x t'| - s . M s / 2,   s = (a . t, a . t')      (foot of a normal on a facet)
    g = sign sqrt(|a|^2 - c (a . t)^2)                                         (foot of a normal on a side)
    g = sign |a|                                                               (corner)

The second terms, with the curvature corrections M and c, are what the wall curves away when the true foot slides. With
the metric G of the tangents, the second derivatives B of the wall along the outward normal, and the gap g, all frozen
where the contact pair was found, ``M = G^-1 B (G - g B)^-1``; with the second derivative t_s of the side's curve,
``c = 1 / (|t|^2 - a . t_s)``. So g and its first two derivatives are those of the distance to the curved wall itself,
as in the plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.surface.facets import FacetSurface

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: ``e_ijk``, +1 for even and -1 for odd permutations.
_PERMUTATION = np.array([[[(i - j) * (j - k) * (k - i) / 2 for k in range(3)] for j in range(3)] for i in range(3)])
#: Share of the metric that stays where contact pairs are about to jump, at a centre of curvature.
_LEAST = 0.1


@dataclass(frozen=True)
class FacetGap:
    """Gaps in three dimensions."""

    at_once: int = 1000

    @property
    def whole(self) -> FacetGap:
        """The distance itself."""
        return self

    def flat(self, count: int) -> Array:
        """Return no curvature corrections, shape (count, 2, 2)."""
        return np.zeros((count, 2, 2))

    def gaps(self, pairs: ContactPairs, side: Array, correction: Array, *vectors: Array) -> Array:
        """Return the gaps."""
        end = pairs.at_end
        gap = np.empty(len(end))
        gap[~end] = _foot_gap(side[~end], correction[~end], *(vector[~end] for vector in vectors))
        gap[end] = pairs.sign[end] * np.sqrt(_square(correction[end, 0, 0], vectors[0][end], vectors[1][end]))
        return gap

    def slopes(self, pairs: ContactPairs, side: Array, correction: Array, gap: Array, *vectors: Array) -> Array:
        """Return the derivatives by the nine components of ``(a, t, t')``."""
        end = pairs.at_end
        slope = np.zeros((len(end), 9))
        slope[~end] = _foot_slope(side[~end], correction[~end], *(vector[~end] for vector in vectors))
        of_square = _square_slope(correction[end, 0, 0], vectors[0][end], vectors[1][end])
        slope[end, :6] = of_square / (2 * gap[end, None])
        return slope

    def curvatures(self, pairs: ContactPairs, chosen: Index, side: Array, correction: Array, *vectors: Array) -> Array:
        """Return the second derivatives of chosen gaps by ``(a, t, t')``, shape (chosen, 9, 9)."""
        end, sign = pairs.at_end[chosen], pairs.sign[chosen]
        block = np.zeros((len(chosen), 9, 9))
        block[~end] = _foot_curvature(side[~end], correction[~end], *(vector[~end] for vector in vectors))
        block[end, :6, :6] = _side_curvature(sign[end], correction[end, 0, 0], vectors[0][end], vectors[1][end])
        return block


def facet_kinematics(walls: FacetSurface, pairs: ContactPairs, positions: Array) -> GapKinematics:
    """Return the kinematics of contact pairs that were found at `positions`, unknowns of shape (3, scalar unknowns)."""
    facet, xi, end = pairs.secondary, pairs.secondary_xi, pairs.at_end
    primary, secondary = walls.trace(pairs.primary, pairs.primary_xi), walls.trace(facet, xi)
    one, two, bend_one, mixed, bend_two = (
        walls.trace(facet, xi, derivative) for derivative in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    )
    along, across = pairs.slide_direction.T[:, :, None]
    second = along**2 * bend_one + 2 * along * across * mixed + across**2 * bend_two
    tangent = np.where(end[:, None], along * one + across * two, one)
    local = positions[:, walls.dofs[facet]]
    bends = np.stack([(local * factors).sum(2).T for factors in (bend_one, mixed, mixed, bend_two)], axis=1)
    offset = np.concatenate([primary, -secondary], axis=1)
    dofs = np.concatenate([walls.dofs[pairs.primary], walls.dofs[facet]], axis=1)
    nothing = np.zeros_like(primary)
    a = (positions[:, dofs] * offset).sum(2).T
    t, t_two = ((local * factors).sum(2).T for factors in (tangent, two))
    side = walls.side[facet]
    correction = FacetGap().flat(len(facet))
    correction[~end] = _correction(a[~end], t[~end], t_two[~end], side[~end], bends[~end].reshape(-1, 2, 2, 3))
    correction[end, 0, 0] = _side_correction(a[end], t[end], (local * second).sum(2).T[end])
    return GapKinematics(
        pairs=pairs,
        gap=FacetGap(),
        dofs=dofs,
        maps=(offset, *(np.concatenate([nothing, factors], axis=1) for factors in (tangent, two))),
        side=side,
        correction=correction,
    )


def _correction(a: Array, t: Array, t_two: Array, side: Array, bends: Array) -> Array:
    """Return ``G^-1 B (G - g B)^-1``; near a singularity, where contact pairs jump, without g."""
    normal = np.cross(t, t_two) * side[:, None]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    tangents = np.stack([t, t_two], axis=1)
    metric = np.einsum("pad,pbd->pab", tangents, tangents)
    bent = np.einsum("pabd,pd->pab", bends, normal)
    gap = np.einsum("pd,pd->p", a, normal)[:, None, None]
    lifted = metric - gap * bent
    safe = (np.linalg.det(lifted) > _LEAST**2 * np.linalg.det(metric)) & (lifted[:, 0, 0] > _LEAST * metric[:, 0, 0])
    lifted = np.where(safe[:, None, None], lifted, metric)
    return np.asarray(np.linalg.solve(metric, bent) @ np.linalg.inv(lifted))


def _side_correction(a: Array, t: Array, second: Array) -> Array:
    """Return ``1 / (|t|^2 - a . t_s)`` at feet on sides, 0 at corners."""
    square = np.einsum("nd,nd->n", t, t)
    lifted = np.maximum(square - np.einsum("nd,nd->n", a, second), _LEAST * square)
    return np.asarray(np.divide(1.0, lifted, out=np.zeros_like(square), where=square > 0))


def _foot_gap(side: Array, correction: Array, a: Array, t: Array, t_two: Array) -> Array:
    normal = np.cross(t, t_two)
    along = np.stack([np.einsum("nd,nd->n", a, each) for each in (t, t_two)], axis=1)
    height = side * np.einsum("nd,nd->n", a, normal) / np.linalg.norm(normal, axis=1)
    return np.asarray(height - np.einsum("na,nab,nb->n", along, correction, along) / 2)


def _foot_slope(side: Array, correction: Array, a: Array, t: Array, t_two: Array) -> Array:
    volume_slope, area_slope, volume, area = _volume_over_area(a, t, t_two)
    along_slope, pull = _along(correction, a, t, t_two)
    height = side[:, None] * (volume_slope / area - volume / area**2 * area_slope)
    return np.asarray(height - np.einsum("na,nai->ni", pull, along_slope))


def _foot_curvature(side: Array, correction: Array, a: Array, t: Array, t_two: Array) -> Array:
    """Second derivative of ``side v / w - s . M s / 2`` with ``v = a . (t x t')`` and ``w = |t x t'|``."""
    volume_slope, area_slope, volume, area = _volume_over_area(a, t, t_two)
    volume, area = volume[..., None], area[..., None]
    normal = np.cross(t, t_two) / area[:, 0]
    volume_bend = np.zeros((len(a), 9, 9))
    volume_bend[:, :3, 3:6] = np.einsum("ijk,nk->nij", _PERMUTATION, t_two)
    volume_bend[:, :3, 6:] = np.einsum("ijk,nj->nik", _PERMUTATION, t)
    volume_bend[:, 3:6, 6:] = np.einsum("ijk,ni->njk", _PERMUTATION, a)
    area_bend = np.zeros_like(volume_bend)
    area_bend[:, 3:6, 6:] = np.einsum("ijk,ni->njk", _PERMUTATION, normal)
    for bend in (volume_bend, area_bend):
        bend += bend.transpose(0, 2, 1).copy()
    turned = np.zeros((len(a), 3, 9))
    turned[:, :, 3:6], turned[:, :, 6:] = volume_bend[:, :3, 3:6], volume_bend[:, :3, 6:]
    sideways = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    area_bend += turned.transpose(0, 2, 1) @ sideways @ turned / area
    mixed = volume_slope[:, :, None] * area_slope[:, None, :]
    squares = area_slope[:, :, None] * area_slope[:, None, :]
    height = volume_bend / area - (mixed + mixed.transpose(0, 2, 1)) / area**2
    height += 2 * volume / area**3 * squares - volume / area**2 * area_bend
    along_slope, pull = _along(correction, a, t, t_two)
    curved = along_slope.transpose(0, 2, 1) @ correction @ along_slope
    for number in range(2):
        where = slice(3 + 3 * number, 6 + 3 * number)
        curved[:, :3, where] += pull[:, number, None, None] * np.eye(3)
        curved[:, where, :3] += pull[:, number, None, None] * np.eye(3)
    return np.asarray(side[:, None, None] * height - curved)


def _volume_over_area(a: Array, t: Array, t_two: Array) -> tuple[Array, Array, Array, Array]:
    """Return the derivatives of ``a . (t x t')`` and of ``|t x t'|``, (n, 9), and both, (n, 1)."""
    normal = np.cross(t, t_two)
    area = np.linalg.norm(normal, axis=1)[:, None]
    volume_slope = np.column_stack([normal, np.cross(t_two, a), np.cross(a, t)])
    area_slope = np.column_stack([np.zeros_like(a), np.cross(t_two, normal / area), np.cross(normal / area, t)])
    return volume_slope, area_slope, np.einsum("nd,nd->n", a, normal)[:, None], area


def _along(correction: Array, a: Array, t: Array, t_two: Array) -> tuple[Array, Array]:
    """Return the derivatives of s, (n, 2, 9), and ``M s``, (n, 2)."""
    slope, nothing = np.zeros((len(a), 2, 9)), np.zeros_like(a)
    slope[:, 0] = np.column_stack([t, a, nothing])
    slope[:, 1] = np.column_stack([t_two, nothing, a])
    along = np.stack([np.einsum("nd,nd->n", a, each) for each in (t, t_two)], axis=1)
    return slope, np.einsum("nab,nb->na", correction, along)


def _square(correction: Array, a: Array, t: Array) -> Array:
    """Return ``|a|^2 - c (a . t)^2``, kept above 0."""
    square = np.einsum("nd,nd->n", a, a) - correction * np.einsum("nd,nd->n", a, t) ** 2
    return np.asarray(np.maximum(square, np.finfo(float).tiny))


def _square_slope(correction: Array, a: Array, t: Array) -> Array:
    pull = (correction * np.einsum("nd,nd->n", a, t))[:, None]
    return np.column_stack([2 * a - 2 * pull * t, -2 * pull * a])


def _side_curvature(sign: Array, correction: Array, a: Array, t: Array) -> Array:
    distance = np.sqrt(_square(correction, a, t))[:, None, None]
    slope, factor = _square_slope(correction, a, t), correction[:, None, None]
    along = np.einsum("nd,nd->n", a, t)[:, None, None]
    bend = np.zeros((len(a), 6, 6))
    bend[:, :3, :3] = 2 * np.eye(3) - 2 * factor * t[:, :, None] * t[:, None, :]
    bend[:, :3, 3:] = -2 * factor * (t[:, :, None] * a[:, None, :] + along * np.eye(3))
    bend[:, 3:, :3] = bend[:, :3, 3:].transpose(0, 2, 1)
    bend[:, 3:, 3:] = -2 * factor * a[:, :, None] * a[:, None, :]
    curved = bend / (2 * distance) - slope[:, :, None] * slope[:, None, :] / (4 * distance**3)
    return np.asarray(sign[:, None, None] * curved)
