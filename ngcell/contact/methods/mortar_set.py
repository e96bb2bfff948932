"""Weighted gaps of one state, and the penalty terms by which the mortar method keeps them open.

`ngcell.contact.methods.mortar` says which conditions these are, and where the multipliers come from.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.gap.moving_ends import Cuts

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class MortarSet:
    """Weighted gaps with the contact pairs found in one state.

    Attributes
    ----------
    kinematics : GapKinematics
        The points behind the gaps.
    cuts : Cuts or None
        The ends of the segments, which move as walls slide; None in three dimensions.
    rows : array of int, shape (m,)
        Multiplier of each weighted gap.
    average : csr_array, shape (m, contact pairs)
        Share of each point in the weighted gaps.
    allowance : array of float, shape (m,)
        What is added to the gaps [length].
    pressure : array of float, shape (m,)
        Multipliers at which the set was made [stress].
    stiffness : array of float, shape (m,)
        Stiffness of the penalty terms [stress / length].
    weight : array of float, shape (m,)
        Length that each multiplier acts on [length].
    is_covered : array of bool, shape (m,)
        Whether points cover enough of what a multiplier acts on for it to be determined.
    """

    kinematics: GapKinematics
    cuts: Cuts | None
    rows: Index
    average: sparse.csr_array
    allowance: Array
    pressure: Array
    stiffness: Array
    weight: Array
    is_covered: NDArray[np.bool_]

    @property
    def keys(self) -> Index:
        """What tells the penalty terms of different states apart: the multipliers."""
        return self.rows

    @property
    def lowered(self) -> Array:
        """By how much multipliers lower the gaps of the penalty terms [length], shape (m,); NaN where no multiplier is
        determined."""
        return np.where(self.is_covered, self._lowered, np.nan)

    @property
    def _lowered(self) -> Array:
        return self.pressure / self.stiffness

    def gaps(self, positions: Array) -> Array:
        """Return the gaps of the penalty terms [length], shape (m,)."""
        return self.weighted_gaps(positions) - self._lowered

    def weighted_gaps(self, positions: Array) -> Array:
        """Return the gaps that may not be negative [length], shape (m,)."""
        return np.asarray(self.average @ self.kinematics.gaps(positions) + self.allowance)

    def pressures(self, positions: Array) -> Array:
        """Return the pressures of the penalty terms [stress], >= 0, shape (m,)."""
        return np.maximum(self.pressure - self.stiffness * self.weighted_gaps(positions), 0)

    def multipliers(self, positions: Array) -> Array:
        """Return the pressures of those that are determined, and 0 elsewhere [stress], shape (m,)."""
        return np.where(self.is_covered, self.pressures(positions), 0.0)

    def energy(self, positions: Array) -> float:
        """Return the energy of the penalty terms above that of pressures at rest; 0 where all conditions hold."""
        normal_force = self.pressures(positions)
        return float(0.5 * (self.weight / self.stiffness * (normal_force**2 - self.pressure**2)).sum())

    def penalty_terms(self, positions: Array) -> tuple[Array, sparse.csr_array, Array]:
        """Return one one-sided penalty term a weighted gap."""
        gap, slopes = self.kinematics.slopes(positions)
        jacobian = self.average @ self.kinematics.jacobian(slopes, positions.shape[1])
        if self.cuts is not None:
            jacobian += self.cuts.jacobian(gap, slopes, positions)
        moved = self.average @ gap + self.allowance - self._lowered
        return moved, jacobian.tocsr(), self.stiffness * self.weight

    def curvature(self, positions: Array) -> sparse.coo_array:
        """Return the part of the tangent that is due to the curvature of the closed gaps."""
        return self._curvature(positions, convex=False)

    def convex_curvature(self, positions: Array) -> sparse.coo_array:
        """Return the part of the curvature in which no point, and no moving end, bends the energy downwards."""
        return self._curvature(positions, convex=True)

    def _curvature(self, positions: Array, *, convex: bool) -> sparse.coo_array:
        normal_force = self.weight * self.pressures(positions)
        bending = self.kinematics.bending(positions, self.average.T @ normal_force, convex=convex)
        if self.cuts is None:
            return bending
        return bending + self.cuts.curvature(positions, normal_force, convex=convex)

    def contact_forces(self, positions: Array) -> Array:
        """Return the force that each point transmits [stress * length], >= 0."""
        return np.asarray(self.average.T @ (self.weight * self.pressures(positions)))

    def missed(self, positions: Array) -> dict[str, float]:
        """Return the deepest weighted overlap of what is covered, and the work of pressures on weighted gaps."""
        gaps = np.where(self.is_covered, self.weighted_gaps(positions), 0.0)
        work = self.weight * self.pressures(positions) * gaps
        return {
            "weighted_overlap": max(0.0, -float(gaps.min(initial=0.0))),
            "weighted_complementarity": float(np.abs(work).sum()),
        }
