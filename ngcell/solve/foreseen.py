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
from ngcell.solve.problem import Linearisation
from ngcell.solve.proximal import ProximalTerm

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
    model, matrix = minimiser.assembly.model(state, line, minimum.proximal)
    return _taken(minimiser, place, line, (model, matrix), missed, enough, minimiser.options.inner)


def with_first_multipliers(minimiser: Minimiser, place: Array, proximal: ProximalTerm, share: float) -> Array:
    """Let multipliers be those by which walls do not overlap that a penalty has let overlap, and return the place where
    the first minimisation begins.

    What the multipliers have taken over from the penalty are its forces, and walls are still where it has let them:
    beginning there, a minimisation finds an equilibrium of pressures that hold only once walls have moved. The model
    leaves out what is not convex: about its start nothing is in balance. Nothing changes where that is too far away.

    Parameters
    ----------
    minimiser : Minimiser
        Of the problem, whose multipliers have taken over.
    place : array of float, shape (unknowns,)
        Where the penalty has led [length].
    proximal : ProximalTerm
        The proximal term of the first minimisation.
    share : float
        Share of the overlaps by which conditions may be missed within the model.
    """
    problem = minimiser.problem
    if not problem.has_multipliers or minimiser.is_iterative:
        return place
    state = problem.at(place)
    line = problem.linearise(state)
    model, matrix = minimiser.assembly.model(state, line, proximal)
    if model.is_bent:
        model = minimiser.assembly.convex(model, state)
    lowered = np.nan_to_num(_lowered(line))
    deepest = float(np.max(-(model.gap + lowered), initial=0.0))
    options = minimiser.options.foreseeing
    return _taken(minimiser, place, line, (model, matrix), deepest, share * deepest, options)


def _taken(
    minimiser: Minimiser,
    place: Array,
    line: Linearisation,
    system: tuple[OneSidedModel, Matrix],
    missed: float,
    enough: float,
    options: InnerOptions,
) -> Array:
    """Let multipliers be those that a model about a place foresees, and return where it ends; the place if there are
    none."""
    (model, matrix), lowered = system, _lowered(line)
    with minimiser.clock.phase("factorisation"):
        found = foreseen_multipliers(model, lowered, matrix, enough, options)
    minimiser.effort.iterations += 1
    minimiser.effort.factorisations += found.factorisations
    is_near = float(np.abs(found.step).max(initial=0.0)) <= minimiser.longest_step
    if not (is_near and found.missed < missed):
        return place
    has_multiplier = ~np.isnan(lowered)
    minimiser.problem.take_multipliers(line.keys[has_multiplier], found.lowered[has_multiplier])
    return minimiser.problem.move(place, found.step)


def _lowered(line: Linearisation) -> Array:
    """Return by how much multipliers lower gaps [length]; NaN where a constraint has none."""
    assert line.lowered is not None  # the problem has multipliers
    return line.lowered


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
