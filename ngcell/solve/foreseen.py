"""Multipliers that a second-order model foresees.

At an equilibrium each update of multipliers takes a minimisation, for what may be a change of the eighth digit. The
model of the energy knows as much: within it, an update takes a solution with a matrix that is factorised already. So
updates go on within the model until its conditions hold, and the next minimisation begins where it ends, with those
multipliers. Only what is of second order in the way there is left to it.

An update is a step along the gradient of the dual problem, of a length that never overshoots. Accelerated (Beck and
Teboulle 2009, doi:10.1137/080716542), and begun anew where steps go back (O'Donoghue and Candes 2015,
doi:10.1007/s10208-013-9150-3), updates also meet conditions of confined walls, which are slow one by one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.inner import Descent
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Minimum
from ngcell.solve.one_sided import Matrix, OneSidedModel
from ngcell.solve.options import InnerOptions

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Foreseen:
    """Where the conditions of a model hold, or nearly so.

    Attributes
    ----------
    step : array of float, shape (unknowns,)
        The way there [length].
    lowered : array of float, shape (constraints,)
        By how much multipliers lower gaps there [length]; 0 where a constraint has none.
    missed : float
        By how much conditions are missed there [length].
    factorisations : int
        What it took.
    """

    step: Array
    lowered: Array
    missed: float
    factorisations: int


def with_foreseen_multipliers(minimiser: Minimiser, minimum: Minimum, missed: float, enough: float) -> Array:
    """Let multipliers be those that are foreseen, and return the place where the next minimisation begins.

    Nothing changes where no gap is lowered by multipliers, or where what is foreseen is too far away, or no better.

    Parameters
    ----------
    minimiser : Minimiser
        Of the problem, whose multipliers have been updated.
    minimum : Minimum
        The equilibrium.
    missed, enough : float
        By how much conditions are missed, and may be missed within the model [length].
    """
    place, problem = minimum.state.displacement, minimiser.problem
    if not problem.has_multipliers or minimiser.is_iterative:
        return place
    state = problem.at(place)
    line = problem.linearise(state)
    assert line.lowered is not None  # the problem has multipliers
    model, matrix = minimiser.assembly.model(state, line, minimum.proximal)
    with minimiser.clock.phase("factorisation"):
        found = foreseen_multipliers(model, line.lowered, matrix, enough, minimiser.options.inner)
    minimiser.effort.iterations += 1
    minimiser.effort.factorisations += found.factorisations
    is_near = float(np.abs(found.step).max(initial=0.0)) <= minimiser.longest_step
    if not (is_near and found.missed < missed):
        return place
    has_multiplier = ~np.isnan(line.lowered)
    problem.take_multipliers(line.keys[has_multiplier], found.lowered[has_multiplier])
    return problem.move(place, found.step)


def foreseen_multipliers(
    model: OneSidedModel, lowered: Array, matrix: Matrix, missed: float, options: InnerOptions
) -> Foreseen:
    """Return multipliers with which the conditions of a model hold.

    Parameters
    ----------
    model : OneSidedModel
        The model, with gaps that are lowered.
    lowered : array of float, shape (constraints,)
        By how much multipliers lower its gaps [length]; NaN where a constraint has none.
    matrix : Matrix
        What solves for it.
    missed : float
        By how much conditions may be missed [length].
    options : InnerOptions
        The numbers of the inner problem.
    """
    reduced = matrix.reduced(model)
    left, within = (model, matrix) if reduced is None else (reduced.model, reduced.matrix)
    descent, has_multiplier = Descent(left, within, options.lost), ~np.isnan(lowered)
    found = ahead = np.where(has_multiplier, lowered, 0.0)
    gap, pace, off = model.gap + ahead, 1.0, np.inf
    for _ in range(options.most_updates):
        if off <= missed or descent.factorisations > options.most_rounds:
            break
        if not descent.advance(gap - ahead):
            continue
        before, found = found, np.where(has_multiplier, np.maximum(-descent.gap, 0.0), 0.0)
        off = float(np.abs(found - ahead).max(initial=0.0))
        goes_back = float(model.penalty * (ahead - found) @ (found - before)) > 0
        pace, last = (1.0, 1.0) if goes_back else ((1 + (1 + 4 * pace**2) ** 0.5) / 2, pace)
        ahead = found + (last - 1) / pace * (found - before)
    step = descent.step if reduced is None else reduced.whole(descent.step)
    return Foreseen(step, found, off, descent.factorisations)
