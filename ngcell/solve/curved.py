"""Steps that follow the curvature of gaps, and their kinks: a second-order correction.

Cells that slide or roll on each other move along curves. What the gaps after a step turned out to be beyond their
linear parts is added to the penalty terms, and the model is minimised again. Where gaps have kinks that the step went
over, the model has penalty terms for these instead.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.newton import Newton
from ngcell.solve.one_sided import Matrix, OneSidedModel
from ngcell.solve.problem import Linearisation, Problem, State

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(eq=False)
class Curved:
    """What steps from one state have told of its gaps.

    Parameters
    ----------
    problem : Problem
        The problem.
    newton : Newton
        What finds steps.
    state, line : State, Linearisation
        Where steps begin, and the problem about it.
    """

    problem: Problem
    newton: Newton
    state: State
    line: Linearisation
    _over: Index = field(default_factory=lambda: np.zeros(0, dtype=np.int64), init=False)
    _has_new: bool = field(default=False, init=False)

    def with_kinks(self, model: OneSidedModel, trial: State) -> OneSidedModel:
        """Return a model with the kinks that the step to a state went over, and that it does not have yet."""
        found = self.problem.kinks(self.state, trial) if np.isfinite(trial.energy) else None
        new = np.zeros(0, dtype=np.int64) if found is None else np.flatnonzero(~np.isin(found.keys, self._over))
        self._has_new = len(new) > 0
        if found is None or not self._has_new:
            return model
        self._over = np.concatenate([self._over, found.keys[new]])
        return model.with_more(found.gap[new], found.jacobian[new], found.penalty[new])

    def corrected(
        self, system: tuple[OneSidedModel, Matrix], step: Array, trial: State, lacking: float
    ) -> Array | None:
        """Return a step that follows the curvature of gaps; None where it is of no use.

        It wins back what the penalty terms store beyond the model; where the energy that is `lacking` is more, it is
        tried only if the model has new kinks. What their constraints turned out to be is not added.

        Parameters
        ----------
        system : (OneSidedModel, Matrix)
            The model, and what solves for it.
        step : array of float, shape (unknowns,)
            A step that lowered the energy by too little [length].
        trial : State
            The state after it.
        lacking : float
            What was lacking [energy].
        """
        model, matrix = system
        if not np.isfinite(trial.energy) or not len(model.gap):
            return None
        keys, gaps = self.problem.gaps(trial)
        if not len(keys):
            return None
        foreseen, surplus = model.gap + model.jacobian @ step, np.zeros_like(model.gap)
        mine = self.line.keys
        place = np.minimum(np.searchsorted(keys, mine), len(keys) - 1)
        known, own = keys[place] == mine, slice(len(mine))  # the penalty terms of kinks come after these
        surplus[own] = np.where(known, gaps[place] - foreseen[own], 0.0)
        if not known.any() or float(np.abs(surplus).max()) > self.newton.longest_step:
            return None
        if not self._has_new and model.stored(foreseen + surplus) - model.stored(foreseen) <= lacking:
            return None
        surplus[own][np.isin(mine, self._over)] = 0.0
        bent = self.newton.step(replace(model, gap=model.gap + surplus), matrix)
        return bent.step if bent.change <= 0 else None
