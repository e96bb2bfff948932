"""A load path with a memory: every step starts where the one before ended, and its energy is accounted for.

Where bonds break for good, an equilibrium depends on the way to it. A step from one load factor to the next has two
parts. First the supports move, and the bodies follow along a straight line, to first order and with bonds on their
secants. Then, at held supports, the energy falls to a minimum: in steps of the minimiser, whose proximal term keeps
them short, and with a vanishing proximal term to the start. A saddle is left. The history moves when the step is
accepted.

The first part is work, the second is lost: where the state follows the load it is of second order in the step and
vanishes as steps get small; where walls snap it stays, and is what a faster dynamics would turn into heat. Both are
taken independently, work from forces and losses from energies, so their sum has to be the change of energy:

    work of supports and loads = change of stored energy + energy of separation + loss + mismatch

and the mismatch, the error of the trapezoidal rule, decides how long a step may be. Where the forces in equilibrium at
both ends account for the change of energy by themselves, nothing was lost. Where they nearly do, shorter steps tell.

Contact that turns out too soft for a step, or too coarse, adapts at its end, while the supports stand still. What that
puts into the energy is a loss with the opposite sign. A step that is refused takes it back.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import copysign
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ngcell.scene.section import PositiveCount, Section
from ngcell.solve.conditions import until_conditions_hold
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.outcome import Outcome
from ngcell.solve.problem import Driven, State
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.refined import stable
from ngcell.solve.step import MOST_HALVINGS, Accepted, Account, StepFailed
from ngcell.solve.strategies.strategy import Progress, Task

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)

#: A load path of fewer levels may be cut as finely as one of so many equal ones: how short a step has to be for bonds
#: to be followed does not depend on what is reported.
_LEVELS = 10
#: Further halvings of a step where a loss that was looked for does not close the balance yet.
_FURTHER_HALVINGS = 4


@dataclass(frozen=True, eq=False)
class _Place:
    """Where the load path stands: load factor, minimum, the loss so far."""

    load: float
    minimum: Minimum
    dissipation: float


@dataclass(frozen=True, eq=False)
class _Stand:
    """A state, the gradient of its energy, and how loads take in work there."""

    state: State
    force: Array
    drives: Sequence[Driven]


class LoadStepping(Section):
    """Load steps that follow each other, as scenes with a history need: every step starts where the one before ended.

    Parameters
    ----------
    steps : int, optional
        Smallest number of load steps, >= 1; by default one for each level of the load. The balance of energy asks for
        more where it has to.
    """

    kind: Literal["load-stepping"] = "load-stepping"
    steps: PositiveCount | None = None

    def follow(self, task: Task, progress: Progress) -> Iterator[Accepted]:
        """Yield accepted steps up to each load factor in turn, with as many between them as the balance asks for."""
        return _Path(task).steps(progress)


class _Path:
    """The load path of a task."""

    def __init__(self, task: Task) -> None:
        self._task, self._released, self._motion = task, task.released, task.motion
        self._minimiser = task.released.minimisers[-1]
        self._problem, self._options = self._minimiser.problem, task.options.load_stepping

    def steps(self, progress: Progress) -> Iterator[Accepted]:
        """Yield accepted steps after those of `progress`."""
        targets, memory = self._task.steps, progress.memory
        done = int(memory.get("targets", 0))
        ways = np.abs(np.diff([0.0, *targets]))
        # The path may start with a level without load, to which there is no way.
        ways = ways[ways > 0] if ways.any() else np.ones(1)
        increment = float(memory.get("increment", 0.0)) or float(ways[0])
        place = self._start(progress)
        shortest = min(float(ways.min()), float(ways.sum()) / _LEVELS) / 2**MOST_HALVINGS
        for number, target in enumerate(targets[done:], done):
            is_there = False
            while not is_there:
                before = self._released.effort
                self._minimiser.forget_matrix()  # what follows depends on this place alone, also after a stop
                way = target - place.load
                pieces = max(1, int(np.ceil(abs(way) / increment - 1e-9)), self._pieces(place, target))
                increment = abs(way) / pieces or increment
                goal = target if pieces == 1 else place.load + way / pieces
                tried = self._tried(place, goal, is_shortest=increment < shortest)
                while tried is None:
                    if not way or increment < shortest / 2**_FURTHER_HALVINGS:
                        raise StepFailed(Outcome.RELEASE_FAILED, goal)
                    increment /= 2
                    self._released.apart.effort.cutbacks += 1
                    goal = place.load + copysign(increment, way)
                    tried = self._tried(place, goal, is_shortest=increment < shortest)
                place, account = tried
                is_there = goal == target
                self._problem.accept(place.minimum.state.displacement)
                increment *= 2 if account.mismatch_share < self._options.longer else 1
                account = replace(account, increment=increment, targets=number + is_there)
                yield Accepted("released", goal, place.minimum, self._released.effort - before, account)

    def _start(self, progress: Progress) -> _Place:
        self._released.apply(progress.load_factor)
        at_rest = self._motion.imposed(np.zeros(len(self._problem.free)), 0.0)
        if not progress.accepted:
            self._problem.begin_path()
        state = self._problem.at(progress.displacement.get("released", at_rest))
        start = Minimum(state, Ending.CONVERGED, 0.0, ProximalTerm(0.0, state.displacement))
        drives = self._problem.drives(state.displacement, progress.load_factor)
        if not progress.accepted and any(drive.share > 0 for drive in drives):
            # Something acts in full before the load: the path starts from the equilibrium with it.
            start = self._fallen(state.displacement)
            if not start.is_found:
                raise StepFailed(Outcome.RELEASE_FAILED, progress.load_factor)
        return _Place(progress.load_factor, start, float(progress.memory.get("dissipation", 0.0)))

    def _pieces(self, place: _Place, target: float) -> int:
        """Return in how many increments supports are to move for no wall to be passed unseen."""
        displacement = place.minimum.state.displacement
        return self._released.pieces(displacement, self._motion.imposed(displacement, target))

    def _tried(self, place: _Place, goal: float, *, is_shortest: bool) -> tuple[_Place, Account] | None:
        """Return where a step leads, or None if it is too long."""
        start = self._stand(place.minimum.state, place.load)
        towards = self._followed(start.state.displacement, goal)
        if towards is None:
            _log.info("step to %.6g: bodies run ahead of their supports", goal)
            return None
        self._released.apply(goal)
        moved = self._stand(self._problem.at(towards), goal)
        if np.isfinite(moved.state.energy):
            minimum = self._fallen(towards)
            least = 0.0 if is_shortest else self._options.snapped
            lost, share = self._balance(start, moved, self._stand(minimum.state, goal), least)
            _log.info("step to %.6g: %s, mismatch %.1e, lost %.1e", goal, minimum.ending.value, share, lost)
            remembered = self._problem.memory()
            met = self._met(minimum) if minimum.is_found and share <= self._options.mismatch else None
            if met is not None:
                account = Account(place.dissipation + lost + minimum.state.energy - met.state.energy, share)
                return _Place(goal, met, account.dissipation), account
            self._problem.recall(remembered)
        self._released.apply(place.load)
        return None

    def _met(self, minimum: Minimum) -> Minimum | None:
        """Return the minimum beside one, at held supports, once contact has adapted to its overlaps; None if there is
        none.

        What that changes the energy by is no work of the supports: it is counted among the losses, with its sign.
        """
        length, options = self._minimiser.longest_step, self._task.options
        met = until_conditions_hold(self._minimiser, minimum, length, options.continuation)
        if met is not minimum and met.is_found:
            met = stable(self._minimiser, met, length=length, options=options, path=self._released.path)
        return met if met.is_found else None

    def _fallen(self, start: Array) -> Minimum:
        """Return the minimum below a place, and no saddle; its proximal term follows where bodies went far."""
        path, length = self._released.path, self._minimiser.longest_step
        while True:
            minimum = self._minimiser.minimise(start, path.last_proximal(start))
            if not minimum.is_found:
                return minimum
            if float(np.abs(minimum.state.displacement - start).max()) <= length:
                return stable(self._minimiser, minimum, length=length, options=self._task.options, path=path)
            start = minimum.state.displacement

    def _balance(self, start: _Stand, moved: _Stand, end: _Stand, least: float) -> tuple[float, float]:
        """Return the loss of a step, and what of the energy is not accounted for as a share of what was moved.

        Only where equilibria at both ends leave more than `least` unexplained a loss is looked for.
        """
        free = self._problem.free
        way = np.where(free, 0.0, end.state.displacement - start.state.displacement)
        share = _unexplained(start, end, way, self._options.quiet)
        if share <= max(self._options.mismatch, least):
            return 0.0, share
        way = moved.state.displacement - start.state.displacement
        share = _unexplained(start, moved, way, self._options.quiet)
        held_back = float((start.force + moved.force)[free] @ way[free]) / 2
        return moved.state.energy - end.state.energy - held_back, share

    def _stand(self, state: State, load: float) -> _Stand:
        force = self._problem.gradient(state) if np.isfinite(state.energy) else np.zeros(0)
        return _Stand(state, force, self._problem.drives(state.displacement, load))

    def _followed(self, displacement: Array, goal: float) -> Array | None:
        """Return where the bodies are when the supports have moved, held back where they would run ahead.

        None where nothing holds them back, as where walls are pressed on a corner: there a larger weight of the
        proximal term sends them further.
        """
        imposed = self._motion.imposed(displacement, goal)
        weight, nearest = self._released.path.last_proximal(displacement).weight, np.inf
        limit = self._options.farthest * max(self._minimiser.longest_step, float(np.abs(imposed - displacement).max()))
        while True:
            towards = self._minimiser.predict(displacement, imposed, weight)
            farthest = float(np.abs(towards - displacement).max())
            if farthest <= limit:
                return towards
            if not farthest < nearest:
                return None
            weight, nearest = 100 * weight, farthest


def _unexplained(one: _Stand, two: _Stand, way: Array, quiet: float) -> float:
    """Return work minus change of energy on a way, by the trapezoidal rule, as a share of what is moved."""
    work = float((one.force + two.force) @ way) / 2
    for before, after in zip(one.drives, two.drives, strict=True):
        work += (after.share - before.share) * (before.potential + after.potential) / 2
    change = two.state.energy - one.state.energy
    moved = max(abs(change), abs(work), quiet * abs(one.state.energy), np.finfo(float).tiny)
    return abs(work - change) / moved
