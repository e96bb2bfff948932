"""SDDP, the successive deformation decomposition procedure.

At each level the tissue first deforms as one compact solid, then its walls are released from that state, which is the
anchor of the release. Compact states follow each other; every release starts from its own compact state, so a level
does not depend on the levels before it.

The walk yields the steps that were accepted, and stops when one cannot be. It may be taken up after any number of them,
from the last compact displacement.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Minimum, Tether
from ngcell.solve.outcome import Outcome
from ngcell.solve.released import Released
from ngcell.solve.selection import until_conditions_hold
from ngcell.solve.step import MOST_HALVINGS, Accepted, Account, Motion, StepFailed, next_goal, spent

Array = NDArray[np.float64]


def compact_then_released(
    compact: Sequence[Minimiser],
    released: Released,
    motion: Motion,
    *,
    steps: Sequence[float],
    levels: Sequence[float],
    done: int = 0,
    last_compact: Array | None = None,
) -> Iterator[Accepted]:
    """Yield the compact state of every step, and after it, at the levels, the released state.

    Parameters
    ----------
    compact : sequence of Minimiser
        The compact solid, from the softest volume to the one that is meant.
    released : Released
        The released walls.
    motion : Motion
        The prescribed motion.
    steps, levels : sequence of float
        Load factors, in the order of the load path; the levels are among the steps.
    done : int
        Number of accepted steps to go on after.
    last_compact : array of float, shape (unknowns,), optional
        The last compact displacement among these [length].

    Raises
    ------
    StepFailed
        If a step finds no equilibrium.
    """
    schedule = list(_schedule(steps, levels))
    load = schedule[done - 1][1] if done else 0.0
    displacement = motion.carried(0.0) if last_compact is None else last_compact
    for phase, target in schedule[done:]:
        if phase == "compact":
            step = _compact_step(compact, motion, displacement, load, target, released)
            load, displacement = target, step.minimum.state.displacement
            yield step
        else:
            start = compact[-1].problem.expand(displacement)
            anchor = motion.carried(target) if motion.has_carried_field else start
            if released.history is None:
                yield released.step(start, anchor, target)
            else:
                released.history.forget()
                energy = compact[-1].problem.at(displacement).energy
                yield _let_go(released, released.step(start, anchor, target), energy)


def _let_go(released: Released, step: Accepted, compact_energy: float) -> Accepted:
    """Return a step that let a compact state go at held supports: what the energy fell by is lost."""
    assert released.history is not None
    released.history.advance(step.minimum.state.displacement)
    lost = compact_energy - step.minimum.state.energy
    gained = max(-lost, 0.0)
    share = gained / max(abs(compact_energy), np.finfo(float).tiny)
    return replace(step, account=Account(max(lost, 0.0), gained, share))


def _schedule(steps: Sequence[float], levels: Sequence[float]) -> Iterator[tuple[str, float]]:
    """Yield phase and load factor of every step."""
    for target in steps:
        yield "compact", target
        if any(np.isclose(target, level) for level in levels):
            yield "contact", target


def _compact_step(
    compact: Sequence[Minimiser],
    motion: Motion,
    displacement: Array,
    load: float,
    target: float,
    released: Released,
) -> Accepted:
    before, reached, increment, halvings = spent(compact), load, target - load, 0
    while True:
        goal = next_goal(reached, increment, target)
        start = displacement + motion.carried(goal) - motion.carried(reached)
        tether = Tether(0.0, start)
        if released.loads is not None:
            released.loads.apply(goal)
        minimum = _compact_minimum(compact, motion.imposed(start, goal), tether)
        if minimum.is_found:
            minimum = until_conditions_hold(compact[-1], minimum, released.longest_step)
        if minimum.is_found:
            displacement, reached = minimum.state.displacement, goal
            if reached == target:
                return Accepted("compact", target, minimum, spent(compact) - before)
            continue
        increment, halvings = increment / 2, halvings + 1
        compact[-1].effort.cutbacks += 1
        if halvings > MOST_HALVINGS:
            raise StepFailed(Outcome.COMPACT_FAILED, goal)


def _compact_minimum(compact: Sequence[Minimiser], start: Array, tether: Tether) -> Minimum:
    for minimiser in compact:
        minimum = minimiser.minimise(start, tether)
        if not minimum.is_found:
            break
        start = minimum.state.displacement
    return minimum
