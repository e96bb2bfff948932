"""Second-order models of a problem, and the one matrix that solves for all of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ngcell.clock import Clock
from ngcell.solve.coarse import Bodies
from ngcell.solve.one_sided import Matrix, OneSidedModel
from ngcell.solve.options import MinimiserOptions
from ngcell.solve.problem import Linearisation, Problem, State
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.stiffness import Stiffness
from ngcell.solve.system import System, direct_system, iterative_system, lower_triangle
from ngcell.solve.width import width_of_bodies

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
    """

    problem: Problem
    longest_step: float
    options: MinimiserOptions
    clock: Clock
    _system: System | None = None

    def model(self, state: State, line: Linearisation, proximal: ProximalTerm) -> tuple[OneSidedModel, Matrix]:
        """Return the second-order model about a state with its proximal term, and the matrix that solves for it."""
        with self.clock.phase("assembly"):
            self.make_system(state)
            system, free = self.system, self.problem.free
            values = system.metric.add(system.of_pattern(line.stiffness), proximal.weight)
            moving = None if line.curvature is None else line.curvature.tocsr()
            gradient = line.gradient + proximal.gradient(state.displacement, self.problem.metric)
            gradient, stiffness = np.where(free, gradient, 0.0), Stiffness(values, moving)
            model = OneSidedModel(gradient, stiffness, line.gap, line.jacobian, line.penalty, free)
            return model, system.matrix

    def convex(self, model: OneSidedModel, state: State) -> OneSidedModel:
        """Return a model about a state in which no gap that is closed bends the energy downwards."""
        with self.clock.phase("assembly"):
            curvature = self.problem.convex_curvature(state)
            return model.bent_by(None if curvature is None else curvature.tocsr())

    def damped(self, model: OneSidedModel, damping: Array) -> OneSidedModel:
        """Return a model with a damping of each body, an array of shape (bodies,) [stress / length**2]."""
        if not damping.any():
            return model
        values = self.system.metric.add(model.stiffness.values.copy(), damping[self.problem.solid])
        return replace(model, stiffness=replace(model.stiffness, values=values))

    def massive(self, model: OneSidedModel, weight: float) -> OneSidedModel:
        """Return a model with a multiple of the mass matrix [stress / length**2]."""
        row, column, entries = lower_triangle(self.problem.mass)
        values = model.stiffness.values.copy()
        values[self.system.matrix.locate(row, column)] += weight * entries
        return replace(model, stiffness=replace(model.stiffness, values=values))

    def adopt(self, other: Assembly) -> None:
        """Take over the matrix of a problem that has the same unknowns and bodies, if there is none yet."""
        if self._system is None and all(map(np.array_equal, self.problem.pattern, other.problem.pattern)):
            self._system = other._system

    def forget(self) -> None:
        """Make room for closed walls anew, so that the order of elimination tells nothing of earlier minimisations."""
        if self._system is not None:
            self._system.matrix.forget()

    def release(self) -> None:
        """Give the matrix back; the next model makes another one."""
        self._system = None

    @cached_property
    def is_iterative(self) -> bool:
        """Whether systems are solved by iterations, and not factorised in one piece."""
        if len(self.problem.free) <= self.options.most_direct or self.problem.dimension == 2:
            return False
        return width_of_bodies(self.problem) > self.options.narrow

    @property
    def has_system(self) -> bool:
        """Whether a matrix has been made."""
        return self._system is not None

    @property
    def system(self) -> System:
        """The matrix that was made last."""
        assert self._system is not None  # `model` has made one
        return self._system

    def make_system(self, state: State) -> None:
        """Make the matrix, if there is none yet."""
        if self._system is None and self.is_iterative:
            self._system = iterative_system(self.problem)
        elif self._system is None:
            touched = np.unique(np.concatenate(self.problem.couplings(state, 0.0)))
            bodies = Bodies.of(self.problem, self.options.inner.coarse)
            self._system = direct_system(self.problem, touched, self.options.near * self.longest_step, bodies)
