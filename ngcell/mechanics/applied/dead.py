"""Dead loads that depend on the place: their potential is linear, and integrated once."""

from __future__ import annotations

from collections.abc import Sequence

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.applied.body_force import BodyForce
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.applied.protocol import AppliedLoad
from ngcell.mechanics.applied.traction import Traction
from ngcell.mechanics.drive import Drive
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.swept import swept_by
from ngcell.mechanics.symbolic import EnergyForm, Integrals
from ngcell.mechanics.term import Configuration, Role, Term

Array = NDArray[np.float64]


class DeadLoads(Term):
    """Tractions and body forces that are functions of the place at rest, as nodal forces.

    A function may be long, and is evaluated at each point of the quadrature rule; here that happens once, and not in
    each energy and gradient.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    loads : sequence of Traction or BodyForce
        The loads; those on the same boundary or body add up.

    Raises
    ------
    CaseError
        If a vector has another dimension than the bodies.
    """

    def __init__(self, space: DisplacementSpace, loads: Sequence[Traction | BodyForce]) -> None:
        for load in loads:
            load.check(space.dimension)
        swept, self._factor = swept_by(space, {}), 0.0

        def integrals(displacement: ngsolve.CoefficientFunction) -> Integrals:
            return [load.density(space, displacement, swept) * load.region(space) for load in loads]

        self._slope = EnergyForm(space, integrals).gradient(np.zeros(space.unknowns))

    @property
    def role(self) -> Role:
        """Loads act from outside."""
        return Role.LOAD

    def apply(self, load_factor: float) -> None:
        """Set the load factor of the potential."""
        self._factor = load_factor

    def value(self, at: Configuration) -> float:
        """Return the potential [stress * length**2]; zero at rest."""
        return self._factor * float(self._slope @ at.displacement)

    def gradient(self, at: Configuration) -> Array:
        """Return minus the nodal forces, shape (unknowns,)."""
        return self._factor * self._slope

    def unstored(self, at: Configuration) -> float:
        """Return the potential: none of it is stored in bodies."""
        return self.value(at)

    def drive(self, at: Configuration, load_factor: float) -> Drive:
        """Return the load factor, and the potential of the full loads."""
        return Drive(load_factor, float(self._slope @ at.displacement), 0.0)


def terms_of_loads(
    space: DisplacementSpace, loads: Sequence[AppliedLoad], motion: PrescribedMotion
) -> tuple[AppliedLoads | DeadLoads, ...]:
    """Return the terms of loads: one of dead loads that depend on the place, and one of all others."""
    dead, others = list[Traction | BodyForce](), list[AppliedLoad]()
    for load in loads:
        if isinstance(load, (Traction, BodyForce)) and callable(load.vector):
            dead.append(load)
        else:
            others.append(load)
    terms = [AppliedLoads(space, others, motion)] if others else []
    return (*terms, DeadLoads(space, dead)) if dead else tuple(terms)
