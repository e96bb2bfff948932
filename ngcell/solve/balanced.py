"""Forces that a minimum leaves out of balance: a decrement that is nothing beside the energy may leave some.

A force f that acts against a stiffness k lowers the energy by ``f^2 / 2 k``, which is the smaller the stiffer walls in
contact are. A certificate judges forces.
"""

from __future__ import annotations

import logging

import numpy as np

from ngcell.solve.continuation_options import ContinuationOptions
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.recentred import energy_of_nothing, minimised

_log = logging.getLogger(__name__)


def out_of_balance(minimiser: Minimiser, minimum: Minimum) -> float:
    """Return the norm of the forces out of balance over that of the forces in bodies; 0 where there are none."""
    problem, state = minimiser.problem, minimum.state
    whole = problem.gradient(state)
    left = whole + minimum.proximal.gradient(state.displacement, problem.metric)
    size = float(np.linalg.norm(whole - problem.gradient_of_constraints(state)))
    return float(np.linalg.norm(left[problem.free])) / size if size else 0.0


def in_balance(minimiser: Minimiser, minimum: Minimum, scale: float, options: ContinuationOptions) -> Minimum:
    """Return a minimum whose forces are balanced as far as a certificate asks, and farther than a decrement tells.

    Decrements are as the squares of forces. Where last digits let none be found, at kinks, and where nothing is
    strained, the minimum stays as it is. `scale` [stress / length**2] is that of the weight of the proximal term.
    """
    is_strained = minimiser.problem.magnitude(minimum.state) > energy_of_nothing(minimiser, options)
    if minimum.ending is not Ending.CONVERGED or not is_strained:
        return minimum
    left = out_of_balance(minimiser, minimum)
    if left <= options.unbalanced:
        return minimum
    _log.info("forces are out of balance by %.1e", left)
    place, held = minimum.state.displacement, minimum.proximal
    enough = minimum.decrement * (options.unbalanced / left) ** 2
    found, _ = minimised(minimiser, place, held, 0.0, held.weight / scale, enough, options.cycling, is_settled=True)
    return found if found.is_found and out_of_balance(minimiser, found) < left else minimum


def balanced(
    minimiser: Minimiser, minimum: Minimum, energy: float, options: ContinuationOptions, name: float
) -> Minimum:
    """Return the minimum by the last multipliers, where their update has pushed it farther than a last minimisation
    may leave it: fluids that hardly store energy press by some 1e-6 of the forces more."""
    enough = options.refined * minimiser.problem.magnitude(minimum.state)
    if energy <= enough:
        return minimum
    start = minimum.state.displacement
    found, _ = minimised(minimiser, start, minimum.proximal, 0.0, name, enough, options.cycling)
    return found if found.is_found else minimum
