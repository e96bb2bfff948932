"""Where a minimisation goes next, and where it ends."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.problem import State
from ngcell.solve.proximal import ProximalTerm


class Ending(Enum):
    """How a minimisation ended."""

    CONVERGED = "converged"
    STALLED = "forces are round-off, or steps go to and fro at a kink"
    TOO_MANY_ITERATIONS = "too many iterations"
    NO_DESCENT = "no step lowers the energy"
    NO_ENERGY = "elements are inverted at the start"
    SADDLE = "a saddle, and so were all that lie below it"
    SLID = "walls slide away from where a penalty has led"
    CONDITIONS_MISSED = "contact conditions are not met"


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
    proximal : ProximalTerm
        What held floating bodies.
    to_fall : float
        By how much the energy may still fall while bodies that hardly anything holds move on [energy].
    lowest_curvature : float, optional
        Lowest eigenvalue of the tangent, closed contacts held closed, as a multiple of the scale of the continuation;
        None where it is not known. Where the tangent is negative but the energy does not fall, as at a kink, that of
        the energy.
    slid_from : array of float, shape (unknowns,), optional
        The displacement under a firm proximal term, from which walls were followed to rest [length]; None where they
        were not.
    """

    state: State
    ending: Ending
    decrement: float
    proximal: ProximalTerm
    to_fall: float = 0.0
    lowest_curvature: float | None = None
    slid_from: NDArray[np.float64] | None = None

    @property
    def is_found(self) -> bool:
        """Whether there is a minimum, as far as the minimisation can tell."""
        return self.ending in (Ending.CONVERGED, Ending.STALLED)


@dataclass(frozen=True, eq=False)
class Advance:
    """The next iterate.

    Attributes
    ----------
    state : State
        The iterate.
    damping : array of float, shape (bodies,)
        The damping of each body to go on with.
    decrement : float
        The Newton decrement [energy].
    was_damped : bool
        Whether damping led here, or a model that is not convex.
    misfit : float
        The share of its decrease by which the model was off.
    force : float
        The norm of the forces before.
    step : array of float, shape (unknowns,), or None
        The step as the model had it [length].
    """

    state: State
    damping: NDArray[np.float64]
    decrement: float
    was_damped: bool
    misfit: float = inf
    force: float = nan
    step: NDArray[np.float64] | None = None

    def was_held(self, longest: float) -> bool:
        """Return whether damping led here, and not since a step would have been longer than the longest [length].

        A step that is damped to be no longer has about that length; half of it tells them apart.
        """
        return self.was_damped and self.step is not None and bool(np.abs(self.step).max() < longest / 2)
