"""Trial steps from a state: where they lead, and by how much the energy falls along them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.last_digits import Rounding
from ngcell.solve.problem import Problem, State
from ngcell.solve.proximal import ProximalTerm

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Trials:
    """Trial steps from one state.

    Attributes
    ----------
    problem : Problem
        What is minimised.
    at : function
        Returns the state at a displacement.
    state : State
        Where steps begin.
    proximal : ProximalTerm
        The proximal term.
    rounding : Rounding
        The last digits that a place loses.
    energy : float
        The energy at the state, with that of the proximal term.
    """

    problem: Problem
    at: Callable[[Array], State]
    state: State
    proximal: ProximalTerm
    rounding: Rounding
    energy: float

    def after(self, step: Array) -> tuple[State, float]:
        """Return the state after a step, and by how much its energy is lower."""
        trial = self.at(self.rounding.of(self.problem.move(self.state.displacement, step)))
        return trial, self.energy - trial.energy - self.proximal.value(trial.displacement, self.problem.metric)

    def farther(self, step: Array, found: tuple[State, float], longest: float) -> tuple[State, float]:
        """Return the state after a step, which is `found`, or after twice, four times, ... as long a one while the
        energy falls on and no displacement changes by more than `longest` [length]."""
        while 2 * float(np.abs(step).max()) <= longest:
            step = 2 * step
            trial, gain = self.after(step)
            if not gain > found[1]:
                break
            found = trial, gain
        return found
