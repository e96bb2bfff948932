"""SDDP, the successive deformation decomposition procedure.

At each level the tissue first deforms as one tied solid, then its walls are released from that state, which is the
centre of the release. Tied states follow each other; every release starts from its own tied state, so a level
does not depend on the levels before it.

The continuation yields the steps that were accepted, and stops when one cannot be. It may be taken up after any number of them,
from the last tied displacement.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.continuation import until_conditions_hold
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Minimum, ProximalTerm
from ngcell.solve.outcome import Outcome
from ngcell.solve.released import Released
from ngcell.solve.step import MOST_HALVINGS, Accepted, Account, Motion, StepFailed, next_goal, spent

Array = NDArray[np.float64]


def tied_then_released(
    tied: Sequence[Minimiser],
    released: Released,
    motion: Motion,
    *,
    steps: Sequence[float],
    levels: Sequence[float],
    done: int = 0,
    last_tied: Array | None = None,
) -> Iterator[Accepted]:
    """Yield the tied state of every step, and after it, at the levels, the released state.

    Parameters
    ----------
    tied : sequence of Minimiser
        The tied solid, from the softest volume to the one that is meant.
    released : Released
        The released walls.
    motion : Motion
        The prescribed motion.
    steps, levels : sequence of float
        Load factors, in the order of the load path; the levels are among the steps.
    done : int
        Number of accepted steps to go on after.
    last_compact : array of float, shape (unknowns,), optional
        The last tied displacement among these [length].

    Raises
    ------
    StepFailed
        If a step finds no equilibrium.
    """
    schedule = list(_schedule(steps, levels))
    load = schedule[done - 1][1] if done else 0.0
    displacement = motion.lifting(0.0) if last_tied is None else last_tied
    for phase, target in schedule[done:]:
        if phase == "tied":
            step = _tied_step(tied, motion, displacement, load, target, released)
            load, displacement = target, step.minimum.state.displacement
            yield step
        else:
            start = tied[-1].problem.expand(displacement)
            centre = motion.lifting(target) if motion.has_lifting else start
            if released.history is None:
                yield released.step(start, centre, target)
            else:
                released.history.forget()
                energy = tied[-1].problem.at(displacement).energy
                yield _with_loss(released, released.step(start, centre, target), energy)


def _with_loss(released: Released, step: Accepted, tied_energy: float) -> Accepted:
    """Return a step that let a tied state go at held supports: what the energy fell by is lost."""
    assert released.history is not None
    released.history.advance(step.minimum.state.displacement)
    lost = tied_energy - step.minimum.state.energy
    gained = max(-lost, 0.0)
    share = gained / max(abs(tied_energy), np.finfo(float).tiny)
    return replace(step, account=Account(max(lost, 0.0), gained, share))


def _schedule(steps: Sequence[float], levels: Sequence[float]) -> Iterator[tuple[str, float]]:
    """Yield phase and load factor of every step."""
    for target in steps:
        yield "tied", target
        if any(np.isclose(target, level) for level in levels):
            yield "contact", target


def _tied_step(
    tied: Sequence[Minimiser],
    motion: Motion,
    displacement: Array,
    load: float,
    target: float,
    released: Released,
) -> Accepted:
    before, reached, increment, halvings = spent(tied), load, target - load, 0
    while True:
        goal = next_goal(reached, increment, target)
        start = displacement + motion.lifting(goal) - motion.lifting(reached)
        proximal = ProximalTerm(0.0, start)
        if released.loads is not None:
            released.loads.apply(goal)
        minimum = _tied_minimum(tied, motion.imposed(start, goal), proximal)
        if minimum.is_found:
            minimum = until_conditions_hold(tied[-1], minimum, released.longest_step)
        if minimum.is_found:
            displacement, reached = minimum.state.displacement, goal
            if reached == target:
                return Accepted("tied", target, minimum, spent(tied) - before)
            continue
        increment, halvings = increment / 2, halvings + 1
        tied[-1].effort.cutbacks += 1
        if halvings > MOST_HALVINGS:
            raise StepFailed(Outcome.TIED_FAILED, goal)


def _tied_minimum(tied: Sequence[Minimiser], start: Array, proximal: ProximalTerm) -> Minimum:
    for minimiser in tied:
        minimum = minimiser.minimise(start, proximal)
        if not minimum.is_found:
            break
        start = minimum.state.displacement
    return minimum
