"""The normal gap in the plane and its first two derivatives, with contact pairs held fixed.

With ``a`` from the closest secondary point to the primary point, and ``t`` the deformed secondary tangent, the gap is

    g = side (a_x t_y - a_y t_x) / |t| - c (a . t)^2 / 2        (foot of a normal)
    g = sign |a|                                                (end of an edge)

and open gaps are positive. The first term is the distance to the tangent line; the second is what the wall curves away
from that line when the true foot slides by ``a . t``. With the secondary curvature k (of the deformed wall, by the
outward normal) and the gap g, both frozen where the contact pair was found, the curvature correction is
``c = k / (|t|^2 (1 - k g))``. So g and its first two derivatives are those of the distance to the curved wall itself:
the tangent with frozen contact pairs is the tangent of the energy whose contact pairs are found anew, and Newton's
method converges quadratically.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.surface.edges import EdgeSurface

Array = NDArray[np.float64]
Index = NDArray[np.int64]


#: Second derivative of ``a . t`` by both vectors.
SWAP = np.kron(np.array([[0.0, 1.0], [1.0, 0.0]]), np.eye(2))


@dataclass(frozen=True)
class EdgeGap:
    """Gaps in the plane."""

    at_once: int = sys.maxsize

    @property
    def whole(self) -> EdgeGap:
        """The distance itself."""
        return self

    def flat(self, count: int) -> Array:
        """Return no curvature corrections, shape (count,)."""
        return np.zeros(count)

    def gaps(self, pairs: ContactPairs, side: Array, correction: Array, *vectors: Array) -> Array:
        """Return the gaps."""
        a, t = vectors
        foot = _height(a, t, side) - correction / 2 * _along(a, t) ** 2
        return np.where(pairs.at_end, pairs.sign * np.linalg.norm(a, axis=1), foot)

    def slopes(self, pairs: ContactPairs, side: Array, correction: Array, gap: Array, *vectors: Array) -> Array:
        """Return the derivatives by ``(a_x, a_y, t_x, t_y)``."""
        a, t = vectors
        speed = np.linalg.norm(t, axis=1)[:, None]
        height = _height(a, t, side)[:, None]
        side, curved = side[:, None], (correction * _along(a, t))[:, None]
        by_offset = side * np.column_stack([t[:, 1], -t[:, 0]]) / speed - curved * t
        by_tangent = side * np.column_stack([-a[:, 1], a[:, 0]]) / speed - height * t / speed**2 - curved * a
        end = pairs.at_end
        by_offset[end] = a[end] / gap[end, None]
        by_tangent[end] = 0
        return np.column_stack([by_offset, by_tangent])

    def curvatures(self, pairs: ContactPairs, chosen: Index, side: Array, correction: Array, *vectors: Array) -> Array:
        """Return the second derivatives of chosen gaps by ``(a, t)``, shape (chosen, 4, 4)."""
        a, t = vectors
        end, sign = pairs.at_end[chosen], pairs.sign[chosen]
        foot = _foot_curvature(a, t, side) - correction[:, None, None] * _correction_curvature(a, t)
        return np.where(end[:, None, None], _end_curvature(a, sign), foot)


def edge_kinematics(walls: EdgeSurface, pairs: ContactPairs, positions: Array) -> GapKinematics:
    """Return the kinematics of contact pairs that were found at `positions`, unknowns of shape (2, scalar unknowns)."""
    primary = walls.trace(pairs.primary, pairs.primary_xi)
    secondary = walls.trace(pairs.secondary, pairs.secondary_xi)
    slope, bend = (walls.trace(pairs.secondary, pairs.secondary_xi, degree) for degree in (1, 2))
    offset = np.concatenate([primary, -secondary], axis=1)
    kinematics = GapKinematics(
        pairs=pairs,
        gap=EdgeGap(),
        dofs=np.concatenate([walls.dofs[pairs.primary], walls.dofs[pairs.secondary]], axis=1),
        maps=(offset, np.concatenate([np.zeros_like(primary), slope], axis=1)),
        side=walls.side[pairs.secondary],
        correction=np.zeros(len(pairs)),
    )
    bent = np.einsum("nj,dnj->nd", bend, positions[:, walls.dofs[pairs.secondary]])
    kinematics.correction[:] = _correction(kinematics, positions, bent)
    return kinematics


def _correction(kinematics: GapKinematics, positions: Array, bent: Array) -> Array:
    """Return ``k / (|t|^2 (1 - k g))`` at feet, 0 at ends; `bent` is the second derivative of the secondary wall.

    At a closest point ``1 - k g`` is positive; it is kept away from 0, where contact pairs are about to jump.
    """
    _, t = kinematics.vectors(positions)
    speed2 = np.einsum("nd,nd->n", t, t)
    curvature = _height(bent, t, kinematics.side) / speed2
    correction = curvature / speed2 / np.maximum(1 - curvature * kinematics.gaps(positions), 0.1)
    return np.where(kinematics.pairs.at_end, 0.0, correction)


def _height(a: Array, t: Array, side: Array) -> Array:
    """Return the component of `a` along the outward normal of `t`."""
    return np.asarray(side * (a[:, 0] * t[:, 1] - a[:, 1] * t[:, 0]) / np.linalg.norm(t, axis=1))


def _along(a: Array, t: Array) -> Array:
    return np.asarray(np.einsum("nd,nd->n", a, t))


def _correction_curvature(a: Array, t: Array) -> Array:
    """Second derivative of ``(a . t)^2 / 2``."""
    slope = np.concatenate([t, a], axis=1)
    return np.asarray(slope[:, :, None] * slope[:, None, :] + _along(a, t)[:, None, None] * SWAP)


def _end_curvature(a: Array, sign: Array) -> Array:
    distance = np.maximum(np.linalg.norm(a, axis=1), np.finfo(float).tiny)[:, None, None]
    direction = a[:, :, None] / distance
    block = np.zeros((len(a), 4, 4))
    block[:, :2, :2] = sign[:, None, None] * (np.eye(2) - direction * direction.transpose(0, 2, 1)) / distance
    return block


def _foot_curvature(a: Array, t: Array, side: Array) -> Array:
    """Second derivative of ``c / s`` with ``c = a x t`` and ``s = |t|``."""
    speed = np.linalg.norm(t, axis=1)[:, None, None]
    cross = (a[:, 0] * t[:, 1] - a[:, 1] * t[:, 0])[:, None, None]
    quarter_turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    cross_slope = np.column_stack([t[:, 1], -t[:, 0], -a[:, 1], a[:, 0]])
    direction = t / speed[:, 0]
    speed_slope = np.column_stack([np.zeros_like(a), direction])
    block = np.zeros((len(a), 4, 4))
    block[:, :2, 2:] = quarter_turn / speed
    block[:, 2:, :2] = quarter_turn.T / speed
    mixed = cross_slope[:, :, None] * speed_slope[:, None, :]
    block -= (mixed + mixed.transpose(0, 2, 1)) / speed**2
    block += 2 * cross / speed**3 * speed_slope[:, :, None] * speed_slope[:, None, :]
    block[:, 2:, 2:] -= cross / speed**3 * (np.eye(2) - direction[:, :, None] * direction[:, None, :])
    return side[:, None, None] * block
