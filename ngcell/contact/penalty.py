"""Unilateral contact by a penalty on the overlap, integrated on both walls.

The energy of one quadrature point with gap g, weight w and stiffness k is ``k w min(0, g)^2 / 2``. Both walls of a
pair are primary in turn, so that no wall is preferred, and each pass carries half of the stiffness.

The stiffness is that of the layer of elements behind the wall, ``k = multiple * M / depth`` with the plane-strain
modulus M of the softer body of the pair: a contact pressure p then overlaps the walls by about ``p / k``,
which is what p does to the thickness of `1 / multiple` such layers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap import GapKinematics, gap_kinematics
from ngcell.contact.search import PartnerSearch, near_edges
from ngcell.contact.walls import Walls

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ContactSet:
    """Partners found in one state, and the penalty energy of any nearby state with these partners.

    Attributes
    ----------
    kinematics : GapKinematics
        The partners and their gaps.
    stiffness : array of float, shape (partners,)
        Penalty stiffness times quadrature weight [stress]: a force per overlap.
    """

    kinematics: GapKinematics
    stiffness: Array

    def energy(self, positions: Array) -> float:
        """Return the penalty energy at `positions`, unknowns of shape (2, scalar unknowns)."""
        overlap = np.minimum(self.kinematics.gaps(positions), 0)
        return float(0.5 * (self.stiffness * overlap**2).sum())

    def pressures(self, positions: Array) -> Array:
        """Return the contact pressure at each partner [stress], >= 0: the two passes act as springs side by side."""
        overlap = np.minimum(self.kinematics.gaps(positions), 0)
        return -2 * self.stiffness * overlap / self.kinematics.weight

    def springs(self, positions: Array) -> tuple[Array, sparse.csr_array, Array]:
        """Return gaps, their derivatives by the unknowns, and stiffness: one one-sided spring a partner."""
        gap, slopes = self.kinematics.slopes(positions)
        return gap, self.kinematics.jacobian(slopes, positions.shape[1]), self.stiffness

    def curvature(self, positions: Array) -> sparse.coo_array:
        """Return the part of the tangent that is due to the curvature of the closed gaps."""
        gap = self.kinematics.gaps(positions)
        closed = np.flatnonzero(gap < 0)
        blocks = (self.stiffness * gap)[closed, None, None] * self.kinematics.curvatures(positions, closed)
        return self.kinematics.assemble(blocks, closed, positions.shape[1])


class PenaltyContact:
    """Penalty contact between all walls.

    Parameters
    ----------
    walls : Walls
        The walls.
    stiffness : array of float, shape (edges,)
        Penalty stiffness of each wall edge [stress / length]; a pair takes the softer one.
    reach : float
        Distance up to which walls are paired [length].
    """

    def __init__(self, walls: Walls, stiffness: Array, reach: float) -> None:
        self.walls = walls
        self.stiffness = stiffness
        self.reach = reach
        self._search = PartnerSearch(walls, reach)

    def pair(self, positions: Array) -> ContactSet:
        """Find all partners at `positions`, unknowns of shape (2, scalar unknowns)."""
        partners = self._search.partners(self.walls.nodes(positions))
        kinematics = gap_kinematics(self.walls, partners)
        pairwise = np.minimum(self.stiffness[partners.edge], self.stiffness[partners.other])
        return ContactSet(kinematics, 0.5 * pairwise * kinematics.weight)

    def couplings(self, positions: Array, margin: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return rows and columns of all scalar unknowns that contact could couple while nothing moves by more
        than half of `margin` [length]."""
        one, two = near_edges(self.walls, self.walls.nodes(positions), self.reach + margin)
        dofs = np.concatenate([self.walls.dofs[one], self.walls.dofs[two]], axis=1)
        width = dofs.shape[1]
        return np.repeat(dofs, width, axis=1).ravel(), np.tile(dofs, (1, width)).ravel()


def penalty_stiffness(walls: Walls, modulus_of_body: Array, multiple: float) -> Array:
    """Return the stiffness of each edge [stress / length] from its body's plane-strain modulus [stress]."""
    return np.asarray(multiple * modulus_of_body[walls.body] / walls.depth)
