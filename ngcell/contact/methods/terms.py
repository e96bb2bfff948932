"""Contact and cohesion as terms of the sum."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.cohesion.bonds import Bonds
from ngcell.contact.methods.mortar_set import MortarSet
from ngcell.contact.methods.overlaps import overlaps
from ngcell.contact.methods.protocol import Adapting, ContactMethod, ContactSet, Jointed
from ngcell.contact.surface.surface import SurfacePoints
from ngcell.mechanics.report import Check, Scales
from ngcell.mechanics.stored import StoredEnergy
from ngcell.mechanics.term import Configuration, Interaction, OneSided, Role, Term

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Limits of checks, and what these are.
TENSION, COMPLEMENTARITY, WEIGHTED = 0.0, 0.02, 1e-6
_MEMORY = "penalty_"
_MEANING = {
    "tension": "largest tensile contact force of a contact pair",
    "complementarity": "integral of contact pressure times gap over the stored energy",
    "weighted_overlap": "deepest overlap averaged by a multiplier's function over the thinnest wall; mortar only",
    "weighted_complementarity": "sum of multipliers times weighted gaps over the stored energy; mortar only",
}


def named(prefix: str, memory: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return what a method remembers by names that begin with a prefix."""
    return {f"{prefix}{name}": values for name, values in memory.items()}


def unnamed(prefix: str, memory: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return what was given such names."""
    return {name.removeprefix(prefix): values for name, values in memory.items() if name.startswith(prefix)}


class ContactTerm(Term):
    """Unilateral contact by any method: its energy consists of one-sided constraints, with pairs found in each state.

    Parameters
    ----------
    method : ContactMethod
        The method.
    """

    def __init__(self, method: ContactMethod) -> None:
        self.method = method

    @property
    def role(self) -> Role:
        """Contact acts between bodies."""
        return Role.INTERACTION

    @property
    def stiffness(self) -> Array:
        """Stiffness of the penalty terms of each facet [stress / length], shape (facets,)."""
        return self.method.stiffness

    @property
    def raised(self) -> float:
        """Factor by which penalty terms that were too soft have been made stiffer; 1 where a method knows none."""
        return self.method.raised if isinstance(self.method, Adapting) else 1.0

    def found(self, at: Configuration) -> ContactSet:
        """Return the contact pairs at a configuration."""
        if self not in at.found:
            at.found[self] = self.method.pair(at.positions)
        found: ContactSet = at.found[self]
        return found

    def value(self, at: Configuration) -> float:
        """Return the energy of the contact conditions."""
        return self.found(at).energy(at.positions)

    def gradient(self, at: Configuration) -> Array:
        """Return nothing but zeros: all of it is that of constraints."""
        return np.zeros(at.positions.size)

    def constraints(self, at: Configuration) -> OneSided:
        """Return one constraint a condition."""
        found = self.found(at)
        gap, jacobian, penalty = found.penalty_terms(at.positions)
        return OneSided(gap, jacobian, penalty, found.keys, found.lowered)

    def gaps(self, at: Configuration) -> tuple[Index, Array]:
        """Return keys and gaps of the constraints."""
        found = self.found(at)
        return found.keys, found.gaps(at.positions)

    def kinks(self, at: Configuration, after: Configuration) -> OneSided | None:
        """Return joints that points were pressed over; None of contact sets that tell of none."""
        found, then = self.found(at), self.found(after)
        return found.joints_ahead(at.positions, then, after.positions) if isinstance(found, Jointed) else None

    def curvature(self, at: Configuration) -> sparse.coo_array:
        """Return the part of the tangent that is due to the curvature of closed gaps."""
        return self.found(at).curvature(at.positions)

    def convex_curvature(self, at: Configuration) -> sparse.coo_array | None:
        """Return the part of it in which no point bends the energy downwards; None of a penalty."""
        found = self.found(at)
        return found.convex_curvature(at.positions) if isinstance(found, MortarSet) else None

    def couplings(self, at: Configuration, margin: float) -> tuple[Index, Index]:
        """Return the entries that pairs in reach may fill."""
        return self.method.couplings(at.positions, margin)

    def start_from(self, before: Term, at: Configuration) -> None:
        """Start from the pressures of the method of the stage before."""
        assert isinstance(before, ContactTerm)
        self.method.follow(before.method, at.positions)

    def refine(self, coarse: Term, at: Configuration) -> None:
        """Take over how stiff the method has been made on a coarser mesh."""
        assert isinstance(coarse, ContactTerm)
        if isinstance(self.method, Adapting) and isinstance(coarse.method, Adapting):
            self.method.stiffen_as(coarse.method)

    def begin_path(self) -> None:
        """Let the method adapt from now on, if it can."""
        if isinstance(self.method, Adapting):
            self.method.restart(early=True)

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return what the method has adapted."""
        return named(_MEMORY, self.method.memory()) if isinstance(self.method, Adapting) else {}

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Let the method take up what it had adapted."""
        mine = unnamed(_MEMORY, memory)
        if mine and isinstance(self.method, Adapting):
            self.method.recall(mine)

    def update_multipliers(self, at: Configuration, stored: StoredEnergy) -> tuple[float, float]:
        """Let the method update its pressures, or its penalty."""
        return self.method.update_multipliers(self.found(at), at.positions, stored)

    def take_multipliers(self, keys: Index, lowered: Array) -> None:
        """Let the method take these pressures."""
        self.method.take_multipliers(keys, lowered)

    def note_kinks(self, at: Configuration) -> bool:
        """Let the method hold what comes to a kink of its gaps."""
        return self.method.note_kinks(self.found(at), at.positions)

    def increase_penalty(self) -> None:
        """Let the method update in larger steps."""
        self.method.increase_penalty()

    def interaction(self, at: Configuration) -> Interaction:
        """Return the contact forces, each on the body of the primary point."""
        kinematics, normal = self.found(at).kinematics, self.found(at).contact_forces(at.positions)
        closed = normal > 0
        _, slopes = kinematics.slopes(at.positions)
        facets = np.column_stack([kinematics.pairs.primary, kinematics.pairs.secondary])[closed]
        force = normal[closed, None] * slopes[closed, : len(at.positions)]
        # Beside corners gaps may have a factor, by which the force is larger or smaller than the multiplier.
        return Interaction(self.method.walls.body[facets], facets, force, np.linalg.norm(force, axis=1))

    def contact_pressures(self, at: Configuration, points: SurfacePoints) -> Array:
        """Return the nominal contact pressure [stress], >= 0."""
        return self.method.pressures(at.positions, points)

    def overlap(self, at: Configuration) -> float:
        """Return the deepest overlap at the points of the method [length], >= 0."""
        return max(0.0, -float(self.found(at).kinematics.distances(at.positions).min(initial=0.0)))

    def overlap_over(self, at: Configuration, thickness: Array) -> float:
        """Return the deepest overlap over the thickness of the thinner of the two bodies."""
        kinematics = self.found(at).kinematics
        seen = overlaps(self.method.walls, kinematics.pairs, kinematics.distances(at.positions))
        return float((seen.depth / thickness[seen.bodies].min(1)).max(initial=0.0))

    def overlap_work(self, at: Configuration) -> float:
        """Return contact forces times gaps, without their sign."""
        found = self.found(at)
        return abs(float(found.contact_forces(at.positions) @ found.kinematics.gaps(at.positions)))

    @property
    def has_multipliers(self) -> bool:
        """Whether pressures are unknowns of their own, and not those of overlaps."""
        return self.method.has_multipliers

    def checks(self, at: Configuration, scales: Scales) -> tuple[Check, ...]:
        """Return tension, complementarity and the method's own conditions."""
        found, work = self.found(at), self.overlap_work(at)
        force = found.contact_forces(at.positions)
        units = {"weighted_overlap": scales.thickness, "weighted_complementarity": scales.at_stake}
        return (
            Check("tension", max(0.0, -float(force.min(initial=0.0))), TENSION, _MEANING["tension"]),
            Check("complementarity", work / scales.at_stake, COMPLEMENTARITY, _MEANING["complementarity"]),
            *(
                Check(name, value / units[name], WEIGHTED, _MEANING[name])
                for name, value in found.missed(at.positions).items()
            ),
        )


class CohesionTerm(Term):
    """Bonds between walls, with the history of what has been opened.

    Parameters
    ----------
    bonds : Bonds
        The bonds.
    """

    def __init__(self, bonds: Bonds) -> None:
        self.bonds = bonds

    @property
    def role(self) -> Role:
        """Bonds act between bodies."""
        return Role.INTERACTION

    @property
    def has_history(self) -> bool:
        """Bonds remember how far they have been opened."""
        return True

    def value(self, at: Configuration) -> float:
        """Return the energy of the increment: what is stored in bonds, plus all that has been spent on them."""
        return self.bonds.energy(at.positions)

    def gradient(self, at: Configuration) -> Array:
        """Return its gradient, shape (unknowns,)."""
        return self.bonds.gradient(at.positions)

    def curvature(self, at: Configuration) -> sparse.coo_array:
        """Return its second derivative."""
        return self.bonds.tangent(at.positions)

    def couplings(self, at: Configuration, margin: float) -> tuple[Index, Index]:
        """Return the entries that bonds fill."""
        return self.bonds.couplings()

    def unstored(self, at: Configuration) -> float:
        """Return the energy of separation, which bonds do not give back."""
        return self.bonds.spent(at.positions)

    def accept(self, at: Configuration) -> None:
        """Keep what has been opened further than ever before."""
        self.bonds.advance(at.positions)

    def reset(self) -> None:
        """Make all bonds whole."""
        self.bonds.reset()

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return the largest opening of each bond [length]."""
        return {"largest_opening": self.bonds.largest}

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Take up the openings of an earlier run."""
        self.bonds.largest = memory["largest_opening"]

    def interaction(self, at: Configuration) -> Interaction:
        """Return the forces of the bonds, each on its first body."""
        pairs = self.bonds.kinematics.pairs
        force = -self.bonds.slopes(at.positions)[:, : len(at.positions)]
        facets = np.column_stack([pairs.primary, pairs.secondary])
        return Interaction(self.bonds.bodies, facets, force, np.zeros(len(force)))

    def bonds_at(self, at: Configuration) -> tuple[Index, Array, NDArray[np.bool_]]:
        """Return the two bodies of each bond, its length, and whether it was opened beyond its strength."""
        return self.bonds.bodies, self.bonds.weight, self.bonds.broken(at.positions)

    def columns(self, at: Configuration) -> dict[str, float]:
        """Return the energy of separation, and the share of length that was never opened beyond its strength."""
        broken = float(self.bonds.weight @ self.bonds.broken(at.positions) / self.bonds.weight.sum())
        return {"separation_energy": self.bonds.spent(at.positions), "bonded_share": 1 - broken}
