"""What a strategy is given, and what it yields.

A strategy yields the steps that it accepts, one after the other, and stops when one cannot be. It may be taken up after
any number of them, from what it is told of the last.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.minimise import Minimiser
from ngcell.solve.options import SolverOptions
from ngcell.solve.released import Released
from ngcell.solve.step import Accepted, Motion

Array = NDArray[np.float64]


class Problems(Protocol):
    """The problems of a scene, each built when it is asked for."""

    @property
    def tied(self) -> tuple[Minimiser, ...]:
        """The tied solid, from the softest volume to the one that is meant."""

    @property
    def closing(self) -> tuple[Minimiser, ...]:
        """The tied solid with contact within bodies; none where there is no such contact."""

    @property
    def released(self) -> Released:
        """The released walls."""

    def renew_budget(self, times: float = ...) -> None:
        """Give a further attempt at a step all of the work of a step, so many times the usual."""


@dataclass(frozen=True, eq=False)
class Task:
    """What a strategy is to do.

    Attributes
    ----------
    problems : Problems
        The tied solid and the released walls.
    motion : Motion
        The supports.
    steps, levels : sequence of float
        Load factors, in the order of the load path; the levels, which are reported, are among the steps.
    options : SolverOptions
        The solver's own numbers.
    """

    problems: Problems
    motion: Motion
    steps: Sequence[float]
    levels: Sequence[float]
    options: SolverOptions = field(default_factory=SolverOptions)

    @cached_property
    def tied(self) -> tuple[Minimiser, ...]:
        """The tied solid."""
        return self.problems.tied

    @cached_property
    def closing(self) -> tuple[Minimiser, ...]:
        """The tied solid with contact within bodies; none where there is no such contact."""
        return self.problems.closing

    @cached_property
    def released(self) -> Released:
        """The released walls."""
        return self.problems.released


@dataclass(frozen=True, eq=False)
class Progress:
    """How far a load path has been followed.

    Attributes
    ----------
    accepted : int
        Number of accepted steps.
    load_factor : float
        Load factor of the last one.
    displacement : mapping of str to array of float, shape (unknowns,)
        Displacement of the last step of each phase [length].
    memory : mapping of str to array
        What else was remembered, by name: the history of terms, and the account of energy.
    """

    accepted: int = 0
    load_factor: float = 0.0
    displacement: Mapping[str, Array] = field(default_factory=dict)
    memory: Mapping[str, NDArray[Any]] = field(default_factory=dict)


def load_steps(levels: Sequence[float], count: int) -> list[float]:
    """Return the load factors of all steps: the levels, with equal steps between them where there are to be more."""
    length = float(np.abs(np.diff(levels, prepend=0.0)).sum())
    steps, before = [], 0.0
    for level in levels:
        pieces = max(1, round(count * abs(level - before) / length)) if level != before else 1
        steps += list(np.linspace(before, level, pieces + 1)[1:])
        before = level
    return [float(step) for step in steps]


@runtime_checkable
class Strategy(Protocol):
    """How the load path is followed."""

    @property
    def steps(self) -> int | None:
        """Smallest number of load steps that is asked for."""

    def follow(self, task: Task, progress: Progress) -> Iterator[Accepted]:
        """Yield the accepted steps after those of `progress`.

        Raises
        ------
        StepFailed
            If a step finds no equilibrium.
        """
