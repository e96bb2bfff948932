"""What the ends of segments add to weighted gaps: vertices of the other wall, which slide along with it.

As an end moves, the points of its segment move along, and their weights change. Derivatives are those of the rule: the
integral's own, psi times the gap at the end, differs from them by the error of the rule, and minimisations would end
where forces are not the slopes of the energy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap.kinematics import GapKinematics, positive_part

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Cuts:
    """Moving ends of segments.

    The end follows from ``a . t = 0``, with a from the vertex of the other wall to the point on the edge:
    ``d xi = -(t . da + a . dt) / (x' . t)``. The curvature is that of the integral, ``d (integral psi g) / d xi =
    psi g |X'|``. Terms of second order in the gap at the end are left out of it, but for how it comes to rest at the
    end of its own wall; they vanish with the gap.

    Attributes
    ----------
    kinematics : GapKinematics
        The ends and the vertices that cut there, n of them.
    projected : GapKinematics
        The vertices, and where they are projected to.
    share : csr_array, shape (m, n)
        psi |X'| of each end over the integral of psi, for each multiplier.
    row : array of int, shape (n, functions)
        Multiplier of each function on the segment's edge.
    point : array of int, shape (n, points)
        The points of the segment among those of the weighted gaps.
    along : array of float, shape (n, points, 2)
        Deformed tangent of the edge there [length].
    by_gap, by_slope : array of float, shape (n, functions, points)
        By how much a weighted gap changes with the end for each unit of the gaps of the points, and of their
        derivatives along the edge.
    slope : array of float, shape (n, 2)
        Deformed tangent x' of the edge where they are projected to [length].
    rate, bend : array of float, shape (n,)
        First derivative of the end by that of the other wall, which `share` has as a factor, and the second over it;
        see `ngcell.contact.pairing.wall_ends`.
    """

    kinematics: GapKinematics
    projected: GapKinematics
    share: sparse.csr_array
    row: Index
    point: Index
    along: Array
    by_gap: Array
    by_slope: Array
    slope: Array
    rate: Array
    bend: Array

    def jacobian(self, gap: Array, slopes: Array, positions: Array) -> sparse.csr_array:
        """Return what moving ends add to the derivatives of the weighted gaps, from the gaps and slopes of points."""
        risen = np.einsum("nkd,nkd->nk", slopes[self.point, :2], self.along)
        change = np.einsum("nfk,nk->nf", self.by_gap, gap[self.point]) + np.einsum("nfk,nk->nf", self.by_slope, risen)
        column = np.repeat(np.arange(len(change)), change.shape[1])
        by_end = sparse.csr_array((change.ravel(), (self.row.ravel(), column)), shape=self.share.shape)
        return by_end @ self.projected.jacobian(self._moved(positions), positions.shape[1])

    def curvature(self, positions: Array, normal_force: Array, *, convex: bool = False) -> sparse.coo_array:
        """Return what moving ends add to the tangent under the multipliers' forces, shape (m,) [stress * length]; its
        convex part is that of each end."""
        applied = self.share.T @ normal_force
        chosen = np.flatnonzero(applied)
        gap, slopes = self.kinematics.slopes(positions)
        moved = self._moved(positions)
        rise = self.rate * np.einsum("nd,nd->n", slopes[:, :2], self.slope) + self.bend * gap
        rise = rise[chosen, None, None]
        slopes, moved = slopes[chosen], moved[chosen]
        mixed = slopes[:, :, None] * moved[:, None, :]
        blocks = mixed + mixed.transpose(0, 2, 1) + rise * moved[:, :, None] * moved[:, None, :]
        blocks = -applied[chosen, None, None] * blocks
        return self.kinematics.assemble(positive_part(blocks) if convex else blocks, chosen, positions.shape[1])

    def _moved(self, positions: Array) -> Array:
        """Return the derivatives of the ends by ``(a, t)``, shape (n, 4)."""
        a, t = self.projected.vectors(positions)
        along = np.einsum("nd,nd->n", self.slope, t)
        return np.asarray(-np.column_stack([t, a]) / along[:, None])
