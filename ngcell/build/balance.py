"""Balance before anything is solved: loads that nothing can balance are told, and whether bodies at rest are in
equilibrium.

What bodies exert on each other adds up to nothing. So where no support holds any body in a direction, the sum of all
loads in that direction has to vanish, and where nothing is held at all their moment, too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import CaseError
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Role, Term
from ngcell.problem.problem import Problem

Array = NDArray[np.float64]

#: Share of all nodal forces of the loads that is the round-off of their sum, or the quadrature of curved boundaries.
_NOTHING = 1e-6
#: Forces at rest, as shares of modulus and thickness, and overlaps, as shares of the thickness, that count as none:
#: round-off, and what curved elements of two meshes leave between them.
_NO_FORCE, NO_OVERLAP = 1e-8, 1e-3


def check_balance(space: DisplacementSpace, terms: Sequence[Term], fixed: NDArray[np.bool_]) -> None:
    """Check that supports can balance the loads at rest.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    terms : sequence of Term
        All terms of the energy.
    fixed : array of bool, shape (dimension, size)
        Unknowns with prescribed displacement.

    Raises
    ------
    CaseError
        If the loads have a sum, or a moment, that no support holds.
    """
    free = [axis for axis in range(space.dimension) if not fixed[axis].any()]
    if not free:
        return
    force = load_at_rest(space, terms)
    largest = _NOTHING * float(np.abs(force).sum())
    for axis in free:
        total = float(force[axis] @ space.one)
        if abs(total) > largest:
            raise CaseError(
                f"loads: their sum along {'xyz'[axis]} is {total:.6g}, and nothing balances it; "
                f"allowed: a support that holds a body along {'xyz'[axis]}, or loads that balance each other"
            )
    if len(free) == space.dimension == 2:
        x, y = space.rest
        moment = float(force[1] @ x - force[0] @ y)
        if abs(moment) > largest * space.bodies.length:
            raise CaseError(
                f"loads: their moment is {moment:.6g}, and nothing balances it; "
                "allowed: a support that holds a body, or loads that balance each other"
            )


def is_balanced_at_rest(apart: Problem, motion: PrescribedMotion, modulus: float) -> bool:
    """Return whether bodies at rest are in equilibrium before the load, contact aside.

    Parameters
    ----------
    apart : Problem
        The bodies without contact.
    motion : PrescribedMotion
        Their supports.
    modulus : float
        Shear modulus of the softest wall [stress].
    """
    apart.apply(0.0)
    rest = apart.at(motion.imposed(np.zeros(apart.space.unknowns), 0.0))
    force = float(np.abs(apart.gradient(rest)[apart.free]).max(initial=0.0))
    bodies = apart.space.bodies
    return force <= _NO_FORCE * modulus * bodies.thickness ** (bodies.dimension - 1)


def load_at_rest(space: DisplacementSpace, terms: Sequence[Term]) -> Array:
    """Return the nodal forces of loads in full on bodies at rest, shape (dimension, size)."""
    at, force = space.configuration(np.zeros(space.unknowns)), np.zeros(space.unknowns)
    for term in terms:
        if term.role is Role.LOAD:
            term.apply(1.0)
            force -= term.gradient(at)
            term.apply(0.0)
    return force.reshape(space.dimension, -1)
