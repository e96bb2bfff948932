"""Walks along the load path: each yields the steps that were accepted, and stops when one cannot be.

``compact_then_released`` is SDDP, the successive deformation decomposition procedure: at each level the tissue first
deforms as one compact solid, then its walls are released from that state, which is the anchor of the release. Compact
states follow each other; every release starts from its own compact state, so a level does not depend on the
levels before it.

``single_step`` applies load and contact together: the anchor is the carried field of the load, and no compact solid is
computed. Where the load determines no carried field, the state before is the anchor, and the walk is incremental.

A step that fails is halved, at most `MOST_HALVINGS` times.

A walk may be taken up after any number of accepted steps, from the last displacement of the phase that leads it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.effort import Effort
from ngcell.solve.minimise import Minimiser, Minimum, Tether
from ngcell.solve.outcome import Outcome
from ngcell.solve.selection import Release, until_conditions_hold

Array = NDArray[np.float64]

MOST_HALVINGS = 6


class Motion(Protocol):
    """The prescribed motion; see `ngcell.mechanics.supports.PrescribedMotion`."""

    @property
    def has_carried_field(self) -> bool:
        """Whether the load determines a carried field."""

    def imposed(self, displacement: Array, load_factor: float) -> Array:
        """Return a displacement with the prescribed values in place."""

    def carried(self, load_factor: float) -> Array:
        """Return the carried field."""


class Loads(Protocol):
    """Loads that are part of the energy; see `ngcell.mechanics.loads.BoundaryLoads`."""

    def apply(self, load_factor: float) -> None:
        """Set the load factor that energies are taken at."""

    def share(self, load_factor: float) -> float:
        """Return the share of the full loads that acts at a load factor."""

    def potential(self, displacement: Array, load_factor: float) -> float:
        """Return the potential at a load factor."""


class History(Protocol):
    """What a problem remembers of accepted steps; see `ngcell.contact.assembly.Assembly`."""

    def advance(self, displacement: Array) -> None:
        """Keep what this accepted state leaves for good."""

    def forget(self) -> None:
        """Be as new."""


@dataclass(frozen=True)
class Account:
    """Where energy went on the way from rest to a step.

    Attributes
    ----------
    dissipation : float
        What was lost as the energy fell at held supports, since rest [energy].
    mismatch : float
        Work of supports and loads minus the change of all energies and losses, since the step before [energy].
    mismatch_share : float
        Its magnitude over the energy that the step moved.
    increment : float
        Change of load factor that the next step may make; 0 where that is not learned.
    targets : int
        Number of asked-for load factors that the walk has come to.
    """

    dissipation: float
    mismatch: float
    mismatch_share: float
    increment: float = 0.0
    targets: int = 0


@dataclass(frozen=True, eq=False)
class Accepted:
    """An accepted step.

    Attributes
    ----------
    phase : {"compact", "contact"}
        What was solved.
    load_factor : float
        In [0, 1].
    minimum : Minimum
        The state and how it was reached.
    tether : Tether
        What still pulls at it.
    effort : Effort
        What it took, failures included.
    account : Account, optional
        Where energy went, with a problem that has a memory.
    """

    phase: str
    load_factor: float
    minimum: Minimum
    tether: Tether
    effort: Effort
    account: Account | None = None


class StepFailed(Exception):  # noqa: N818 - named as what is reported, not as a mistake
    """No equilibrium was found, even in the smallest step."""

    def __init__(self, outcome: Outcome, load_factor: float) -> None:
        super().__init__(outcome.value)
        self.outcome = outcome
        self.load_factor = load_factor


@dataclass(frozen=True, eq=False)
class Released:
    """The released problem and the path on which its equilibria are selected.

    Attributes
    ----------
    apart : Minimiser
        Without contact.
    minimisers : tuple of Minimiser
        With contact from the softest, which the path is walked with, to the one that is meant.
    path : Release
        The path.
    loads : Loads, optional
        What pushes and pulls besides the supports.
    history : History, optional
        What the problem remembers of accepted steps.
    is_alone : bool
        Whether there is one body only: it touches nothing, and no path has to be walked unless the straight way fails.
    is_mixed : bool
        Whether some bodies are stiffer than others. A decrement sees forces divided by stiffness, and would end with
        those on stiff bodies out of balance: there the last minimisation goes down to round-off.
    """

    apart: Minimiser
    minimisers: tuple[Minimiser, ...]
    path: Release
    loads: Loads | None = None
    history: History | None = None
    is_alone: bool = False
    is_mixed: bool = False

    @property
    def effort(self) -> Effort:
        """What was spent so far."""
        return _effort((self.apart, *self.minimisers))

    @property
    def longest_step(self) -> float:
        """The length beside which missed conditions are judged [length]."""
        return self.minimisers[-1].longest_step

    def predict(self, displacement: Array, imposed: Array) -> Array:
        """Return the displacement that follows, to first order, when prescribed values jump."""
        return self.minimisers[-1].predict(displacement, imposed, self.path.scale * self.path.last)

    def step(self, start: Array, anchor: Array, load: float, *, may_stall: bool = True) -> Accepted:
        """Return the selected equilibrium; see `Release.select`.

        Raises
        ------
        StepFailed
            If a minimisation on the path fails.
        """
        before = self.effort
        if self.loads is not None:
            self.loads.apply(load)
        tether = self.path.last_tether(anchor)
        minimum = self._alone(start, tether) or self.path.select(
            self.apart, self.minimisers, start, anchor, may_stall=may_stall
        )
        if self.is_mixed and minimum.is_found:
            minimum = self.minimisers[-1].minimise(minimum.state.displacement, minimum.tether)
        if not minimum.is_found:
            raise StepFailed(Outcome.RELEASE_FAILED, load)
        return Accepted("contact", load, minimum, minimum.tether, self.effort - before)

    def _alone(self, start: Array, tether: Tether) -> Minimum | None:
        """Return the minimum of a body that is alone; None if there are more, or if none was found."""
        if not self.is_alone:
            return None
        minimiser = self.minimisers[-1]
        minimum = minimiser.minimise(start, tether)
        if minimum.is_found:
            minimum = until_conditions_hold(minimiser, minimum, self.longest_step)
        return minimum if minimum.is_found else None


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


def _next_goal(reached: float, increment: float, target: float) -> float:
    """Return the load factor of the next attempt, up or down, never beyond the target."""
    return target if abs(target - reached) <= abs(increment) else reached + increment


def _compact_step(
    compact: Sequence[Minimiser],
    motion: Motion,
    displacement: Array,
    load: float,
    target: float,
    released: Released,
) -> Accepted:
    before, reached, increment, halvings = _effort(compact), load, target - load, 0
    while True:
        goal = _next_goal(reached, increment, target)
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
                return Accepted("compact", target, minimum, tether, _effort(compact) - before)
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


def _effort(minimisers: Sequence[Minimiser]) -> Effort:
    return sum((minimiser.effort for minimiser in minimisers), Effort())


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
    displacement = motion.carried(0.0) if last is None else last
    for target in steps[done:]:
        if motion.has_carried_field:
            anchor = motion.carried(target)
            step = released.step(anchor, anchor, target)
        else:
            step = _incremental_step(released, motion, displacement, load, target)
        load, displacement = target, step.minimum.state.displacement
        yield step


def _incremental_step(
    released: Released, motion: Motion, displacement: Array, load: float, target: float
) -> Accepted:
    before, reached, increment, halvings = released.effort, load, target - load, 0
    while True:
        goal = _next_goal(reached, increment, target)
        anchor = released.predict(displacement, motion.imposed(displacement, goal))
        try:
            step = released.step(anchor, anchor, goal, may_stall=False)
        except StepFailed:
            increment, halvings = increment / 2, halvings + 1
            released.apart.effort.cutbacks += 1
            if halvings > MOST_HALVINGS:
                raise
            continue
        displacement, reached = step.minimum.state.displacement, goal
        if reached == target:
            return Accepted("contact", target, step.minimum, step.tether, released.effort - before)
