"""Bonds between material points that face each other at rest, and that follow a cohesive law.

Each bond joins a point of a wall to the point of the wall opposite that it coincides with at rest, for good: bonds do
not find new contact pairs. With the vector ``a`` from the one to the other and its part h along the normal of the wall
between the two (open > 0), the opening is

    lambda = sqrt(|a|^2 - min(0, h)^2)

so that sliding loads a bond as parting does, and compression is left to contact. A bond that opens further than ever
before has the traction T(lambda) of its law. One that has been opened by `largest` and is opened less follows the
secant to the origin, with stiffness ``T(largest) / largest``: what separates is spent, and does not come back.

The energy of one increment is that of the secant up to `largest` and that of the law beyond: once differentiable. Where
the secant stiffness falls with the opening, as laws have it, the energy is concave in ``lambda^2``, so the secant
stiffness lies above the tangent.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.cohesion.law import CohesiveLaw
from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.gap.midsurface import midsurface_kinematics
from ngcell.contact.options import DEFAULT_OPTIONS, ContactOptions
from ngcell.contact.pairing.mortar_points import mortar_points
from ngcell.contact.pairing.near import near_facets
from ngcell.contact.surface.surface import Surface
from ngcell.errors import CaseError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Distance, in lengths of the shortest edge, up to which points coincide.
_COINCIDENCE = 1e-6
#: Share of the stiffness at rest below which a bond adds nothing to a tangent.
_NO_STIFFNESS = 1e-14


@dataclass(eq=False)
class Bonds:
    """Bonds between walls, and how far each has been opened.

    The history moves by `advance` and `reset` only. Positions are unknowns of shape (dimension, scalar unknowns)
    [length]; energies of a planar scene are those of a unit of depth.

    Attributes
    ----------
    law : CohesiveLaw
        The law of all bonds.
    kinematics : GapKinematics
        The vectors between the points of each bond, and the tangents of the wall between them.
    bodies : array of int, shape (bonds, 2)
        The two bodies of each bond, the lower number first.
    largest : array of float, shape (bonds,)
        Largest opening in any accepted state [length].
    """

    law: CohesiveLaw
    kinematics: GapKinematics
    bodies: Index
    largest: Array = field(init=False)

    def __post_init__(self) -> None:
        self.reset()

    @property
    def weight(self) -> Array:
        """Length at rest that each bond stands for [length], in three dimensions area, shape (bonds,)."""
        return np.asarray(self.kinematics.pairs.weight)

    def reset(self) -> None:
        """Make all bonds whole."""
        self.largest = np.zeros(len(self.kinematics.pairs))

    def advance(self, positions: Array) -> None:
        """Keep what has been opened further than ever before."""
        self.largest = np.maximum(self.largest, self.openings(positions))

    def openings(self, positions: Array) -> Array:
        """Return the openings [length], >= 0, shape (bonds,)."""
        a, *_ = self.kinematics.vectors(positions)
        height = np.minimum(self.kinematics.gaps(positions), 0)
        return np.asarray(np.sqrt(np.maximum((a**2).sum(1) - height**2, 0)))

    def energy(self, positions: Array) -> float:
        """Return the energy of the increment: what is stored in bonds, plus all that has been spent on them."""
        return self.stored(positions) + self.spent(positions)

    def stored(self, positions: Array) -> float:
        """Return the energy that bonds would give back [stress * length**2]."""
        opening = self.openings(positions)
        return float(self.weight @ (self.law.secant(np.maximum(opening, self.largest)) * opening**2) / 2)

    def spent(self, positions: Array) -> float:
        """Return the energy of separation that bonds do not give back [stress * length**2], this state included."""
        reached = np.maximum(self.openings(positions), self.largest)
        return float(self.weight @ (self.law.work(reached) - self.law.secant(reached) * reached**2 / 2))

    def broken(self, positions: Array) -> NDArray[np.bool_]:
        """Return which bonds have been opened beyond the opening at full strength, this state included."""
        return np.maximum(self.openings(positions), self.largest) > self.law.peak

    def slopes(self, positions: Array) -> Array:
        """Return the derivatives of each bond's energy by ``(a_x, a_y, t_x, t_y)`` [stress * length], (bonds, 4).

        In three dimensions by ``(a, t, t')`` [stress * length**2], (bonds, 9).
        """
        opening = self.openings(positions)
        secant = self.law.secant(np.maximum(opening, self.largest))
        return (self.weight * secant)[:, None] * self._half_squares(positions)

    def gradient(self, positions: Array) -> Array:
        """Return the gradient of the energy, shape (unknowns,)."""
        jacobian = self.kinematics.jacobian(self.slopes(positions), positions.shape[1])
        return np.asarray(jacobian.sum(0))

    def tangent(self, positions: Array) -> sparse.coo_array:
        """Return the second derivative of the energy, shape (unknowns, unknowns)."""
        opening = self.openings(positions)
        secant = self.law.secant(np.maximum(opening, self.largest))
        chosen = np.flatnonzero(secant > _NO_STIFFNESS * self.law.stiffness_at_rest)
        slope, blocks = self._half_squares(positions)[chosen], self._second_half_squares(positions, chosen)
        opening, secant, largest = opening[chosen], secant[chosen], self.largest[chosen]
        blocks *= secant[:, None, None]
        opens = np.flatnonzero(opening > largest)
        rise = self.law.secant_slope(opening[opens]) / opening[opens]
        blocks[opens] += rise[:, None, None] * slope[opens, :, None] * slope[opens, None, :]
        return self.kinematics.assemble(self.weight[chosen, None, None] * blocks, chosen, positions.shape[1])

    def couplings(self) -> tuple[Index, Index]:
        """Return rows and columns of all scalar unknowns that bonds couple."""
        dofs = np.unique(self.kinematics.dofs, axis=0)
        width = dofs.shape[1]
        return np.repeat(dofs, width, axis=1).ravel(), np.tile(dofs, (1, width)).ravel()

    def _half_squares(self, positions: Array) -> Array:
        """Return the derivatives of ``lambda^2 / 2`` by ``(a, t)``, shape (bonds, 4).

        In three dimensions by ``(a, t, t')``, shape (bonds, 9).
        """
        a, *_ = self.kinematics.vectors(positions)
        height, slopes = self.kinematics.slopes(positions)
        squares = -np.minimum(height, 0)[:, None] * slopes
        squares[:, : a.shape[1]] += a
        return squares

    def _second_half_squares(self, positions: Array, chosen: Index) -> Array:
        """Return the second derivatives of ``lambda^2 / 2`` by the same."""
        height, slopes = (array[chosen] for array in self.kinematics.slopes(positions))
        dimension, width = len(positions), slopes.shape[1]
        blocks = np.zeros((len(chosen), width, width))
        blocks[:, :dimension, :dimension] = np.eye(dimension)
        pressed = np.flatnonzero(height < 0)
        slopes, bent = slopes[pressed], self.kinematics.curvatures(positions, chosen[pressed])
        blocks[pressed] -= slopes[:, :, None] * slopes[:, None, :] + height[pressed, None, None] * bent
        return blocks


def bond_walls(walls: Surface, law: CohesiveLaw, options: ContactOptions = DEFAULT_OPTIONS) -> Bonds:
    """Bond all walls that coincide at rest, each pair by the points of a Gauss rule; meshes need not match.

    Raises
    ------
    CaseError
        If no walls coincide.
    """
    reach = _COINCIDENCE * float(walls.sizes.min())
    one, two = near_facets(walls, walls.rest, reach)
    first = walls.body[one] < walls.body[two]
    pairs = mortar_points(walls, walls.rest, one[first], two[first], reach, options.facing)
    points = walls.places(pairs.primary, pairs.primary_xi, walls.rest)
    apart = np.linalg.norm(points - walls.places(pairs.secondary, pairs.secondary_xi, walls.rest), axis=1)
    pairs = pairs.chosen(apart < reach)
    if not len(pairs):
        raise CaseError("cohesion has nothing to hold together: no walls coincide at rest; allowed: walls that do")
    bodies = np.column_stack([walls.body[pairs.primary], walls.body[pairs.secondary]])
    return Bonds(law, midsurface_kinematics(walls, pairs), bodies)
