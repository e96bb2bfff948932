"""From an equilibrium on one mesh to the one beside it on a finer mesh: no path is followed, walls are settled already.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.continuation import until_conditions_hold
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Minimum
from ngcell.solve.options import SolverOptions
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.stability import stable_minimum

Array = NDArray[np.float64]


def settled(
    minimisers: Sequence[Minimiser],
    start: Array,
    proximal: ProximalTerm,
    *,
    length: float,
    options: SolverOptions,
) -> Minimum:
    """Return the minimum near a state that was found on a coarser mesh.

    Parameters
    ----------
    minimisers : sequence of Minimiser
        Of the finer mesh: the last is of the problem that is meant, and those before it lead to its multipliers.
    start : array of float, shape (unknowns,)
        The state, with prescribed values in place [length].
    proximal : ProximalTerm
        What held floating bodies, and holds them still.
    length : float
        The length beside which missed conditions are judged [length].
    options : SolverOptions
        The solver's own numbers.
    """
    minimum, before = None, None
    for minimiser in minimisers:
        if before is not None and minimum is not None:
            minimiser.problem.start_from(before.problem, minimum.state)
        share = options.refined if minimiser is minimisers[-1] else options.handed_on
        enough = share * abs(minimiser.problem.at(start).energy)
        minimum = minimiser.minimise(start, proximal, enough)
        if not minimum.is_found:
            return minimum
        start, before = minimum.state.displacement, minimiser
    last = minimisers[-1]
    assert minimum is not None
    return until_conditions_hold(last, minimum, length, options.continuation)


def stable(
    minimiser: Minimiser, minimum: Minimum, *, scale: float, length: float, options: SolverOptions
) -> Minimum:
    """Return a minimum below a saddle, with contact conditions met; what is no saddle is told its lowest curvature."""

    def until_met(below: Minimum) -> Minimum:
        return until_conditions_hold(minimiser, below, length, options.continuation)

    return stable_minimum(minimiser, minimum, until_met, options.stability, scale=scale, length=length)


def has_contact(minimisers: Sequence[Minimiser], displacement: Array, load: float) -> bool:
    """Return whether constraints of the last problem are violated at a displacement; no problem has none."""
    if not minimisers:
        return False
    problem = minimisers[-1].problem
    problem.apply(load)
    _, gaps = problem.gaps(problem.at(displacement))
    return bool((gaps < 0).any())
