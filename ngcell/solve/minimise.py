"""Descent to a minimum of an energy with one-sided penalty terms: Newton's method with a proximal term.

Each iteration minimises the second-order model of the energy plus ``damping/2 |d|^2`` in the mass norm. A step is taken
if the energy falls by a fair share of what the model foresaw; if not, or if the model is not convex along it, the
damping is raised and the model, still at hand, is minimised again. The damping falls with every good step and is
exactly zero at the end, so it leaves no trace in the result. No component of a step is longer than `longest_step`: half
of the distance in which contact is searched, so that no wall is passed unseen.

Near the minimum differences of energies drown in round-off. There the model alone is trusted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.clock import Clock
from ngcell.solve.effort import Budget, Effort
from ngcell.solve.minimum import Advance, Ending, Minimum
from ngcell.solve.one_sided import Matrix, OneSidedModel, minimise_one_sided
from ngcell.solve.options import MinimiserOptions
from ngcell.solve.problem import Linearisation, Problem, State
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.system import System, direct_system, iterative_system

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass
class Minimiser:
    """Minimises one problem again and again, keeping its matrix.

    Parameters
    ----------
    problem : Problem
        What is minimised.
    longest_step : float
        Largest change of a displacement unknown in one iteration [length].
    energy_scale : float
        An energy beside which that of an undeformed state is nothing: a modulus times the volume [energy].
    options : MinimiserOptions
        The method's own numbers.
    clock : Clock
        Where the seconds are added up.
    budget : Budget, optional
        The work that is left of a step.
    """

    problem: Problem
    longest_step: float
    energy_scale: float
    options: MinimiserOptions = field(default_factory=MinimiserOptions)
    clock: Clock = field(default_factory=Clock)
    effort: Effort = field(default_factory=Effort)
    budget: Budget = field(default_factory=Budget)
    _system: System | None = None
    _near_at: Array | None = None
    _may_touch: bool = False

    def minimise(
        self, start: Array, proximal: ProximalTerm, tolerance: float = 0.0, most: int | None = None
    ) -> Minimum:
        """Descend from `start` until the Newton decrement is below `tolerance` [energy], or lost in round-off.

        It ends after `most` iterations, by default as many as the options say.
        """
        state, damping, decrement = self._at(start), 0.0, float("inf")
        lowest, idle = decrement, 0
        if not np.isfinite(state.energy):
            return Minimum(state, Ending.NO_ENERGY, decrement, proximal)
        for _ in range(most or self.options.most_iterations):
            self.clock.check()
            self.effort.iterations += 1
            self.budget.charge(self.effort)
            advance = self._descend(state, proximal, damping, tolerance)
            if advance is None:
                return Minimum(state, Ending.NO_DESCENT, decrement, proximal)
            state, damping, decrement = advance.state, advance.damping, advance.decrement
            if advance.damping_used == 0 and (decrement <= tolerance or self._is_lost(state, decrement)):
                return Minimum(state, Ending.CONVERGED, decrement, proximal)
            if decrement < lowest / 4:
                lowest, idle = decrement, 0
            elif decrement <= 4 * lowest:
                idle += 1
            if idle == self.options.idle and lowest <= self._unseen(state):
                return Minimum(state, self._ending_of_stall(state, proximal), decrement, proximal)
        return Minimum(state, Ending.TOO_MANY_ITERATIONS, decrement, proximal)

    def predict(self, displacement: Array, imposed: Array, weight: float) -> Array:
        """Return the displacement that follows, to first order, when prescribed values jump to those of `imposed`.

        Walls that touch stay closed; `weight` [stress / length**2] holds what else would float.
        """
        state = self._at(displacement)
        jump = np.where(self.problem.free, 0.0, imposed - displacement)
        model, matrix = self._model(state, self.problem.linearise(state), ProximalTerm(weight, displacement), 0.0)
        touching = np.flatnonzero(model.gap <= self.options.touching * self.longest_step)
        values = matrix.add_penalty_terms(model.stiffness, model.jacobian[touching], model.penalty[touching])
        matrix.factorise(values)
        self.effort.factorisations += 1
        return displacement + jump - matrix.solve(matrix.multiply(values, jump))

    def foresee(self, displacement: Array, imposed: Array, weight: float) -> Array:
        """Return what `predict` does, with walls that open and close as the linearised gaps of all near ones say.

        Where the displacement is no equilibrium, as where bodies overlap at rest, it stays so: what is out of balance
        does not count.
        """
        state = self._at(displacement)
        jump = np.where(self.problem.free, 0.0, imposed - displacement)
        model, matrix = self._model(state, self.problem.linearise(state), ProximalTerm(weight, displacement), 0.0)
        driven = matrix.multiply(model.stiffness, jump) - model.pulled(model.penalty * np.minimum(model.gap, 0))
        driven = np.where(self.problem.free, driven, 0.0)
        moved = replace(model, gradient=driven, gap=model.gap + model.jacobian @ jump)
        step, _, rounds = minimise_one_sided(moved, matrix, self.options.foreseeing)
        self.effort.factorisations += rounds
        return displacement + jump + step

    def stiffened(self, minimum: Minimum, weight: float) -> Callable[[Array], Array]:
        """Return what solves with the tangent at a minimum plus a multiple of the mass; closed walls stay so."""
        line = self.problem.linearise(minimum.state)
        model, matrix = self._model(minimum.state, line, minimum.proximal, weight)
        closed = np.flatnonzero(model.gap < 0)
        matrix.factorise(matrix.add_penalty_terms(model.stiffness, model.jacobian[closed], model.penalty[closed]))
        self.effort.factorisations += 1
        return matrix.solve

    def adopt_matrix(self, other: Minimiser) -> None:
        """Take over the matrix of a minimiser that has the same unknowns and bodies, if there is none yet."""
        self._system = self._system or other._system

    def forget_matrix(self) -> None:
        """Make the next matrix anew, so that its order of elimination tells nothing of earlier minimisations."""
        self._system = self._near_at = None

    def proximal_energy(self, displacement: Array, proximal: ProximalTerm) -> float:
        """Return the energy of a proximal term."""
        return proximal.value(displacement, self.problem.mass)

    @property
    def is_iterative(self) -> bool:
        """Whether systems are solved by iterations, and not factorised in one piece."""
        return len(self.problem.free) > self.options.most_direct and self.problem.dimension == 3

    @property
    def _noise(self) -> float:
        return self.options.noise * self.energy_scale

    def _is_lost(self, state: State, decrement: float) -> bool:
        """Return whether a decrement is round-off of the energy."""
        least = self.options.no_decrement
        return bool(decrement <= max(least * abs(state.energy), least**1.5 * self.energy_scale))

    def _unseen(self, state: State) -> float:
        """Return the decrement that is lost where iterations lead nowhere [energy]."""
        return max(self.options.stalled * abs(state.energy), self.options.unseen * self._noise)

    def _ending_of_stall(self, state: State, proximal: ProximalTerm) -> Ending:
        """Return what iterations that lead nowhere mean: damping makes decrements small, whatever the forces are."""
        model, matrix = self._model(state, self.problem.linearise(state), proximal, 0.0)
        step, change = self._step(model, matrix)
        is_balanced = change <= 0 and -float(model.full_gradient @ step) <= self._unseen(state)
        return Ending.STALLED if is_balanced else Ending.NO_DESCENT

    def _at(self, displacement: Array) -> State:
        self.effort.evaluations += 1
        with self.clock.phase("pairs and energies"):
            return self.problem.at(displacement)

    def _descend(self, state: State, proximal: ProximalTerm, damping: float, tolerance: float) -> Advance | None:
        """Return the next iterate, or None if no damping makes a step that lowers the energy.

        A state whose own decrement is within the tolerance is the last but one, even where a kink spoils its step.
        """
        with self.clock.phase("assembly"):
            line = self.problem.linearise(state)
        energy = state.energy + self.proximal_energy(state.displacement, proximal)
        lost = max(self.options.round_off * abs(energy), self._noise)
        (model, matrix), is_last = self._model(state, line, proximal, damping), False
        for _ in range(self.options.most_refusals):
            step, change = self._step(model, matrix)
            decrement = -float(model.full_gradient @ step)
            if change <= 0 <= decrement:
                trial, gain = self._tried(state, step, proximal, energy)
                if -lost < change and -lost < gain:
                    return Advance(trial, 0.0, decrement, damping)
                if gain <= self.options.poor * -change:
                    bent = self._bent(line, (model, matrix), step, trial, self.options.poor * -change - gain)
                    if bent is not None:
                        bent_trial, bent_gain = self._tried(state, bent, proximal, energy)
                        if bent_gain > self.options.poor * -change:
                            trial, gain = bent_trial, bent_gain
                quality = gain / -change if change < 0 else -np.inf
                is_last = is_last or (damping == 0 and decrement <= tolerance)
                if quality > self.options.poor:
                    relaxed = self._relaxed(damping, quality, model, step)
                    return Advance(trial, relaxed, decrement, 0.0 if is_last else damping)
            raised = max(self.options.raise_by * damping, self._weight_of(self.options.felt, model, step))
            stiffness = self._required.with_metric(model.stiffness, raised - damping)
            model, damping = replace(model, stiffness=stiffness), raised
            self.effort.refusals += 1
        return None

    def _tried(self, state: State, step: Array, proximal: ProximalTerm, energy: float) -> tuple[State, float]:
        """Return the state after a step, and by how much its energy is below `energy`."""
        trial = self._at(self.problem.move(state.displacement, step))
        return trial, energy - trial.energy - self.proximal_energy(trial.displacement, proximal)

    def _bent(
        self, line: Linearisation, system: tuple[OneSidedModel, Matrix], step: Array, trial: State, lacking: float
    ) -> Array | None:
        """Return a step that follows the curvature of gaps; None where it is of no use.

        Cells that slide or roll on each other move along curves. What the gaps after a step turned out to be beyond
        their linear parts is added to the penalty terms, and the model is minimised again: a second-order correction.
        It wins back what the penalty terms store beyond the model; where the energy that is `lacking` is more, it is
        not tried.
        """
        model, matrix = system
        if not np.isfinite(trial.energy) or not len(model.gap):
            return None
        foreseen = model.gap + model.jacobian @ step
        keys, gaps = self.problem.gaps(trial)
        place = np.minimum(np.searchsorted(keys, line.keys), max(len(keys) - 1, 0))
        known = keys[place] == line.keys if len(keys) else np.zeros(len(line.keys), dtype=bool)
        surplus = np.where(known, gaps[place] - foreseen, 0.0) if len(keys) else np.zeros_like(foreseen)
        if not known.any() or float(np.abs(surplus).max()) > self.longest_step:
            return None
        if model.stored(foreseen + surplus) - model.stored(foreseen) <= lacking:
            return None
        bent, change = self._step(replace(model, gap=model.gap + surplus), matrix)
        return bent if change <= 0 else None

    def _step(self, model: OneSidedModel, matrix: Matrix) -> tuple[Array, float]:
        """Return a step no longer than allowed, and the change of the model."""
        with self.clock.phase("factorisation"):
            step, change, rounds = minimise_one_sided(model, matrix, self.options.inner)
        self.effort.factorisations += rounds
        longest = float(np.abs(step).max())
        if longest > self.longest_step:
            step = step * (self.longest_step / longest)
            change = model.change(step, matrix.multiply(model.stiffness, step), model.jacobian @ step)
        return step, change

    def _relaxed(self, damping: float, quality: float, model: OneSidedModel, step: Array) -> float:
        """Return the damping after an accepted step; one that is not felt along the step becomes zero."""
        unfelt = self._weight_of(self.options.unfelt, model, step)
        if quality < self.options.fair:
            return max(self.options.nudge_by * damping, unfelt)
        return self.options.lower_by * damping if self.options.lower_by * damping > unfelt else 0.0

    def _weight_of(self, share: float, model: OneSidedModel, step: Array) -> float:
        """Return the damping whose curvature along the step is this share of the model's slope along it."""
        weight = float(step @ (self.problem.mass @ step))
        return share * abs(float(model.full_gradient @ step)) / max(weight, np.finfo(float).tiny)

    def _model(
        self, state: State, line: Linearisation, proximal: ProximalTerm, damping: float
    ) -> tuple[OneSidedModel, Matrix]:
        """Return the second-order model with its proximal term and damping, and the matrix that solves for it."""
        with self.clock.phase("assembly"):
            self._make_room(state)
            system, free = self._required, self.problem.free
            values = system.with_metric(system.of_pattern(line.stiffness), proximal.weight + damping)
            if line.curvature is not None:
                values = system.matrix.add(values, line.curvature)
            gradient = line.gradient + proximal.gradient(state.displacement, self.problem.mass)
            model = OneSidedModel(np.where(free, gradient, 0.0), values, line.gap, line.jacobian, line.penalty, free)
            return model, system.matrix

    @property
    def _required(self) -> System:
        assert self._system is not None  # `_make_room` has made one
        return self._system

    def _is_near(self, state: State, margin: float) -> bool:
        moved = np.inf if self._near_at is None else float(np.abs(state.displacement - self._near_at).max())
        return moved <= margin / 2 or (self._near_at is not None and not self._may_touch)

    def _make_room(self, state: State) -> None:
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
