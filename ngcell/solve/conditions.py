"""Conditions of contact: multipliers are updated and the energy is minimised in turn, until they hold."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from ngcell.solve.balanced import balanced
from ngcell.solve.continuation_options import ContinuationOptions
from ngcell.solve.foreseen import with_foreseen_multipliers
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.recentred import minimised

_log = logging.getLogger(__name__)


def until_conditions_hold(
    minimiser: Minimiser,
    minimum: Minimum,
    length: float,
    options: ContinuationOptions,
    *,
    name: float = 0.0,
    most: int | None = None,
) -> Minimum:
    """Update multipliers and minimise in turn until what is missed is nothing beside `length`.

    Where the active set cycles, it goes on for at most so many iterations. Where nothing to speak of is missed, no
    minimisation is more exact than that asks for, and where no step lowers the energy, as at a kink, it ends there.
    Multipliers are foreseen where an accuracy is asked for: those that updates approach slowly, as of confined walls,
    then miss by some times what is judged, which is nothing beside the accuracy. Without one they are updated one by
    one.
    """
    before, was_increased, spent = float("inf"), False, minimiser.effort.iterations
    for _ in range(options.most_updates):
        met = _met(minimiser, minimum, options.condition * length, options.missed_work)
        missed, energy = minimiser.problem.update_multipliers(minimum.state)
        nothing = options.nothing * minimiser.problem.magnitude(minimum.state)
        is_nothing = 0 < energy <= nothing
        helpless = was_increased and missed > before / 2 and is_nothing
        is_met = missed <= met or helpless
        if is_met and not minimiser.problem.take_finer_rule(minimum.state):
            return minimum if helpless else balanced(minimiser, minimum, energy, options, name)
        _log.info("conditions missed by %.1e%s", missed, "; a finer quadrature rule follows" if is_met else "")
        was_increased = not is_met and missed > options.slow * before
        if was_increased:
            minimiser.problem.increase_penalty()
        before = float("inf") if is_met else missed  # by a finer rule, what was missed before says nothing
        start, tolerance = minimum.state.displacement, options.update * (nothing if is_nothing else energy)
        if options.sufficient:
            start = with_foreseen_multipliers(minimiser, minimum, missed, max(options.foreseen * missed, met / 10))
        last = minimum
        minimum, _ = minimised(minimiser, start, minimum.proximal, options.at_the_end, name, tolerance, options.cycling)
        if minimum.ending is Ending.NO_DESCENT and is_nothing:
            state = minimiser.problem.at(last.state.displacement)
            ending = Ending.STALLED if options.sufficient else last.ending  # where no accuracy is asked for, it goes on
            return replace(last, state=state, ending=ending, decrement=minimum.decrement)
        if not minimum.is_found:
            return minimum
        cycles = minimum.ending is Ending.STALLED
        if cycles and most is not None and minimiser.effort.iterations - spent > most:
            break
    return replace(minimum, ending=Ending.CONDITIONS_MISSED)


def _met(minimiser: Minimiser, minimum: Minimum, length: float, share: float) -> float:
    """Return the length by which conditions may be missed: less than a length where walls are so stiff that the work of
    contact pressures on it would be more than a share of the energy."""
    problem, state = minimiser.problem, minimum.state
    if not problem.has_multipliers:
        return length
    force = float(np.abs(problem.gradient_of_constraints(state)).sum())
    return length if not force else min(length, share * problem.magnitude(state) / force)
