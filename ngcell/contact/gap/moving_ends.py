"""What the ends of segments add to weighted gaps: vertices of the other wall, which slide along with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap.kinematics import GapKinematics, positive_part

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Cuts:
    """Moving ends of segments: with an end at xi, ``d (integral psi g) / d xi = psi g |X'|``.

    The end follows from ``a . t = 0``, with a from the vertex of the other wall to the point on the edge:
    ``d xi = -(t . da + a . dt) / (x' . t)``. Terms of second order in the gap at the end are left out of the curvature,
    but for how it comes to rest at the end of its own wall; they vanish with it.

    Attributes
    ----------
    kinematics : GapKinematics
        The ends and the vertices that cut there, n of them.
    projected : GapKinematics
        The vertices, and where they are projected to.
    share : csr_array, shape (m, n)
        psi |X'| of each end over the integral of psi, for each multiplier.
    slope : array of float, shape (n, 2)
        Deformed tangent x' of the edge where they are projected to [length].
    rate, bend : array of float, shape (n,)
        First derivative of the end by that of the other wall, which `share` has as a factor, and the second over it;
        see `ngcell.contact.pairing.wall_ends`.
    """

    kinematics: GapKinematics
    projected: GapKinematics
    share: sparse.csr_array
    slope: Array
    rate: Array
    bend: Array

    def jacobian(self, positions: Array) -> sparse.csr_array:
        """Return what moving ends add to the derivatives of the weighted gaps."""
        gap, _ = self.kinematics.slopes(positions)
        moved = self._moved(positions)
        return self.share @ self.projected.jacobian(gap[:, None] * moved, positions.shape[1])

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
