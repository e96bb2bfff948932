"""Unilateral contact by a penalty on the overlap, integrated on both walls.

The energy of one quadrature point with gap g, weight w and stiffness k is ``k w min(0, g)^2 / 2``. Both walls of a
pair are primary in turn, so that no wall is preferred, and each pass has half of the stiffness.

The stiffness is that of the layer of elements behind the wall, ``k = multiple * M / depth`` with the plane-strain
modulus M of the softer body of the pair: a contact pressure p then overlaps the walls by about ``p / k``, what p does
to the thickness of `1 / multiple` such layers. Where that is not enough, as on a filled cell or a thick ring, penalty
terms that took over from softer ones adapt: at an equilibrium whose overlaps are too deep, or store too large a share
of the energy, they are made stiffer and it is sought again. Where walls bend so much that they sink in between the
points of the rule, the rule is made finer instead, once: it takes each equal part of a facet, half as wide, as a facet.
Each group of bodies that touch is judged by itself: by the thickness of the bodies that meet, and by what the group
stores, or by a share of what all store where that is more: loose bodies store hardly more than their overlaps. Along a
load path whose steps follow each other the rule is made finer in good time, and both are remembered from step to step.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.gap.by_surface import gap_kinematics, single_pass_kinematics
from ngcell.contact.methods.overlaps import Mask, Overlaps, overlaps
from ngcell.contact.methods.penalty_set import PenaltySet
from ngcell.contact.methods.protocol import ContactMethod, ContactSet
from ngcell.contact.options import DEFAULT_OPTIONS, ContactOptions
from ngcell.contact.pairing.near import Reach, couplings_of_near_facets
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.pairing.search import PairSearch
from ngcell.contact.surface.surface import Surface, SurfacePoints, chosen_points
from ngcell.mechanics.stored import StoredEnergy

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Overlap over the thinner body's thickness that a certificate allows. Overlaps below `NO_OVERLAP` of it are none.
DEEP, NO_OVERLAP = 0.02, 1e-7
#: The same between the points of the rule, where it is made finer in good time.
_EARLY = DEEP / 2
#: Factor by which penalty terms that are too soft are made stiffer, and the most that all such factors make. The
#: derived stiffness is that of a layer that may spread along the wall; one that is confined is stiffer by the ratio of
#: bulk to shear modulus, and is followed up to a ratio of 1e8.
STIFFEN, MOST_STIFFENED = 10.0, 1e8


class PenaltyContact:
    """Penalty contact between all walls.

    Parameters
    ----------
    walls : Surface
        The walls.
    stiffness : array of float, shape (facets,)
        Penalty stiffness of each facet [stress / length]; a pair takes the softer one.
    reach : float or array of float, shape (bodies,)
        Distance up to which walls are paired [length].
    may_stiffen : bool
        Whether penalty terms that turn out too soft are made stiffer.
    single_pass_corners : bool
        Whether next to corners only the corner's wall is integrated; see `ngcell.contact.gap.beside_corners`. Faces
        have both passes.
    options : ContactOptions
        The solver's own numbers.
    """

    has_multipliers = False

    def __init__(
        self,
        walls: Surface,
        stiffness: Array,
        reach: Reach,
        *,
        may_stiffen: bool = True,
        single_pass_corners: bool = False,
        options: ContactOptions = DEFAULT_OPTIONS,
    ) -> None:
        self.walls, self._options = walls, options
        self._derived, self.reach = stiffness, reach
        self._may_stiffen, self._stiffens = may_stiffen, False
        self._usual, self._deep_between = self.searching(walls.quadrature), options.soft
        self._kinematics = single_pass_kinematics(walls) if single_pass_corners else partial(gap_kinematics, walls)
        self._take_back()

    def searching(self, points: SurfacePoints) -> PairSearch:
        """Return the search for contact pairs of points."""
        return PairSearch(self.walls, points, self.reach)

    def _take_back(self) -> None:
        """Let all bodies have the stiffness that was derived, and the usual rule."""
        count = len(self.walls.thickness)
        self._factor, self._firm = np.ones(count), 1.0
        self._is_refined = np.zeros(count, dtype=bool)
        self._search = self._usual

    @cached_property
    def _finer(self) -> PairSearch:
        """The search by the finer rule; made when penalty terms that adapt first overlap."""
        return self.searching(self.walls.divided(2))

    @property
    def stiffness(self) -> Array:
        """Penalty stiffness of each facet, as far as it has been raised [stress / length], shape (facets,)."""
        return np.asarray(self.raised_on_facets * self._derived)

    @property
    def raised_on_facets(self) -> Array:
        """Factors by which penalty terms that were too soft have been made stiffer, shape (facets,)."""
        return np.asarray(self._factor[self.walls.body])

    @property
    def raised(self) -> float:
        """Largest factor by which penalty terms that were too soft have been made stiffer."""
        return float(self._factor.max())

    def stiffen(self) -> bool:
        """Make the penalty terms of all bodies stiffer, if any may be; tell whether."""
        may = STIFFEN * self.raised * self._options.penalty_multiple <= self._options.most_multiple * (1 + 1e-9)
        self._softer, by = self._factor, STIFFEN if may else 1.0
        self._factor, self._firm = self._factor * by, self._firm * by
        return may

    def soften(self) -> None:
        """Take the last `stiffen` back, and what has been raised since."""
        self._factor, self._firm = self._softer, self._firm / STIFFEN

    def stiffen_as(self, coarse: PenaltyContact) -> None:
        """Have at least the stiffness of a coarser mesh, without what turned out too soft there only."""
        self._firm, theirs = coarse._firm, np.zeros_like(self._factor)
        np.maximum.at(theirs, coarse.walls.body, self._firm * coarse._derived)
        ratio = theirs[self.walls.body] / self._derived
        np.maximum.at(self._factor, self.walls.body, np.where(np.isclose(ratio, 1.0), 1.0, ratio))

    def pair(self, positions: Array) -> PenaltySet:
        """Find all contact pairs at `positions`, unknowns of shape (dimension, scalar unknowns)."""
        kinematics = self._kinematics(self._search.pairs(self.walls.nodes(positions)), positions)
        pairs, part = kinematics.pairs, self.walls.part
        stiffness = 0.5 * self._pairwise(pairs) * pairs.weight
        return PenaltySet(kinematics, stiffness, part[pairs.secondary], int(part.max(initial=0)) + 1, self.walls)

    def couplings(self, positions: Array, margin: float) -> tuple[Index, Index]:
        """Return rows and columns of all scalar unknowns that contact could couple while nothing moves by more
        than half of `margin` [length]."""
        return couplings_of_near_facets(self.walls, positions, self.reach + margin)

    def pressures(self, positions: Array, points: SurfacePoints) -> Array:
        """Return the contact pressure at points of the walls [stress]: stiffness times overlap, half from each pass."""
        pairs = self.searching(points).pairs(self.walls.nodes(positions))
        gaps = gap_kinematics(self.walls, pairs, positions).gaps(positions)
        pressure = -self._pairwise(pairs) * np.minimum(gaps, 0)
        return np.bincount(pairs.point, pressure, len(points.facet)).astype(float)

    def follow(self, other: ContactMethod, positions: Array) -> None:
        """Take back what was raised; from now on penalty terms adapt."""
        self.restart()

    def restart(self, *, early: bool = False) -> None:
        """Take back what was raised; from now on penalty terms adapt, and the rule in good time if that is `early`."""
        self._take_back()
        self._stiffens, self._deep_between = self._may_stiffen, _EARLY if early else self._options.soft

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return what was raised of each body, and which have the finer rule; nothing where penalty terms stay."""
        return {"factor": self._factor.copy(), "is_refined": self._is_refined.copy()} if self._stiffens else {}

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Take up what a method that had been restarted early had raised."""
        self.restart(early=True)
        self._factor, self._is_refined = memory["factor"].copy(), memory["is_refined"].copy()
        self._search = self._mixed_search() if self._is_refined.any() else self._usual

    def update_multipliers(self, contact: ContactSet, positions: Array, stored: StoredEnergy) -> tuple[float, float]:
        """Stiffen the penalty terms that are too soft, and return the deepest overlap of these, else zeros."""
        if not self._stiffens:
            return 0.0, 0.0
        pairs, gaps = contact.kinematics.pairs, contact.gaps(positions)
        seen = overlaps(self.walls, pairs, gaps, contact.contact_forces(positions))
        groups = [
            group
            for group in seen.groups(len(self._factor))
            if seen.within(group).largest_share > NO_OVERLAP and self._factor[group].min() < MOST_STIFFENED
        ]
        is_due = any(not self._is_refined[group].all() for group in groups)
        between = self._overlaps_between(positions) if is_due else None
        missed = [self._adapted(group, seen, between, stored) for group in groups]
        return max(missed, default=0.0), 0.0

    def _adapted(self, group: Mask, seen: Overlaps, between: Overlaps | None, stored: StoredEnergy) -> float:
        """Refine the rule of a group of bodies, or stiffen its penalty terms; return the deepest overlap [length] then.

        Overlaps are those at the points that are used, and at those of the finer rule.
        """
        mine, finer = seen.within(group), None if between is None else between.within(group)
        if finer is not None and not self._is_refined[group].all():
            if finer.largest_share > max(self._deep_between, self._options.between * mine.largest_share):
                self._is_refined |= group
                self._search = self._mixed_search()
                return finer.deepest
        energy, options = float(mine.energy.sum()), self._options
        least = max(stored.of(group), options.stored * stored.whole)
        if mine.largest_share <= options.soft and energy <= options.stored * (least + energy):
            return 0.0
        # What a body that has joined the group was not given yet comes first.
        self._factor[group] = np.maximum(self._factor[group], STIFFEN * self._factor[group].min())
        return mine.deepest

    def _overlaps_between(self, positions: Array) -> Overlaps:
        """Return the overlaps at points of the finer rule."""
        pairs = self._finer.pairs(self.walls.nodes(positions))
        return overlaps(self.walls, pairs, gap_kinematics(self.walls, pairs, positions).gaps(positions))

    def _mixed_search(self) -> PairSearch:
        """Return the search by the finer rule on bodies that have it, and by the usual one on others."""
        finer = self.walls.divided(2)
        return self.searching(chosen_points(finer, self.walls.quadrature, self._is_refined[self.walls.body]))

    def take_multipliers(self, keys: Index, lowered: Array) -> None:
        """Do nothing: there are none."""

    def note_kinks(self, contact: ContactSet, positions: Array) -> bool:
        """Do nothing: a penalty lets points come to rest beside kinks."""
        return False

    def increase_penalty(self) -> None:
        """Do nothing: penalty terms are stiffened as fast as they can be."""

    def _pairwise(self, pairs: ContactPairs) -> Array:
        return np.minimum(self.stiffness[pairs.primary], self.stiffness[pairs.secondary])
