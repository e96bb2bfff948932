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

#: Stiffness of the contact that is meant, and of the one with which release paths are walked, in layers of elements:
#: the softer one is as stiff as the layer behind the wall, and costs a third of the iterations. In between it rises by
#: steps of `LADDER`.
DEFAULT_MULTIPLE, PATH_MULTIPLE, LADDER = 10.0, 1.0, 10.0


def softer_multiples(meant: float) -> list[float]:
    """Return the multiples of the stiffness that lead up to the one that is meant, softest first."""
    multiples, multiple = [], PATH_MULTIPLE
    while multiple < meant * (1 - 1e-9):
        multiples.append(multiple)
        multiple *= LADDER
    return multiples


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
        kinematics = gap_kinematics(self.walls, partners, positions)
        pairwise = np.minimum(self.stiffness[partners.edge], self.stiffness[partners.other])
        return ContactSet(kinematics, 0.5 * pairwise * kinematics.weight)

    def couplings(self, positions: Array, margin: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return rows and columns of all scalar unknowns that contact could couple while nothing moves by more
        than half of `margin` [length]."""
        one, two = near_edges(self.walls, self.walls.nodes(positions), self.reach + margin)
        count, width = self.walls.dofs.shape
        touches = sparse.csr_array(
            (np.ones(count * width), self.walls.dofs.ravel(), width * np.arange(count + 1)),
            shape=(count, positions.shape[1]),
        )
        near = sparse.csr_array((np.ones(len(one)), (one, two)), shape=(count, count))
        row, column = (touches.T @ (near + sparse.eye_array(count)) @ touches).tocoo().coords
        return row.astype(np.int64), column.astype(np.int64)


def penalty_stiffness(walls: Walls, modulus_of_body: Array, multiple: float) -> Array:
    """Return the stiffness of each edge [stress / length] from its body's plane-strain modulus [stress].

    It is the same all over a body, that of its thinnest layer: were it each edge's own, the energy of a closed contact
    would jump where a point slides from one edge to the next.
    """
    thinnest = np.full(len(modulus_of_body), np.inf)
    np.minimum.at(thinnest, walls.body, walls.depth)
    return np.asarray(multiple * (modulus_of_body / thinnest)[walls.body])
