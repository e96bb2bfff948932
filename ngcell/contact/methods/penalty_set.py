"""The penalty terms of contact pairs that were found in one state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap.by_surface import joints_pressed_over
from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.term import OneSided

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class PenaltySet:
    """Contact pairs found in one state, and the penalty energy of any nearby state with these contact pairs.

    Attributes
    ----------
    kinematics : GapKinematics
        The contact pairs and their gaps.
    stiffness : array of float, shape (contact pairs,)
        Penalty stiffness times quadrature weight [stress]: a force per overlap.
    other_part : array of int, shape (contact pairs,)
        The part of the walls that each point is held by: another body, or another side of its lumen.
    part_count : int
        Number of parts.
    walls : Surface
        The walls.
    """

    kinematics: GapKinematics
    stiffness: Array
    other_part: Index
    part_count: int
    walls: Surface

    @property
    def keys(self) -> Index:
        """What tells the penalty terms of different states apart: the point and the other part."""
        return self.kinematics.pairs.point * self.part_count + self.other_part

    @property
    def lowered(self) -> None:
        """Nothing: there are no multipliers."""

    def gaps(self, positions: Array) -> Array:
        """Return the gaps of the penalty terms [length], shape (contact pairs,)."""
        return self.kinematics.gaps(positions)

    def energy(self, positions: Array) -> float:
        """Return the penalty energy at `positions`, unknowns of shape (dimension, scalar unknowns)."""
        overlap = np.minimum(self.kinematics.gaps(positions), 0)
        return float(0.5 * (self.stiffness * overlap**2).sum())

    def penalty_terms(self, positions: Array) -> tuple[Array, sparse.csr_array, Array]:
        """Return gaps, their derivatives by the unknowns, and stiffness: one one-sided penalty term a contact pair."""
        gap, slopes = self.kinematics.slopes(positions)
        return gap, self.kinematics.jacobian(slopes, positions.shape[1]), self.stiffness

    def curvature(self, positions: Array) -> sparse.coo_array:
        """Return the part of the tangent that is due to the curvature of the closed gaps."""
        return self.kinematics.bending(positions, self.contact_forces(positions))

    def contact_forces(self, positions: Array) -> Array:
        """Return the force that each contact pair transmits [stress * length**(dimension - 1)], >= 0."""
        return -self.stiffness * np.minimum(self.kinematics.gaps(positions), 0)

    def joints_ahead(self, positions: Array, then: PenaltySet, moved: Array) -> OneSided | None:
        """Return the distances to joints that points were pressed over by a step to another set; its keys are those of
        the points."""
        if not len(then.keys):
            return None
        order = np.argsort(then.keys, kind="stable")
        place = order[np.minimum(np.searchsorted(then.keys, self.keys, sorter=order), len(order) - 1)]
        place = np.where(then.keys[place] == self.keys, place, -1)
        found = joints_pressed_over(self.walls, self.kinematics, place, then.kinematics, positions, moved)
        if found is None or not len(found[0]):
            return None
        chosen, factor, ahead, jacobian = found
        return OneSided(ahead, jacobian, factor * self.stiffness[chosen], self.keys[chosen])

    def missed(self, positions: Array) -> dict[str, float]:
        """Return nothing: a penalty has no conditions of its own."""
        return {}
