"""Contact by any smooth law of pressure over the normal gap, of a script for example.

A law gives an energy ``phi(g)`` per reference length or area of a wall as a function of the gap, and its first two
derivatives; the contact pressure is ``-phi'(g) >= 0``. Both walls of a pair are integrated over, with half of the law
each. The solver treats such a term as any other energy; laws with a kink, such as the penalty, are better given as
one-sided constraints (`ngcell.contact.methods.protocol`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.gap.by_surface import gap_kinematics
from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.options import DEFAULT_OPTIONS, ContactOptions
from ngcell.contact.pairing.near import Reach, couplings_of_near_facets
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.pairing.search import PairSearch
from ngcell.contact.surface.surface import Surface, SurfacePoints
from ngcell.errors import CaseError
from ngcell.mechanics.report import Check, Scales
from ngcell.mechanics.term import Configuration, Interaction, Role, Term

Array = NDArray[np.float64]
Index = NDArray[np.int64]
#: Energy per reference length, and its first and second derivative, of gaps [length] and stiffnesses [stress / length].
Law = Callable[[Array, Array], tuple[Array, Array, Array]]


@dataclass(frozen=True)
class NormalLaw:
    """Contact by a law of a script.

    Attributes
    ----------
    law : callable
        Takes gaps [length], open > 0, and the stiffness of the layer of elements behind the wall [stress / length], and
        returns ``phi``, ``phi'`` and ``phi''`` per reference length or area. It vanishes where gaps are large.
    multiple : float
        Factor on that stiffness, > 0.
    """

    law: Law
    multiple: float = 10.0
    goes_with_cohesion: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if not callable(self.law):
            raise CaseError(f"law = {self.law!r}; allowed: a function of gaps and stiffnesses, see `NormalLaw`")

    def stages(
        self, walls: Surface, modulus_of_body: Array, *, reach: Reach, options: ContactOptions = DEFAULT_OPTIONS
    ) -> tuple[NormalLawTerm, ...]:
        """Return the law as the only stage."""
        return (NormalLawTerm(walls, self.law, penalty_stiffness(walls, modulus_of_body, self.multiple), reach),)


class NormalLawTerm(Term):
    """The energy of a law between all walls.

    Parameters
    ----------
    walls : Surface
        The walls.
    law : callable
        See `NormalLaw`.
    stiffness : array of float, shape (facets,)
        Stiffness of each facet [stress / length]; a pair takes the softer one.
    reach : float or array of float, shape (bodies,)
        Distance up to which walls are paired [length].
    """

    def __init__(self, walls: Surface, law: Law, stiffness: Array, reach: Reach) -> None:
        self.walls, self.stiffness, self.reach = walls, stiffness, reach
        self._law, self._search = law, PairSearch(walls, walls.quadrature, reach)

    @property
    def role(self) -> Role:
        """Contact acts between bodies."""
        return Role.INTERACTION

    def found(self, at: Configuration) -> GapKinematics:
        """Return the contact pairs at a configuration."""
        if self not in at.found:
            at.found[self] = self._kinematics(at.positions)
        found: GapKinematics = at.found[self]
        return found

    def _kinematics(self, positions: Array) -> GapKinematics:
        return gap_kinematics(self.walls, self._search.pairs(self.walls.nodes(positions)), positions)

    def _evaluated(self, pairs: ContactPairs, gap: Array) -> tuple[Array, Array, Array]:
        stiffness = np.minimum(self.stiffness[pairs.primary], self.stiffness[pairs.secondary])
        return self._law(gap, stiffness)

    def _weighted(self, at: Configuration) -> tuple[Array, Array, Array]:
        """Return energy, slope and bend of each pair, with half of its weight."""
        kinematics = self.found(at)
        parts = self._evaluated(kinematics.pairs, kinematics.gaps(at.positions))
        energy, slope, bend = (0.5 * kinematics.pairs.weight * part for part in parts)
        return energy, slope, bend

    def value(self, at: Configuration) -> float:
        """Return the energy of all pairs."""
        return float(self._weighted(at)[0].sum())

    def gradient(self, at: Configuration) -> Array:
        """Return its gradient, shape (unknowns,)."""
        return np.asarray(self._jacobian(at).T @ self._weighted(at)[1])

    def curvature(self, at: Configuration) -> sparse.coo_array:
        """Return its second derivative."""
        _, slope, bend = self._weighted(at)
        jacobian = self._jacobian(at)
        along = jacobian.T @ sparse.diags_array(bend) @ jacobian
        return (along + self.found(at).bending(at.positions, -slope)).tocoo()

    def _jacobian(self, at: Configuration) -> sparse.csr_array:
        kinematics = self.found(at)
        return kinematics.jacobian(kinematics.slopes(at.positions)[1], at.positions.shape[1])

    def couplings(self, at: Configuration, margin: float) -> tuple[Index, Index]:
        """Return the entries that pairs in reach may fill."""
        return couplings_of_near_facets(self.walls, at.positions, self.reach + margin)

    def interaction(self, at: Configuration) -> Interaction:
        """Return the contact forces, each on the body of the primary point."""
        kinematics, normal = self.found(at), -self._weighted(at)[1]
        _, slopes = kinematics.slopes(at.positions)
        facets = np.column_stack([kinematics.pairs.primary, kinematics.pairs.secondary])
        force = normal[:, None] * slopes[:, : len(at.positions)]
        return Interaction(self.walls.body[facets], facets, force, normal)

    def contact_pressures(self, at: Configuration, points: SurfacePoints) -> Array:
        """Return the nominal contact pressure [stress], >= 0: the sum of that of both walls."""
        pairs = PairSearch(self.walls, points, self.reach).pairs(self.walls.nodes(at.positions))
        _, slope, _ = self._evaluated(pairs, gap_kinematics(self.walls, pairs, at.positions).gaps(at.positions))
        return np.asarray(np.bincount(pairs.point, -slope, len(points.facet)), dtype=float)

    def overlap(self, at: Configuration) -> float:
        """Return the deepest overlap [length], >= 0."""
        return max(0.0, -float(self.found(at).gaps(at.positions).min(initial=0.0)))

    def checks(self, at: Configuration, scales: Scales) -> tuple[Check, ...]:
        """Return the largest tension: a law may press, and not pull."""
        slope = self._weighted(at)[1]
        meaning = "largest tensile contact force of a point over the force of a wall that is hardly strained"
        return (Check("tension", max(0.0, float(slope.max(initial=0.0))) / scales.force, 1e-9, meaning),)
