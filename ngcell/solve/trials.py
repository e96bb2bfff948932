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

#: Slope along a step that is left at its end, over that at its start, above which the step has gone too far; and how
#: often forces are looked at for where it should have ended.
_TOO_FAR, _MOST_LOOKS = 0.25, 8


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

    def balanced(
        self, step: Array, slope: float, found: State, force: Callable[[State, ProximalTerm], Array]
    ) -> State:
        """Return the state after a step, which is `found`, or where forces along the step vanish if it goes too far.

        Forces tell that where differences of energies are round-off. Steps that go too far may go to and fro between
        the two sides of a kink of the forces, as where bonds change from pull to pressure. `slope` is the energy's
        along the step where it begins [energy]; `force` returns the gradient with that of the proximal term.
        """

        def slope_at(state: State) -> float:
            return float(force(state, self.proximal) @ step)

        low, high = (0.0, slope), (1.0, slope_at(found))
        last, flat = high[1], -_TOO_FAR * low[1]
        for _ in range(_MOST_LOOKS):
            if not abs(last) > flat > 0 or high[1] <= 0:
                break
            share = low[0] + (high[0] - low[0]) * low[1] / (low[1] - high[1])
            found, _ = self.after(share * step)
            last = slope_at(found)
            low, high = (low, (share, last)) if last > 0 else ((share, last), high)
        return found
