"""A step along the load path: what it needs to know of the supports, and what comes of it.

A step that fails is halved, at most `MOST_HALVINGS` times.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.effort import Budget, Effort, OutOfIterations
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Minimum
from ngcell.solve.outcome import Outcome

Array = NDArray[np.float64]

MOST_HALVINGS = 6


class Motion(Protocol):
    """The prescribed motion; see `ngcell.mechanics.supports.PrescribedMotion`."""

    @property
    def has_lifting(self) -> bool:
        """Whether the load determines a lifting: a displacement of all bodies that meets the supports."""

    def imposed(self, displacement: Array, load_factor: float) -> Array:
        """Return a displacement with the prescribed values in place."""

    def lifting(self, load_factor: float) -> Array:
        """Return the lifting."""


@dataclass(frozen=True)
class Account:
    """Where energy went on the way from rest to a step.

    Attributes
    ----------
    dissipation : float
        What was lost as the energy fell at held supports, since rest, or since the tied state where walls are released
        from one [energy].
    mismatch_share : float
        Work of supports and loads minus the change of all energies and losses, since the step before, over the energy
        that the step moved; >= 0.
    increment : float
        Change of load factor that the next step may make; 0 where that is not known.
    targets : int
        Number of asked-for load factors that have been reached.
    """

    dissipation: float
    mismatch_share: float
    increment: float = 0.0
    targets: int = 0


@dataclass(frozen=True, eq=False)
class Accepted:
    """An accepted step.

    Attributes
    ----------
    phase : {"tied", "released"}
        Whether walls were tied, or in unilateral contact.
    load_factor : float
        In [0, 1].
    minimum : Minimum
        The state, how it was reached, and the proximal term that is left.
    effort : Effort
        What it took, failures included.
    account : Account, optional
        Where energy went, with a problem that has a history.
    follows : bool
        Whether it was reached from the state of the step before, and not from a state of its own.
    """

    phase: str
    load_factor: float
    minimum: Minimum
    effort: Effort
    account: Account | None = None
    follows: bool = False


class StepFailed(Exception):  # noqa: N818 - named as what is reported, not as a mistake
    """No equilibrium was found, even in the smallest step."""

    def __init__(self, outcome: Outcome, load_factor: float) -> None:
        super().__init__(outcome.value)
        self.outcome = outcome
        self.load_factor = load_factor


def next_goal(reached: float, increment: float, target: float) -> float:
    """Return the load factor of the next attempt, up or down, never beyond the target."""
    return target if abs(target - reached) <= abs(increment) else reached + increment


def spent(minimisers: Sequence[Minimiser]) -> Effort:
    """Return what minimisers have spent so far."""
    return sum((minimiser.effort for minimiser in minimisers), Effort())


def within_budget(steps: Iterator[Accepted], budget: Budget, load_factor: float) -> Iterator[Accepted]:
    """Yield steps that follow one at a load factor, each of which may take so much work.

    Raises
    ------
    StepFailed
        If one takes more.
    """
    budget.renew()
    try:
        for accepted in steps:
            load_factor = accepted.load_factor
            yield accepted
            budget.renew()
    except OutOfIterations as spent_all:
        raise StepFailed(Outcome.OUT_OF_ITERATIONS, load_factor) from spent_all
