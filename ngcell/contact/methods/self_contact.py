"""Contact of a lumen with itself: the walls around it touch each other when a cell collapses.

The method is the penalty of `ngcell.contact.methods.penalty`, whatever acts between bodies: it is integrated on both
walls, and stiffened where it is too soft. As long as no lumen closes, the term is nothing. Its forces act within a
body: they have no resultant, and are no forces between bodies.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.methods.overlaps import overlaps
from ngcell.contact.methods.penalty import DEEP, PenaltyContact
from ngcell.contact.methods.penalty_set import PenaltySet
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.terms import COMPLEMENTARITY, named, unnamed
from ngcell.contact.options import DEFAULT_OPTIONS, ContactOptions
from ngcell.contact.pairing.lumens import Closing, LumenSearch, near_in_closing
from ngcell.contact.surface.lumens import LumenSurface
from ngcell.contact.surface.surface import SurfacePoints
from ngcell.mechanics.report import Check, Scales
from ngcell.mechanics.stored import StoredEnergy
from ngcell.mechanics.term import Configuration, OneSided, Role, Term

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_MEMORY = "lumens_penalty_"
_MEANING = {
    "self_overlap_over_wall": "deepest overlap of a lumen's walls, as their contact sees it, over the thickness",
    "self_complementarity": "integral of the contact pressure within lumens times gap over the stored energy",
}


class LumenPenalty(PenaltyContact):
    """Penalty contact of lumens with themselves.

    Parameters
    ----------
    closing : Closing
        The lumens, and which of them close.
    stiffness : array of float, shape (edges,)
        Penalty stiffness of each edge [stress / length].
    options : ContactOptions
        The solver's own numbers.
    """

    def __init__(self, closing: Closing, stiffness: Array, options: ContactOptions = DEFAULT_OPTIONS) -> None:
        lumens = closing.surface
        self.lumens, self.closing = lumens, closing
        super().__init__(lumens, stiffness, lumens.thickness, options=options)

    def searching(self, points: SurfacePoints) -> LumenSearch:
        """Return the search for contact pairs of points."""
        return LumenSearch(self.closing, points, self.reach)

    def couplings(self, positions: Array, margin: float) -> tuple[Index, Index]:
        """Return rows and columns of all scalar unknowns that contact could couple; see `PenaltyContact.couplings`.

        They are never none, so that they are asked for again when lumens may have closed.
        """
        one, two = near_in_closing(self.closing, self.lumens.nodes(positions), self.reach, margin)
        count = self.lumens.facet_count
        near = sparse.csr_array((np.ones(len(one)), (one, two)), shape=(count, count))
        touches = self.lumens.touches(positions.shape[1])
        row, column = (touches.T @ near @ touches).tocoo().coords
        first = self.lumens.dofs[0, :1]
        return np.append(first, row).astype(np.int64), np.append(first, column).astype(np.int64)


class SelfContact(Term):
    """Contact of lumens with themselves, as a term of the sum.

    Parameters
    ----------
    method : LumenPenalty
        How it is resisted.
    """

    def __init__(self, method: LumenPenalty) -> None:
        self.method = method

    @property
    def role(self) -> Role:
        """It is no energy of a body."""
        return Role.INTERACTION

    def found(self, at: Configuration) -> PenaltySet | None:
        """Return the contact pairs at a configuration; None while no lumen closes."""
        if self not in at.found:
            nodes = self.method.lumens.nodes(at.positions)
            pairs = self.method.pair(at.positions) if self.method.closing.lumens(nodes).any() else None
            at.found[self] = pairs if pairs is not None and len(pairs.stiffness) else None
        found: PenaltySet | None = at.found[self]
        return found

    def value(self, at: Configuration) -> float:
        """Return the energy of the contact conditions."""
        found = self.found(at)
        return 0.0 if found is None else found.energy(at.positions)

    def gradient(self, at: Configuration) -> Array:
        """Return nothing but zeros: all of it is that of constraints."""
        return np.zeros(at.positions.size)

    def constraints(self, at: Configuration) -> OneSided | None:
        """Return one constraint a contact pair."""
        found = self.found(at)
        if found is None:
            return None
        gap, jacobian, penalty = found.penalty_terms(at.positions)
        return OneSided(gap, jacobian, penalty, found.keys)

    def gaps(self, at: Configuration) -> tuple[Index, Array] | None:
        """Return keys and gaps of the constraints."""
        found = self.found(at)
        return None if found is None else (found.keys, found.gaps(at.positions))

    def curvature(self, at: Configuration) -> sparse.coo_array | None:
        """Return the part of the tangent that is due to the curvature of closed gaps."""
        found = self.found(at)
        return None if found is None else found.curvature(at.positions)

    def couplings(self, at: Configuration, margin: float) -> tuple[Index, Index]:
        """Return the entries that pairs in reach may fill."""
        return self.method.couplings(at.positions, margin)

    def start_from(self, before: Term, at: Configuration) -> None:
        """Forget what the penalty was raised to."""
        assert isinstance(before, SelfContact)
        self.method.follow(before.method, at.positions)

    def reset(self) -> None:
        """Forget what the penalty was raised to, and let it adapt again."""
        self.method.restart()

    def begin_path(self) -> None:
        """Forget what the penalty was raised to, and let it adapt in good time."""
        self.method.restart(early=True)

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return what the penalty was raised to."""
        return named(_MEMORY, self.method.memory())

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Take that up again."""
        mine = unnamed(_MEMORY, memory)
        if mine:
            self.method.recall(mine)

    def update_multipliers(self, at: Configuration, stored: StoredEnergy) -> tuple[float, float]:
        """Let penalty terms that are too soft be made stiffer, lumen by lumen."""
        found, bodies = self.found(at), self.method.lumens.body_of_loop
        if found is None:
            return 0.0, 0.0

        def by_loop() -> tuple[Array, float]:
            in_bodies, beside = stored.find()
            return in_bodies[bodies], beside

        return self.method.update_multipliers(found, at.positions, StoredEnergy(by_loop))

    def overlap_work(self, at: Configuration) -> float:
        """Return contact forces times gaps, without their sign."""
        found = self.found(at)
        return 0.0 if found is None else abs(float(found.contact_forces(at.positions) @ found.gaps(at.positions)))

    def force_in_bodies(self, at: Configuration, body_count: int) -> Array:
        """Return the sum of the magnitudes of the contact forces in each body, shape (bodies,) [stress * length].

        Each force is counted once: both walls of a contact carry half of it each.
        """
        found = self.found(at)
        if found is None:
            return np.zeros(body_count)
        lumens = self.method.lumens
        body = lumens.body_of_loop[lumens.body[found.kinematics.pairs.primary]]
        return np.bincount(body, found.contact_forces(at.positions), body_count).astype(float)

    def checks(self, at: Configuration, scales: Scales) -> tuple[Check, ...]:
        """Return overlap and complementarity where lumens press on themselves."""
        found = self.found(at)
        if found is None or not found.contact_forces(at.positions).any():
            return ()
        depth = overlaps(self.method.lumens, found.kinematics.pairs, found.gaps(at.positions)).largest_share
        work = self.overlap_work(at) / scales.at_stake
        values = {"self_overlap_over_wall": (depth, DEEP), "self_complementarity": (work, COMPLEMENTARITY)}
        return tuple(Check(name, value, limit, _MEANING[name]) for name, (value, limit) in values.items())


def self_contact_stages(
    lumens: LumenSurface,
    modulus_of_body: Array,
    count: int,
    options: ContactOptions = DEFAULT_OPTIONS,
    *,
    stiffness: float = 1.0,
) -> list[SelfContact]:
    """Return contact of lumens for so many stages of a continuation: soft in the first of several.

    `modulus_of_body` is the plane-strain modulus of each body, shape (bodies,) [stress]; `stiffness` multiplies the
    penalty stiffness of all others, as that of contact between bodies does.
    """
    modulus = modulus_of_body[lumens.body_of_loop]
    meant = stiffness * options.penalty_multiple
    multiples = [options.path_multiple] * min(count - 1, 1) + [meant] * max(count - 1, 1)
    closing = Closing(lumens)
    return [
        SelfContact(LumenPenalty(closing, penalty_stiffness(lumens, modulus, multiple), options))
        for multiple in multiples
    ]
