"""From an equilibrium on one mesh to the one beside it on a finer mesh: no path is followed, walls are settled already.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.conditions import until_conditions_hold
from ngcell.solve.continuation import Continuation
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.options import SolverOptions
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.recentred import at_rest, recentred
from ngcell.solve.rested import rested
from ngcell.solve.stability import stable_minimum

Array = NDArray[np.float64]

#: Share of the longest step below which an overlap is round-off, as between walls that end at one tied node.
_NOTHING = 1e-9


def settled(
    minimisers: Sequence[Minimiser],
    start: Array,
    *,
    softer: Sequence[Minimiser] = (),
    length: float,
    options: SolverOptions,
    path: Continuation | None = None,
    share: float | None = None,
) -> Minimum:
    """Return the minimum near a state that was found on a coarser mesh, as sure as its energy is asked for.

    What hardly changes its volume does so between the points that the coarser mesh had. Followed as it is, with a
    pressure from there that alternates from point to point, it takes hundreds of iterations; walls of smaller bulk
    moduli find back to constant volume, and each stage to the next in a handful.

    Parameters
    ----------
    minimisers : sequence of Minimiser
        Of the finer mesh: the last is of the problem that is meant, and those before it lead to its multipliers.
    start : array of float, shape (unknowns,)
        The state, with prescribed values in place [length].
    softer : sequence of Minimiser
        Of walls of smaller bulk moduli, which come first.
    length : float
        The length beside which missed conditions are judged [length].
    options : SolverOptions
        The solver's own numbers.
    path : Continuation, optional
        The continuation on this mesh, if bodies may float: the proximal term then holds them where they are.
    share : float, optional
        Decrement of the last minimisation, as a share of the energy; by default that of what is reported. At inf it is
        left out where bodies may float: the state is one from which the energy hardly falls any more.

    Notes
    -----
    Elements that turn out to be folded between the points of a quadrature rule get a finer one, by which they have no
    energy where they are: it is tried once more from the start. So it is where they fold on the way, and nothing is
    found.
    """
    once = partial(_settled_once, minimisers, start, softer, length=length, options=options, path=path, share=share)
    minimum = once()
    while minimum.ending is Ending.NO_DESCENT and minimisers[-1].problem.take_finer_rule(minimum.state):
        minimum = once()
    return once() if minimum.ending is Ending.NO_ENERGY else minimum


def _settled_once(
    minimisers: Sequence[Minimiser],
    start: Array,
    softer: Sequence[Minimiser],
    *,
    length: float,
    options: SolverOptions,
    path: Continuation | None,
    share: float | None,
) -> Minimum:
    minimum, before = None, None
    refined, weight = share or options.continuation.refined, path.scale * path.options.recentred if path else 0.0
    for minimiser in softer:
        held = ProximalTerm(weight, start)
        minimum = minimiser.minimise(start, held, options.handed_on * _magnitude(minimiser, start))
        if not minimum.is_found:
            return minimum
        start = minimum.state.displacement
    for minimiser in minimisers:
        if before is not None and minimum is not None:
            minimiser.problem.start_from(before.problem, minimum.state)
        is_last = minimiser is minimisers[-1] and not minimiser.problem.has_multipliers
        share = refined if is_last else options.handed_on  # multipliers that are still missed are not worth more
        if path is None:
            held = ProximalTerm(weight, start)
            minimum = minimiser.minimise(start, held, share * _magnitude(minimiser, start), is_settled=True)
        else:
            minimum = recentred(minimiser, start, weight, path.options, is_settled=True)
            if minimum.is_found and isfinite(share):
                minimum = at_rest(minimiser, minimum, path.scale, path.options.resting, path.options, share)
        if not minimum.is_found:
            return minimum
        start, before = minimum.state.displacement, minimiser
    assert minimum is not None
    last, to_fall = minimisers[-1], minimum.to_fall
    numbers = options.continuation if path is None else path.options
    minimum = until_conditions_hold(last, minimum, length, numbers)
    enough = refined * last.problem.magnitude(minimum.state)
    if minimum.is_found and minimum.decrement > enough:
        exact = last.minimise(minimum.state.displacement, minimum.proximal, enough)
        minimum = until_conditions_hold(last, exact, length, numbers) if exact.is_found else exact
    return replace(minimum, to_fall=to_fall)


def _magnitude(minimiser: Minimiser, place: Array) -> float:
    return minimiser.problem.magnitude(minimiser.problem.at(place))


def stable(
    minimiser: Minimiser, minimum: Minimum, *, length: float, options: SolverOptions, path: Continuation
) -> Minimum:
    """Return a minimum below a saddle, at rest on the path; what is no saddle is told its lowest curvature."""

    def until_rested(below: Minimum) -> Minimum:
        return rested(minimiser, below, path.scale, path.options)

    return stable_minimum(minimiser, minimum, until_rested, options.stability, scale=path.scale, length=length)


def has_contact(minimisers: Sequence[Minimiser], displacement: Array) -> bool:
    """Return whether constraints of the last problem are violated at a displacement; no problem has none."""
    if not minimisers:
        return False
    problem = minimisers[-1].problem
    _, gaps = problem.gaps(problem.at(displacement))
    return bool((gaps < -_NOTHING * minimisers[-1].longest_step).any())
