"""Unilateral contact by a penalty on the overlap, integrated on both walls.

The energy of one quadrature point with gap g, weight w and stiffness k is ``k w min(0, g)^2 / 2``. Both walls of a
pair are primary in turn, so that no wall is preferred, and each pass has half of the stiffness.

The stiffness is that of the layer of elements behind the wall, ``k = multiple * M / depth`` with the plane-strain
modulus M of the softer body of the pair: a contact pressure p then overlaps the walls by about ``p / k``,
which is what p does to the thickness of `1 / multiple` such layers. Where that is not enough (a wall may be much
stiffer than its layer, as on a filled cell or a thick ring), penalty terms that took over from softer ones adapt: at an
equilibrium whose overlaps are too deep, or store too large a share of the energy, they are made stiffer and the
equilibrium is sought again. Where walls bend so much that they sink in between the points of the rule, the rule is
made finer instead, once, if the surface has a finer one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap.by_surface import gap_kinematics
from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.methods.protocol import ContactMethod, ContactSet
from ngcell.contact.options import DEFAULT_OPTIONS, ContactOptions
from ngcell.contact.pairing.near import adjacency
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.pairing.search import PairSearch
from ngcell.contact.surface.surface import Surface, SurfacePoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Overlap over reach, and energy of the penalty terms over the stored one, above which penalty terms are too soft. A
#: certificate has the same limits. Overlaps below `NO_OVERLAP` over reach are none.
DEEP, HIGH, NO_OVERLAP = 0.02, 0.01, 1e-7
#: Factor by which penalty terms that are too soft are made stiffer, and the most that all such factors make. The
#: derived stiffness is that of a layer that may spread along the wall; one that is confined is stiffer by the ratio of
#: bulk to shear modulus, and is followed up to a ratio of 1e8.
STIFFEN, MOST_STIFFENED = 10.0, 1e8


@dataclass(frozen=True, eq=False)
class PenaltySet:
    """Contact pairs found in one state, and the penalty energy of any nearby state with these contact pairs.

    Attributes
    ----------
    kinematics : GapKinematics
        The contact pairs and their gaps.
    stiffness : array of float, shape (contact pairs,)
        Penalty stiffness times quadrature weight [stress]: a force per overlap.
    other_body : array of int, shape (contact pairs,)
        The other body of each contact pair.
    body_count : int
        Number of bodies.
    """

    kinematics: GapKinematics
    stiffness: Array
    other_body: Index
    body_count: int

    @property
    def keys(self) -> Index:
        """What tells the penalty terms of different states apart: the point and the other body."""
        pairs = self.kinematics.pairs
        return pairs.point * self.body_count + self.other_body

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

    def missed(self, positions: Array) -> dict[str, float]:
        """Return nothing: a penalty has no conditions of its own."""
        return {}


class PenaltyContact:
    """Penalty contact between all walls.

    Parameters
    ----------
    walls : Surface
        The walls.
    stiffness : array of float, shape (facets,)
        Penalty stiffness of each facet [stress / length]; a pair takes the softer one.
    reach : float
        Distance up to which walls are paired [length].
    may_stiffen : bool
        Whether penalty terms that turn out too soft are made stiffer.
    options : ContactOptions
        The solver's own numbers.
    """

    def __init__(
        self,
        walls: Surface,
        stiffness: Array,
        reach: float,
        *,
        may_stiffen: bool = True,
        options: ContactOptions = DEFAULT_OPTIONS,
    ) -> None:
        self.walls, self._options = walls, options
        self._derived, self._factor = stiffness, 1.0
        self.reach = reach
        self._may_stiffen, self._stiffens = may_stiffen, False
        self._usual = self._search = PairSearch(walls, walls.quadrature, reach)

    @cached_property
    def _finer(self) -> PairSearch | None:
        """The search by the finer rule, if there is one; made when penalty terms that adapt first overlap."""
        points = self.walls.halved()
        return None if points is None else PairSearch(self.walls, points, self.reach)

    @property
    def stiffness(self) -> Array:
        """Penalty stiffness of each facet, as far as it has been raised [stress / length], shape (facets,)."""
        return self._factor * self._derived

    @property
    def raised(self) -> float:
        """Factor by which penalty terms that were too soft have been made stiffer."""
        return self._factor

    def pair(self, positions: Array) -> PenaltySet:
        """Find all contact pairs at `positions`, unknowns of shape (dimension, scalar unknowns)."""
        pairs = self._search.pairs(self.walls.nodes(positions))
        kinematics = gap_kinematics(self.walls, pairs, positions)
        body = self.walls.body
        stiffness = 0.5 * self._pairwise(pairs) * pairs.weight
        return PenaltySet(kinematics, stiffness, body[pairs.secondary], int(body.max()) + 1)

    def couplings(self, positions: Array, margin: float) -> tuple[Index, Index]:
        """Return rows and columns of all scalar unknowns that contact could couple while nothing moves by more
        than half of `margin` [length]."""
        return couplings_of_near_facets(self.walls, positions, self.reach + margin)

    def pressures(self, positions: Array, points: SurfacePoints) -> Array:
        """Return the contact pressure at points of the walls [stress]: penalty stiffness times overlap, half of it from
        each pass."""
        pairs = PairSearch(self.walls, points, self.reach).pairs(self.walls.nodes(positions))
        gaps = gap_kinematics(self.walls, pairs, positions).gaps(positions)
        pressure = -self._pairwise(pairs) * np.minimum(gaps, 0)
        return np.bincount(pairs.point, pressure, len(points.facet)).astype(float)

    def follow(self, other: ContactMethod, positions: Array) -> None:
        """Take back what was raised; from now on penalty terms adapt, unless they go on from themselves."""
        self._factor, self._stiffens = 1.0, self._may_stiffen and other is not self
        self._search = self._usual

    def update_multipliers(self, contact: ContactSet, positions: Array, stored: float) -> tuple[float, float]:
        """Stiffen the penalty terms if they are too soft, and return the deepest overlap then, else zeros."""
        if not self._stiffens or self._factor >= MOST_STIFFENED:
            return 0.0, 0.0
        deepest = max(0.0, -float(contact.gaps(positions).min(initial=0.0)))
        if deepest <= NO_OVERLAP * self.reach:
            return 0.0, 0.0
        between, finer = self._deepest_between(positions)
        if finer is not None and between > max(DEEP * self.reach, self._options.between * deepest):
            self._search = finer
            return between, 0.0
        if deepest <= DEEP * self.reach and contact.energy(positions) <= HIGH * stored:
            return 0.0, 0.0
        self._factor *= STIFFEN
        return deepest, 0.0

    def _deepest_between(self, positions: Array) -> tuple[float, PairSearch | None]:
        """Return the deepest overlap [length] at points of the finer rule, and its search; None once it is used."""
        finer = self._finer if self._search is self._usual else None
        if finer is None:
            return 0.0, None
        pairs = finer.pairs(self.walls.nodes(positions))
        gaps = gap_kinematics(self.walls, pairs, positions).gaps(positions)
        return max(0.0, -float(gaps.min(initial=0.0))), finer

    def increase_penalty(self) -> None:
        """Do nothing: penalty terms are stiffened as fast as they can be."""

    def _pairwise(self, pairs: ContactPairs) -> Array:
        return np.minimum(self.stiffness[pairs.primary], self.stiffness[pairs.secondary])


def penalty_stiffness(walls: Surface, modulus_of_body: Array, multiple: float) -> Array:
    """Return the stiffness of each facet [stress / length] from its body's plane-strain modulus [stress].

    It is the same all over a body, that of its thinnest layer: were it each facet's own, the energy of a closed
    contact would jump where a point slides from one facet to the next.
    """
    thinnest = np.full(len(modulus_of_body), np.inf)
    np.minimum.at(thinnest, walls.body, walls.depth)
    return np.asarray(multiple * (modulus_of_body / thinnest)[walls.body])


def couplings_of_near_facets(walls: Surface, positions: Array, reach: float) -> tuple[Index, Index]:
    """Return rows and columns of all scalar unknowns of facets that are the same, or nearer than `reach` [length]."""
    near = adjacency(walls, walls.nodes(positions), reach)
    touches = walls.touches(positions.shape[1])
    row, column = (touches.T @ near @ touches).tocoo().coords
    return row.astype(np.int64), column.astype(np.int64)
