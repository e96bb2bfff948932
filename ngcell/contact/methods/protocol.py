"""What a contact method offers, whichever it is. A further method is a new
file with these two classes and the section of a case that makes it (`ngcell.contact.methods.stages`), and one line in
`ngcell.scene.registry`.

Signs and measures: a gap is positive where walls are apart. A contact force is never negative; it acts along the gap's
derivative and drives walls apart. A contact pressure is nominal, a force per *reference* length or area, and turned
into the true pressure where it is reported.

Friction has no method yet, and this is its place: it has no potential of the gap, but one of the slip since the last
accepted step. A method with friction comes as a term of its own (`ngcell.mechanics.term`), as cohesion does
(`ngcell.contact.methods.terms`): an incremental energy of the slip of each contact pair, bounded by the coefficient
times the contact force of the last accepted step, with `has_history`, `accept`, `reset`, `memory` and `recall` for what
is remembered, and the part that is spent told by `unstored`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.surface.surface import Surface, SurfacePoints
from ngcell.mechanics.stored import StoredEnergy
from ngcell.mechanics.term import OneSided

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class ContactSet(Protocol):
    """Contact pairs found in one state, and the contact energy of any nearby state with these contact pairs.

    Positions are unknowns of shape (dimension, scalar unknowns) [length].
    """

    @property
    def kinematics(self) -> GapKinematics:
        """The contact pairs and their gaps."""

    @property
    def keys(self) -> Index:
        """What tells the penalty terms of different states apart."""

    @property
    def lowered(self) -> Array | None:
        """By how much multipliers lower the gaps of the penalty terms [length]; None where there are none."""

    def gaps(self, positions: Array) -> Array:
        """Return the gaps of the penalty terms [length]."""

    def energy(self, positions: Array) -> float:
        """Return the energy that the solver adds to the stored one."""

    def penalty_terms(self, positions: Array) -> tuple[Array, sparse.csr_array, Array]:
        """Return gaps, their derivatives by the unknowns, and stiffness of one-sided penalty terms with that energy."""

    def curvature(self, positions: Array) -> sparse.coo_array:
        """Return the part of the tangent that is due to the curvature of the gaps."""

    def contact_forces(self, positions: Array) -> Array:
        """Return the force that each contact pair transmits [stress * length**(dimension - 1)], >= 0."""

    def missed(self, positions: Array) -> dict[str, float]:
        """Return by how much the method misses conditions of its own, by name; the certificate has a limit for each.

        ``weighted_overlap`` is a length, ``weighted_complementarity`` an energy. Empty where there are none.
        """


@runtime_checkable
class Jointed(Protocol):
    """A contact set that tells which joints of edges points are pressed over."""

    def joints_ahead(self, positions: Array, then: Any, moved: Array) -> OneSided | None:
        """Return the distances to joints that a step went over, from `positions` to `moved`, where another set of the
        same method was found; keys are those of the points."""


@runtime_checkable
class Adapting(Protocol):
    """A method without multipliers, whose penalty terms adapt to what they leave."""

    @property
    def raised(self) -> float:
        """Largest factor by which penalty terms that were too soft have been made stiffer."""

    @property
    def raised_on_facets(self) -> Array:
        """Factors by which those of each facet have been made stiffer, shape (facets,)."""

    def stiffen(self) -> bool:
        """Make all penalty terms stiffer, and tell whether they may be any stiffer."""

    def soften(self) -> None:
        """Take the last `stiffen` back, and what has been raised since."""

    def stiffen_as(self, coarse: Any) -> None:
        """Be at least as stiff as the same method on a coarser mesh."""

    def restart(self, *, early: bool = False) -> None:
        """Take back what was adapted, and adapt from now on; in good time if it is to be early."""

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return what has been adapted, by name."""

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Take up again what `memory` returned."""


class ContactMethod(Protocol):
    """A way to keep walls from passing through each other."""

    @property
    def walls(self) -> Surface:
        """The walls."""

    @property
    def stiffness(self) -> Array:
        """Stiffness of the penalty terms of each facet [stress / length], shape (facets,)."""

    @property
    def has_multipliers(self) -> bool:
        """Whether pressures are unknowns of their own, and not those of overlaps. They come in beside an equilibrium of
        the stage before."""

    def pair(self, positions: Array) -> ContactSet:
        """Find all contact pairs."""

    def couplings(self, positions: Array, margin: float) -> tuple[Index, Index]:
        """Return rows and columns of all scalar unknowns that contact could couple while nothing moves by more
        than half of `margin` [length]."""

    def pressures(self, positions: Array, points: SurfacePoints) -> Array:
        """Return the contact pressure at points of the walls [stress], >= 0, for each reference length."""

    def follow(self, other: ContactMethod, positions: Array) -> None:
        """Start from the pressures of another method at an equilibrium of its own, and forget all others."""

    def update_multipliers(self, contact: ContactSet, positions: Array, stored: StoredEnergy) -> tuple[float, float]:
        """Update the multipliers from an equilibrium with this stored energy; return what it still misses of
        conditions.

        That is the largest gap [length], and the energy [stress * length**2] of the penalty terms that stand for the
        missed gaps; both are 0 where there is nothing to be updated.
        """

    def take_multipliers(self, keys: Index, lowered: Array) -> None:
        """Take multipliers that are foreseen, by how much they lower the gaps of penalty terms with these keys."""

    def note_kinks(self, contact: ContactSet, positions: Array) -> bool:
        """Change the energy of other places where its kinks would hold up steps from here, and tell whether it has."""

    def increase_penalty(self) -> None:
        """Increase the penalty from now on, until the next `follow`."""
