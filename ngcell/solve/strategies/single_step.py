"""Load and contact together: no tied solid is computed.

The centre of the continuation is the lifting of the load. Where the load determines none, the state before is the
centre, and the load path is followed in increments: none moves a support so far that a wall could be passed unseen. So
it is where no path leads from the lifting.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from ngcell.scene.section import PositiveCount, Section
from ngcell.solve.effort import OutOfIterations
from ngcell.solve.released import Released
from ngcell.solve.step import MOST_HALVINGS, Accepted, Motion, StepFailed, next_goal
from ngcell.solve.strategies.strategy import Progress, Task

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)

#: Overlap over the thickness of the thinner body above which walls may have passed each other: two and a half times
#: what a certificate allows (corners that had passed overlapped by 0.09). Softer contact is followed twice.
_PASSED = 0.05


class SingleStep(Section):
    """Load and contact together.

    Parameters
    ----------
    steps : int, optional
        Smallest number of load steps, >= 1; by default one for each level of the load.
    """

    #: Bonds that break on the way would not be followed.
    goes_with_history: ClassVar[bool] = False

    kind: Literal["single-step"] = "single-step"
    steps: PositiveCount | None = None

    def follow(self, task: Task, progress: Progress) -> Iterator[Accepted]:
        """Yield the equilibrium with contact of every step."""
        motion, done = task.motion, progress.accepted
        load = task.steps[done - 1] if done else 0.0
        displacement = progress.displacement.get("released", motion.lifting(0.0))
        for target in task.steps[done:]:
            before = task.released.effort
            step = _from_lifting(task, target) if motion.has_lifting else None
            if step is None:
                step = _followed(task, motion, displacement, load, target)
                step = replace(step, effort=task.released.effort - before)
            load, displacement = target, step.minimum.state.displacement
            yield step


def _from_lifting(task: Task, target: float) -> Accepted | None:
    """Return the equilibrium that a path from the lifting leads to; None where none does, as where elements next to
    supports are inverted there, or where it takes more work than a step may."""
    centre = task.motion.lifting(target)
    try:
        return task.released.step(centre, centre, target)
    except (StepFailed, OutOfIterations):
        task.problems.renew_budget()
        _log.info("no path leads from the lifting; the load is followed from the step before")
        return None


def _followed(task: Task, motion: Motion, displacement: Array, load: float, target: float) -> Accepted:
    """Return the equilibrium that increments lead to: half as long ones where bodies are deep in each other after it,
    as where a corner has come to the wrong side of another."""
    released = task.released
    released.forget_matrices()  # what follows depends on the step before alone, also after a stop
    step = _incremental_step(released, motion, displacement, load, target, 1)
    if released.problem.has_history or released.problem.overlap(step.minimum.state) <= _PASSED:
        return step
    _log.info("bodies overlap where they should not; the load is followed in smaller increments")
    try:
        return _incremental_step(released, motion, displacement, load, target, 2)
    except (StepFailed, OutOfIterations):
        task.problems.renew_budget()
        return _incremental_step(released, motion, displacement, load, target, 1)  # as before, to the last digit


def _incremental_step(
    released: Released, motion: Motion, displacement: Array, load: float, target: float, times: int
) -> Accepted:
    before, reached, halvings = released.effort, load, 0
    pieces = times * released.pieces(displacement, motion.imposed(displacement, target))
    increment = (target - load) / pieces
    while True:
        goal = next_goal(reached, increment, target)
        centre = released.predict(displacement, motion.imposed(displacement, goal))
        try:
            step = released.step(centre, centre, goal, may_stall=False)
        except StepFailed:
            increment, halvings = increment / 2, halvings + 1
            released.apart.effort.cutbacks += 1
            if halvings > MOST_HALVINGS:
                raise
            continue
        displacement, reached = step.minimum.state.displacement, goal
        if reached == target:
            return Accepted("released", target, step.minimum, released.effort - before, follows=True)
