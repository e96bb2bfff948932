"""Where a minimisation ends, and what pulls at it on the way."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.problem import State

Array = NDArray[np.float64]


class Ending(Enum):
    """How a minimisation ended."""

    CONVERGED = "converged"
    STALLED = "forces are round-off, or steps go to and fro at a kink"
    TOO_MANY_ITERATIONS = "too many iterations"
    NO_DESCENT = "no step lowers the energy"
    NO_ENERGY = "elements are inverted at the start"
    CONDITIONS_MISSED = "contact conditions are not met"


@dataclass(frozen=True, eq=False)
class ProximalTerm:
    """Weak penalty terms to an centre: ``weight/2 |u - centre|^2`` in the mass norm.

    Attributes
    ----------
    weight : float
        Stiffness per reference volume [stress / length**2], >= 0.
    centre : array of float, shape (unknowns,)
        Where the penalty terms are at rest [length].
    """

    weight: float
    centre: Array


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a minimisation ended.

    Attributes
    ----------
    state : State
        The last accepted state.
    ending : Ending
        How it ended.
    decrement : float
        Newton decrement ``g K^-1 g`` [energy] of the last step.
    proximal term : ProximalTerm
        What pulled at it.
    """

    state: State
    ending: Ending
    decrement: float
    proximal: ProximalTerm

    @property
    def is_found(self) -> bool:
        """Whether there is a minimum, as far as the minimisation can tell."""
        return self.ending in (Ending.CONVERGED, Ending.STALLED)
