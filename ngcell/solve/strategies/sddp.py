"""SDDP, the successive deformation decomposition procedure.

At each level the tissue first deforms as one tied solid, then its walls are released from that state. The tied solid
knows no contact until a body touches itself, as where lumens close. Tied states
follow each other; every release starts from its own tied state, so a level does not depend on the levels before it. The
centre of the continuation is the lifting of the load, as for all strategies, and the tied state where the load has
none: which released equilibrium is found depends on the load, and the energy of the tied state bounds its energy.
Where bonds break, the tied state is the centre, and where no path leads from the lifting, as when walls are squeezed
to half.

References
----------
Mihai, Safar, Wyatt, Debonding of cellular structures with fibre-reinforced cell walls under shear deformation,
J. Eng. Math. 2017.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ngcell.scene.section import PositiveCount, Section
from ngcell.solve.conditions import until_conditions_hold
from ngcell.solve.effort import OutOfIterations
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Minimum
from ngcell.solve.outcome import Outcome
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.refined import has_contact, stable
from ngcell.solve.released import Released
from ngcell.solve.step import MOST_HALVINGS, Accepted, Account, StepFailed, next_goal, spent
from ngcell.solve.strategies.strategy import Progress, Task

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)


class Sddp(Section):
    """Successive deformation decomposition: load the tied tissue first, then release its walls.

    Parameters
    ----------
    steps : int, optional
        Smallest number of load steps, >= 1; by default one for each level of the load.
    """

    kind: Literal["sddp"] = "sddp"
    steps: PositiveCount | None = None

    def follow(self, task: Task, progress: Progress) -> Iterator[Accepted]:
        """Yield the tied state of every step, and after it, at the levels, the released state."""
        schedule = list(_schedule(task.steps, task.levels))
        load = schedule[progress.accepted - 1][1] if progress.accepted else 0.0
        displacement = progress.displacement.get("tied", task.motion.lifting(0.0))
        for phase, target in schedule[progress.accepted :]:
            if phase == "tied":
                step = _tied_step(task, displacement, load, target)
                load, displacement = target, step.minimum.state.displacement
                yield step
            else:
                yield _released_step(task, displacement, target)


def _released_step(task: Task, tied: Array, target: float) -> Accepted:
    """Return the released state that a tied displacement leads to."""
    released, problem = task.released, task.tied[-1].problem
    start = problem.expand(tied)
    centre, *others = _centres(task, start, target)
    released.problem.reset()
    before = released.effort
    try:
        step = released.step(start, centre, target)
    except (StepFailed, OutOfIterations):
        if not others:
            raise
        _log.info("no path leads from this centre; another one is taken")
        task.problems.renew_budget()
        released.problem.reset()
        step = replace(released.step(start, others[0], target), effort=released.effort - before)
    return _with_loss(released, step, problem.at(tied).energy) if released.problem.has_history else step


def _centres(task: Task, tied: Array, load: float) -> list[Array]:
    """Return the centres from which a path may lead to the released state, the first to be tried first.

    Bonds bear at the tied state what the tie has borne. From the lifting, which stores some times as much energy, they
    would break on the way. Walls without bonds find lower energies from there.
    """
    if not task.motion.has_lifting:
        return [tied]
    lifting = task.motion.lifting(load)
    return [tied, lifting] if task.released.problem.has_history else [lifting, tied]


def _with_loss(released: Released, step: Accepted, tied_energy: float) -> Accepted:
    """Return a step from a tied state at held supports: what the energy fell by is lost."""
    released.problem.accept(step.minimum.state.displacement)
    lost = tied_energy - step.minimum.state.energy
    share = max(-lost, 0.0) / max(abs(tied_energy), np.finfo(float).tiny)
    return replace(step, account=Account(max(lost, 0.0), share))


def _schedule(steps: Sequence[float], levels: Sequence[float]) -> Iterator[tuple[str, float]]:
    """Yield phase and load factor of every step."""
    for target in steps:
        yield "tied", target
        if any(np.isclose(target, level) for level in levels):
            yield "released", target


def _tied_step(task: Task, displacement: Array, load: float, target: float) -> Accepted:
    """Return the tied state at a load factor, from that at another; a step that fails is halved.

    Where none is found with contact, it is the one without: released walls do not need it, and a certificate tells how
    deep walls lie in each other there.
    """
    tied, motion = task.tied, task.motion
    both = (*tied, *task.closing)
    before, reached, increment, halvings = spent(both), load, target - load, 0
    while True:
        goal = next_goal(reached, increment, target)
        start = displacement + motion.lifting(goal) - motion.lifting(reached)
        minimum = _tied_minimum(task, motion.imposed(start, goal), ProximalTerm(0.0, start), goal)
        if minimum.is_found:
            displacement, reached = minimum.state.displacement, goal
            if reached == target:
                return Accepted("tied", target, minimum, spent(both) - before)
            continue
        increment, halvings = increment / 2, halvings + 1
        tied[-1].effort.cutbacks += 1
        if halvings > MOST_HALVINGS:
            failed = StepFailed(Outcome.TIED_FAILED, goal)
            if not task.closing:
                raise failed
            start = displacement + motion.lifting(target) - motion.lifting(reached)
            minimum = _minimum_of(tied, task, motion.imposed(start, target), ProximalTerm(0.0, start), target)
            if not minimum.is_found:
                raise failed
            _log.info("the tied solid is found without contact only: walls that are not tied pass through each other")
            return Accepted("tied", target, minimum, spent(both) - before)


def _tied_minimum(task: Task, start: Array, proximal: ProximalTerm, load: float) -> Minimum:
    """Return the minimum of the tied solid, without contact where no body touches itself there."""
    if not has_contact(task.closing, start):
        minimum = _minimum_of(task.tied, task, start, proximal, load)
        if not minimum.is_found or not has_contact(task.closing, minimum.state.displacement):
            return minimum
    task.closing[-1].problem.reset()
    return _minimum_of(task.closing, task, start, proximal, load)


def _minimum_of(tied: Sequence[Minimiser], task: Task, start: Array, proximal: ProximalTerm, load: float) -> Minimum:
    """Return the minimum, stage by stage to the volume that is meant, then until conditions hold."""
    for minimiser in tied:
        minimiser.problem.apply(load)
        minimum = minimiser.minimise(start, proximal)
        if not minimum.is_found:
            return minimum
        start = minimum.state.displacement
    last, length, path = tied[-1], task.released.longest_step, task.released.path
    met = until_conditions_hold(last, minimum, length, task.options.continuation)
    return stable(last, met, length=length, options=task.options, path=path)
