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


def corrected(
    problem: Problem,
    newton: Newton,
    line: Linearisation,
    system: tuple[OneSidedModel, Matrix],
    step: Array,
    trial: State,
    lacking: float,
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
    """
    model, matrix = system
    if not np.isfinite(trial.energy) or not len(model.gap):
        return None
    foreseen = model.gap + model.jacobian @ step
    keys, gaps = problem.gaps(trial)
    place = np.minimum(np.searchsorted(keys, line.keys), max(len(keys) - 1, 0))
    known = keys[place] == line.keys if len(keys) else np.zeros(len(line.keys), dtype=bool)
    surplus = np.where(known, gaps[place] - foreseen, 0.0) if len(keys) else np.zeros_like(foreseen)
    if not known.any() or float(np.abs(surplus).max()) > newton.longest_step:
        return None
    if model.stored(foreseen + surplus) - model.stored(foreseen) <= lacking:
        return None
    bent = newton.step(replace(model, gap=model.gap + surplus), matrix)
    return bent.step if bent.change <= 0 else None
