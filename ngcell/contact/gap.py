"""The normal gap and its first two derivatives: the signed distance to the outline of the other body.

With ``a`` from the closest secondary point to the primary point, and ``t`` the deformed secondary tangent, the gap is

    g = side (a_x t_y - a_y t_x) / |t|        (foot of a normal: the secondary side's deformed normal n)
    g = sign |a|                              (joint of two edges)

and open gaps are positive. As the closest point is where the distance is stationary, the first derivatives with the partner held
fixed are those with the partner following. The second derivatives are not: along a curved wall the foot moves, by

    d xi = (t . da + g n . dt) / D,   D = |t|^2 - g n . x''        (x'' the second derivative along the wall)

and differentiating ``dg = n . da`` once more gives, with p = t . da, q = n . dt and c = n . x'',

    d2g = -(c p^2 / |t|^2 + 2 p q + g q^2) / D.

On straight walls c = 0, and this is the second derivative with the partner fixed. Residual and tangent so belong to one
energy, the one with partners found anew in every state, and Newton's method on it converges quadratically.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.search import Partners
from ngcell.contact.walls import Walls

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GapKinematics:
    """Linear maps from unknowns to ``(a, t)`` of each partner.

    Attributes
    ----------
    partners : Partners
        The partners, n of them.
    dofs : array of int, shape (n, 2 (order + 1))
        Scalar unknowns of the primary and of the secondary edge.
    offset, tangent, bend : array of float, shape (n, 2 (order + 1))
        Factors of those unknowns in a component of ``a``, of ``t`` and of ``x''``.
    side : array of float, shape (n,)
        Side of the secondary edge.
    weight : array of float, shape (n,)
        Quadrature weight [length].
    """

    partners: Partners
    dofs: NDArray[np.int64]
    offset: Array
    tangent: Array
    bend: Array
    side: Array
    weight: Array

    def vectors(self, positions: Array) -> tuple[Array, Array]:
        """Return ``a`` and ``t``, each (n, 2), of positions given as unknowns of shape (2, scalar unknowns)."""
        local = positions[:, self.dofs]
        return (local * self.offset).sum(2).T, (local * self.tangent).sum(2).T

    def gaps(self, positions: Array) -> Array:
        """Return the gaps [length], shape (n,)."""
        return self._gap(*self.vectors(positions))

    def _gap(self, a: Array, t: Array) -> Array:
        foot = self.side * (a[:, 0] * t[:, 1] - a[:, 1] * t[:, 0]) / np.linalg.norm(t, axis=1)
        return np.where(self.partners.at_end, self.partners.sign * np.linalg.norm(a, axis=1), foot)

    def slopes(self, positions: Array) -> tuple[Array, Array]:
        """Return the gaps and their derivatives by ``(a_x, a_y, t_x, t_y)``, shape (n, 4)."""
        a, t = self.vectors(positions)
        gap = self._gap(a, t)
        speed = np.linalg.norm(t, axis=1)[:, None]
        side = self.side[:, None]
        by_offset = side * np.column_stack([t[:, 1], -t[:, 0]]) / speed
        by_tangent = side * np.column_stack([-a[:, 1], a[:, 0]]) / speed - gap[:, None] * t / speed**2
        end = self.partners.at_end
        by_offset[end] = a[end] / gap[end, None]
        by_tangent[end] = 0
        return gap, np.column_stack([by_offset, by_tangent])

    def curvatures(self, positions: Array, chosen: NDArray[np.int64]) -> Array:
        """Return the second derivatives of chosen gaps by ``(a, t)``, partners following; shape (chosen, 4, 4).

        They hold in the state in which the partners were found.
        """
        a, t = (vector[chosen] for vector in self.vectors(positions))
        bend = (positions[:, self.dofs[chosen]] * self.bend[chosen]).sum(2).T
        gap = self._gap(*self.vectors(positions))[chosen]
        end, sign = self.partners.at_end[chosen], self.partners.sign[chosen]
        foot = _foot_curvature(gap, t, self.side[chosen], bend)
        return np.where(end[:, None, None], _end_curvature(a, sign), foot)

    def jacobian(self, slopes: Array, columns: int) -> sparse.csr_array:
        """Return the derivatives of all gaps by the unknowns, from `slopes`; shape (n, 2 columns)."""
        data = [
            slopes[:, [axis]] * self.offset + slopes[:, [axis + 2]] * self.tangent for axis in range(2)
        ]
        indices = np.concatenate([self.dofs, self.dofs + columns], axis=1)
        pointer = np.arange(len(indices) + 1) * indices.shape[1]
        return sparse.csr_array(
            (np.concatenate(data, axis=1).ravel(), indices.ravel(), pointer), shape=(len(indices), 2 * columns)
        )

    def assemble(self, blocks: Array, chosen: NDArray[np.int64], columns: int) -> sparse.coo_array:
        """Return the sum over chosen partners of their (4, 4) blocks in ``(a, t)``, as a matrix in the unknowns."""
        offset, tangent = self.offset[chosen], self.tangent[chosen]
        empty = np.zeros_like(offset)
        maps = np.stack(
            [
                np.concatenate([offset, empty], axis=1),
                np.concatenate([empty, offset], axis=1),
                np.concatenate([tangent, empty], axis=1),
                np.concatenate([empty, tangent], axis=1),
            ],
            axis=1,
        )
        local = np.einsum("pai,pab,pbj->pij", maps, blocks, maps, optimize=True)
        unknown = np.concatenate([self.dofs[chosen], self.dofs[chosen] + columns], axis=1)
        row = np.repeat(unknown, unknown.shape[1], axis=1).ravel()
        column = np.tile(unknown, (1, unknown.shape[1])).ravel()
        return sparse.coo_array((local.ravel(), (row, column)), shape=(2 * columns, 2 * columns))


def gap_kinematics(walls: Walls, partners: Partners) -> GapKinematics:
    """Return the kinematics of these partners."""
    primary = walls.trace(partners.edge, walls.stations[partners.station])
    secondary = walls.trace(partners.other, partners.xi)
    slope = walls.trace(partners.other, partners.xi, derivative=1)
    bend = walls.trace(partners.other, partners.xi, derivative=2)
    return GapKinematics(
        partners=partners,
        dofs=np.concatenate([walls.dofs[partners.edge], walls.dofs[partners.other]], axis=1),
        offset=np.concatenate([primary, -secondary], axis=1),
        tangent=np.concatenate([np.zeros_like(primary), slope], axis=1),
        bend=np.concatenate([np.zeros_like(primary), bend], axis=1),
        side=walls.side[partners.other],
        weight=walls.weights[partners.edge, partners.station],
    )


def _end_curvature(a: Array, sign: Array) -> Array:
    distance = np.maximum(np.linalg.norm(a, axis=1), np.finfo(float).tiny)[:, None, None]
    direction = a[:, :, None] / distance
    block = np.zeros((len(a), 4, 4))
    block[:, :2, :2] = sign[:, None, None] * (np.eye(2) - direction * direction.transpose(0, 2, 1)) / distance
    return block


def _foot_curvature(gap: Array, t: Array, side: Array, bend: Array) -> Array:
    speed2 = np.einsum("pd,pd->p", t, t)
    normal = side[:, None] * np.column_stack([t[:, 1], -t[:, 0]]) / np.sqrt(speed2)[:, None]
    bulge = np.einsum("pd,pd->p", normal, bend)
    along = np.column_stack([t, np.zeros_like(t)])
    across = np.column_stack([np.zeros_like(t), normal])
    mixed = along[:, :, None] * across[:, None, :]
    block = mixed + mixed.transpose(0, 2, 1)
    block += (bulge / speed2)[:, None, None] * along[:, :, None] * along[:, None, :]
    block += gap[:, None, None] * across[:, :, None] * across[:, None, :]
    # Beyond the centre of curvature of the wall the foot is no longer the closest point.
    stiffness = np.maximum(speed2 - gap * bulge, 0.1 * speed2)
    return -block / stiffness[:, None, None]
