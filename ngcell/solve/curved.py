"""Steps that follow the curvature of gaps: a second-order correction.

Cells that slide or roll on each other move along curves. What the gaps after a step turned out to be beyond their
linear parts is added to the penalty terms, and the model is minimised again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.newton import Newton
from ngcell.solve.one_sided import Matrix, OneSidedModel
from ngcell.solve.problem import Linearisation, Problem, State

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def corrected(
    problem: Problem,
    newton: Newton,
    line: Linearisation,
    system: tuple[OneSidedModel, Matrix],
    step: Array,
    trial: State,
    lacking: float,
    over: Index,
) -> Array | None:
    """Return a step that follows the curvature of gaps; None where it is of no use.

    It wins back what the penalty terms store beyond the model; where the energy that is `lacking` is more, it is
    not tried.

    Parameters
    ----------
    problem : Problem
        The problem.
    newton : Newton
        What finds steps.
    line, system : Linearisation, (OneSidedModel, Matrix)
        The problem about the state before the step, its model, and what solves for it.
    step : array of float, shape (unknowns,)
        A step that lowered the energy by too little [length].
    trial : State
        The state after it.
    lacking : float
        What was lacking [energy].
    over : array of int
        Keys of constraints whose kinks the model has: what they turned out to be is not added.
    """
    model, matrix = system
    if not np.isfinite(trial.energy) or not len(model.gap):
        return None
    foreseen, surplus = model.gap + model.jacobian @ step, np.zeros_like(model.gap)
    keys, gaps = problem.gaps(trial)
    place = np.minimum(np.searchsorted(keys, line.keys), max(len(keys) - 1, 0))
    known = keys[place] == line.keys if len(keys) else np.zeros(len(line.keys), dtype=bool)
    if not known.any():
        return None
    own = slice(len(known))  # those of kinks come after them
    surplus[own] = np.where(known, gaps[place] - foreseen[own], 0.0)
    if float(np.abs(surplus).max()) > newton.longest_step:
        return None
    if model.stored(foreseen + surplus) - model.stored(foreseen) <= lacking:
        return None
    surplus[own][np.isin(line.keys, over)] = 0.0
    bent = newton.step(replace(model, gap=model.gap + surplus), matrix)
    return bent.step if bent.change <= 0 else None
