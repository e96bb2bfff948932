"""What a physical effect offers to the sum of all: the protocol of a term.

The energy of a scene is a sum of terms: stored energy of bodies, loads, fluids, contact, cohesion, or a user's own. A
term gives its value, gradient and tangent at a configuration. Parts of its energy of the form ``k/2 min(0, g)^2``,
whose second derivative jumps at g = 0, it hands over as one-sided penalty terms, and the solver follows every jump
exactly. A term may have a history, which moves when a step is accepted and at no other time; multipliers, which are
updated at equilibria; and reports.

A term of one's own derives from `Term` and defines `value` and `gradient`, and `pattern` and `tangent` where its second
derivative is not zero; all else has a default. Its `role` says whether its forces are stored in bodies, act from
outside, or act between bodies. What NGSolve can express needs less: see `ngcell.mechanics.symbolic`, `docs/examples`.

Signs: a gradient is minus the force that the term exerts on the unknowns. Gaps are positive where walls are apart.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.mechanics.drive import Drive
from ngcell.mechanics.report import Check, Scales
from ngcell.mechanics.stored import StoredEnergy

Array = NDArray[np.float64]
Index = NDArray[np.int64]

NO_ENTRIES: tuple[Index, Index] = (np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))


class Role(Enum):
    """What the forces of a term are in a balance of forces."""

    INTERNAL = "stored in bodies"
    LOAD = "acts on bodies from outside, or from what they hold"
    INTERACTION = "acts between bodies"


@dataclass(frozen=True, eq=False)
class Configuration:
    """Where all bodies are.

    Attributes
    ----------
    displacement : array of float, shape (unknowns,)
        Displacement of all unknowns, those of tied walls included [length].
    positions : array of float, shape (dimension, scalar unknowns)
        Deformed positions as unknowns [length]; not to be written to.
    found : dict of Term to object
        What terms have found at these positions, so that it is found once: their active sets.
    """

    displacement: Array
    positions: Array
    found: dict[object, Any] = field(default_factory=dict, repr=False)


@dataclass(frozen=True, eq=False)
class OneSided:
    """One-sided quadratic terms ``penalty_i/2 min(0, gap_i)^2`` of an energy.

    Attributes
    ----------
    gap : array of float, shape (n,)
        What may not be negative [length].
    jacobian : csr_array, shape (n, unknowns)
        Derivatives of the gaps by the unknowns.
    penalty : array of float, shape (n,)
        Stiffness [stress * length**(dimension - 2)].
    keys : array of int, shape (n,)
        What tells the same penalty term in different configurations; each occurs once.
    lowered : array of float, shape (n,), or None
        By how much multipliers lower gaps [length]: pressures over stiffness; NaN at penalty terms without one.
    """

    gap: Array
    jacobian: sparse.csr_array
    penalty: Array
    keys: Index
    lowered: Array | None = None

    @property
    def gradient(self) -> Array:
        """Gradient of their energy, shape (unknowns,)."""
        return np.asarray(self.jacobian.T @ (self.penalty * np.minimum(self.gap, 0)))


@dataclass(frozen=True, eq=False)
class Interaction:
    """Forces between bodies, one entry a pair of points.

    Attributes
    ----------
    bodies, facets : array of int, shape (n, 2)
        The two bodies, and the facets of their walls.
    force : array of float, shape (n, dimension)
        Force on the first body [stress * length**(dimension - 1)].
    normal : array of float, shape (n,)
        Normal contact force that presses the two together, >= 0.
    """

    bodies: Index
    facets: Index
    force: Array
    normal: Array


class Term(ABC):
    """One physical effect; every method but `value` and `gradient` has a default."""

    @property
    def role(self) -> Role:
        """What its forces are in a balance of forces."""
        return Role.INTERNAL

    @abstractmethod
    def value(self, at: Configuration) -> float:
        """Return the energy, one-sided penalty terms included; NaN where it is not defined."""

    @abstractmethod
    def gradient(self, at: Configuration) -> Array:
        """Return the gradient without that of one-sided penalty terms, shape (unknowns,)."""

    def tangent(self, at: Configuration) -> Array:
        """Return the second derivative on `pattern`, without that of one-sided penalty terms."""
        return np.zeros(0)

    @property
    def pattern(self) -> tuple[Index, Index]:
        """Rows and columns of the lower triangle that `tangent` fills, repetitions allowed."""
        return NO_ENTRIES

    def curvature(self, at: Configuration) -> sparse.coo_array | None:
        """Return the part of the tangent whose pattern moves, shape (unknowns, unknowns)."""
        return None

    def convex_curvature(self, at: Configuration) -> sparse.coo_array | None:
        """Return a convex part of `curvature`; where there is none, that is left out of models that are not convex."""
        return None

    def constraints(self, at: Configuration) -> OneSided | None:
        """Return the one-sided quadratic part of the energy."""
        return None

    def gaps(self, at: Configuration) -> tuple[Index, Array] | None:
        """Return keys and gaps of `constraints`, without their derivatives."""
        found = self.constraints(at)
        return None if found is None else (found.keys, found.gap)

    def kinks(self, at: Configuration, after: Configuration) -> OneSided | None:
        """Return penalty terms that a model needs for steps over kinks, as that to another configuration."""
        return None

    def couplings(self, at: Configuration, margin: float) -> tuple[Index, Index]:
        """Return rows and columns of scalar unknowns that `curvature` and `constraints` could couple while nothing
        moves by more than half of `margin` [length]."""
        return NO_ENTRIES

    def stored_in_bodies(self, at: Configuration) -> Array | None:
        """Return what the term stores in each body [energy], shape (bodies,); None if it cannot tell."""
        return None

    def unstored(self, at: Configuration) -> float:
        """Return the part of the value that is not stored in bodies: potentials, and what was dissipated."""
        return 0.0

    @property
    def incompressibility(self) -> float:
        """Largest ratio of bulk to shear modulus in the term; 0 where it has none."""
        return 0.0

    @property
    def mixed_incompressibility(self) -> float:
        """That of what has the volumetric energy of the mixed method; see `ngcell.mechanics.mixed`."""
        return 0.0

    def softened(self, ratio: float) -> Term:
        """Return the term with bulk moduli of at most `ratio` times the shear moduli, for a continuation in these."""
        return self

    @property
    def keeps_lumens_open(self) -> bool:
        """Whether no lumen can close, for what it holds."""
        return False

    def apply(self, load_factor: float) -> None:
        """Act as at this load factor from now on."""

    def drive(self, at: Configuration, load_factor: float) -> Drive | None:
        """Return how the term takes in work; None for a term that no load factor drives."""
        return None

    @property
    def has_history(self) -> bool:
        """Whether the term remembers accepted steps."""
        return False

    def accept(self, at: Configuration) -> None:
        """Keep what an accepted configuration leaves for good."""

    def reset(self) -> None:
        """Forget all accepted steps."""

    def begin_path(self) -> None:
        """Begin a load path whose steps follow each other: what adapts to a state may do so at each of them."""

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return what the term remembers, by name."""
        return {}

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Take up again what `memory` returned."""

    def start_from(self, before: Term, at: Configuration) -> None:
        """Start from what the corresponding term of the continuation stage before knows at its equilibrium."""

    def refine(self, coarse: Term, at: Configuration) -> None:
        """Take over what the same term on a coarser mesh knows at an equilibrium on that mesh."""

    def update_multipliers(self, at: Configuration, stored: StoredEnergy) -> tuple[float, float]:
        """Update multipliers, or a penalty that is too soft, at an equilibrium that stores this energy; return the
        length and the energy by which conditions that the energy only approaches were missed: zeros if none were."""
        return 0.0, 0.0

    def take_multipliers(self, keys: Index, lowered: Array) -> None:
        """Take these as multipliers from now on, where they are foreseen; see `OneSided`."""

    def note_kinks(self, at: Configuration) -> bool:
        """Change the energy of other places where its kinks would hold up steps from here, and tell whether it has."""
        return False

    def increase_penalty(self) -> None:
        """Make `update_multipliers` miss less each time, at the price of an energy that is harder to minimise."""

    def interaction(self, at: Configuration) -> Interaction | None:
        """Return the forces that the term exerts between bodies."""
        return None

    def contact_pressures(self, at: Configuration, points: Any) -> Array | None:
        """Return the nominal contact pressure [stress] at points of walls; None where the term has none."""
        return None

    def overlap(self, at: Configuration) -> float | None:
        """Return the deepest overlap that the term sees [length]; None where it does not keep bodies apart."""
        return None

    def overlap_over(self, at: Configuration, thickness: Array) -> float | None:
        """Return the deepest overlap over the thinner body's thickness, (bodies,) [length]; None where none is seen."""
        overlap = self.overlap(at)
        return None if overlap is None else overlap / float(thickness.min())

    def overlap_work(self, at: Configuration) -> float:
        """Return forces times overlaps [energy]: by no more than that, rigid contact would change energies."""
        return 0.0

    @property
    def is_mixed(self) -> NDArray[np.bool_] | None:
        """Elements with the volume ratio of `ngcell.mechanics.mixed`, shape (elements,); None if there are none."""
        return None

    def stress(self, gradient: Array, element: Index) -> Array | None:
        """Return the part of the Cauchy stress [stress], shape (n, 3, 3), of deformation gradients in elements."""
        return None

    def cell_fields(self, at: Configuration, load_factor: float) -> dict[str, Array]:
        """Return fields with one value a body, by name."""
        return {}

    def bonds_at(self, at: Configuration) -> tuple[Index, Array, NDArray[np.bool_]] | None:
        """Return bodies, (bonds, 2), lower first, length [length] and whether it broke, of each bond; None without."""
        return None

    def columns(self, at: Configuration) -> dict[str, float]:
        """Return numbers for the table of steps, by name of the column."""
        return {}

    def checks(self, at: Configuration, scales: Scales) -> tuple[Check, ...]:
        """Return what the certificate is to judge besides the balance of forces."""
        return ()
