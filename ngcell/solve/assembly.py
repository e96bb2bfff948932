"""Second-order models of a problem, and the one matrix that solves for all of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.clock import Clock
from ngcell.solve.effort import Effort
from ngcell.solve.one_sided import Matrix, OneSidedModel
from ngcell.solve.options import MinimiserOptions
from ngcell.solve.problem import Linearisation, Problem, State
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.system import System, direct_system, iterative_system

Array = NDArray[np.float64]


@dataclass
class Assembly:
    """Makes models of one problem, and keeps its matrix.

    Parameters
    ----------
    problem : Problem
        What is modelled.
    longest_step : float
        Largest change of a displacement unknown in one iteration [length].
    options : MinimiserOptions
        The numbers of the minimiser.
    clock : Clock
        Where the seconds are added up.
    effort : Effort
        Where new patterns are counted.
    """

    problem: Problem
    longest_step: float
    options: MinimiserOptions
    clock: Clock
    effort: Effort
    _system: System | None = None
    _near_at: Array | None = None
    _may_touch: bool = False

    def model(self, state: State, line: Linearisation, proximal: ProximalTerm) -> tuple[OneSidedModel, Matrix]:
        """Return the second-order model about a state with its proximal term, and the matrix that solves for it."""
        with self.clock.phase("assembly"):
            self.make_room(state)
            system, free = self.system, self.problem.free
            values = system.with_metric(system.of_pattern(line.stiffness), proximal.weight)
            if line.curvature is not None:
                values = system.matrix.add(values, line.curvature)
            gradient = line.gradient + proximal.gradient(state.displacement, self.problem.mass)
            model = OneSidedModel(np.where(free, gradient, 0.0), values, line.gap, line.jacobian, line.penalty, free)
            return model, system.matrix

    def damped(self, model: OneSidedModel, damping: Array) -> OneSidedModel:
        """Return a model with a damping of each body, an array of shape (bodies,) [stress / length**2]."""
        if not damping.any():
            return model
        return replace(model, stiffness=self.system.with_metric(model.stiffness, damping[self.problem.part]))

    def adopt(self, other: Assembly) -> None:
        """Take over the matrix of a problem that has the same unknowns and bodies, if there is none yet."""
        self._system = self._system or other._system

    def forget(self) -> None:
        """Make the next matrix anew, so that its order of elimination tells nothing of earlier minimisations."""
        self._system = self._near_at = None

    @property
    def is_iterative(self) -> bool:
        """Whether systems are solved by iterations, and not factorised in one piece."""
        return len(self.problem.free) > self.options.most_direct and self.problem.dimension == 3

    @property
    def system(self) -> System:
        """The matrix that was made last."""
        assert self._system is not None  # `make_room` has made one
        return self._system

    def make_room(self, state: State) -> None:
        """Make a matrix, or a new one when walls that may have come into reach have no room in it."""
        if self.is_iterative:
            self._system = self._system or iterative_system(self.problem)
            return
        margin = self.options.margin * self.longest_step
        if self._system is not None and self._is_near(state, margin):
            return
        near = self.problem.couplings(state, margin)
        self._near_at, self._may_touch = state.displacement, bool(len(near[0]))
        if self._system is not None and self._system.matrix.has_room(*near):
            return
        self.effort.patterns += 1
        self._system = direct_system(
            self.problem, self.problem.couplings(state, self.options.wide_margin * self.longest_step)
        )

    def _is_near(self, state: State, margin: float) -> bool:
        moved = np.inf if self._near_at is None else float(np.abs(state.displacement - self._near_at).max())
        return moved <= margin / 2 or (self._near_at is not None and not self._may_touch)
