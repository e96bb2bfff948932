"""Load and contact together: no tied solid is computed.

The centre of a release is the lifting of the load. Where the load determines none, the state before is the
centre, and the continuation is incremental.

The continuation yields the steps that were accepted, and stops when one cannot be. It may be taken up after any number of them,
from the last displacement.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.released import Released
from ngcell.solve.step import MOST_HALVINGS, Accepted, Motion, StepFailed, next_goal

Array = NDArray[np.float64]


def single_step(
    released: Released,
    motion: Motion,
    *,
    steps: Sequence[float],
    done: int = 0,
    last: Array | None = None,
) -> Iterator[Accepted]:
    """Yield the equilibrium with contact of every step, from the one after those that are `done`.

    `last` is the displacement of the last of these [length], shape (unknowns,).

    Raises
    ------
    StepFailed
        If a step finds no equilibrium.
    """
    load = steps[done - 1] if done else 0.0
    displacement = motion.lifting(0.0) if last is None else last
    for target in steps[done:]:
        if motion.has_lifting:
            centre = motion.lifting(target)
            step = released.step(centre, centre, target)
        else:
            step = _incremental_step(released, motion, displacement, load, target)
        load, displacement = target, step.minimum.state.displacement
        yield step


def _incremental_step(released: Released, motion: Motion, displacement: Array, load: float, target: float) -> Accepted:
    before, reached, increment, halvings = released.effort, load, target - load, 0
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
            return Accepted("contact", target, step.minimum, released.effort - before)
