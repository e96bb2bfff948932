"""Descent to a minimum of an energy with one-sided penalty terms: Newton's method with a proximal term.

Each iteration minimises the second-order model of the energy plus ``damping/2 |d|^2`` in a metric. A step is taken
if the energy falls by a fair share of what the model foresaw; if not, or if the model is not convex along it, the
damping is raised, in the bodies where the model fails (`ngcell.solve.damping`), and the model, still at hand, is
minimised again. The damping falls with every good step and is exactly zero at the end, so it leaves no trace in the
result (`ngcell.solve.newton` finds the steps). Where contact has multipliers, a model that is not convex is first taken
without the part of the curvature of gaps that bends it downwards: walls that slide a long way then take half of the
iterations. What is convex though the energy is not makes steps that are too short, and near a saddle they grow by a
fourth each; where the energy falls nearly straight on along a step, longer ones are tried.
Near the minimum differences of energies drown in round-off: there the model is trusted, and forces along its step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ngcell.clock import Clock
from ngcell.solve.assembly import Assembly
from ngcell.solve.curved import Curved
from ngcell.solve.damping import Damper
from ngcell.solve.effort import Budget, Effort
from ngcell.solve.inner import minimise_one_sided
from ngcell.solve.last_digits import Rounding, without_last_digits
from ngcell.solve.minimum import Advance, Ending, Minimum
from ngcell.solve.newton import Newton
from ngcell.solve.one_sided import Matrix, OneSidedModel
from ngcell.solve.options import MinimiserOptions
from ngcell.solve.problem import Problem, State
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.stall import Progress
from ngcell.solve.trials import Trials

Array = NDArray[np.float64]


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

    @cached_property
    def assembly(self) -> Assembly:
        """The models of the problem, and its matrix."""
        return Assembly(self.problem, self.longest_step, self.options, self.clock)

    @cached_property
    def _damper(self) -> Damper:
        return Damper(self.problem.metric, self.problem.solid, self.options)

    @cached_property
    def _newton(self) -> Newton:
        return Newton(self._damper, self.longest_step, self.options, self.clock, self.effort)

    def minimise(
        self,
        start: Array,
        proximal: ProximalTerm,
        tolerance: float = 0.0,
        most: int | None = None,
        lowest: float = -np.inf,
        *,
        is_settled: bool = False,
    ) -> Minimum:
        """Descend from `start` until the Newton decrement is below `tolerance` [energy], or lost in round-off.

        It ends after `most` iterations, by default as many as the options say, where they lead nowhere, and once the
        energy is below `lowest`. Models of walls that have settled are minimised as far as the one before was right:
        before, most of that would be in vain, and chooses between branches. There the decrement of the next step is
        foreseen, too.
        """
        state, damping, decrement, misfit = self._at(start), self._damper.none, float("inf"), float("inf")
        progress = Progress(self.options.idle)
        if not np.isfinite(state.energy):
            return Minimum(state, Ending.NO_ENERGY, decrement, proximal)
        for _ in range(most or self.options.most_iterations):
            self.clock.check()
            self.effort.iterations += 1
            self.budget.charge(self.effort)
            total, refusals = self.total(state, proximal), self.effort.refusals
            advance = self._descend(state, proximal, damping, tolerance, misfit)
            if advance is None:
                return Minimum(state, self._ending_of_stall(state, proximal), decrement, proximal)
            state, damping, decrement = advance.state, advance.damping, advance.decrement
            misfit = advance.misfit if is_settled else misfit
            if state.energy < lowest:
                return Minimum(state, Ending.SLID, decrement, proximal)
            left = self._foreseen(advance, proximal) if is_settled and decrement > tolerance else decrement
            if not advance.was_damped and (left <= tolerance or self._is_lost(state, left)):
                return Minimum(state, Ending.CONVERGED, left, proximal)
            if self.problem.note_kinks(state):
                state = self._at(state.displacement)
            progress.note(decrement, total, self.effort.refusals > refusals or advance.was_held(self.longest_step))
            if progress.creeps(self.total(state, proximal), tolerance):
                return Minimum(state, Ending.STALLED, decrement, proximal)
            if progress.rests_below(self._unseen(state)):
                return Minimum(state, self._ending_of_stall(state, proximal), decrement, proximal)
        return Minimum(state, Ending.TOO_MANY_ITERATIONS, decrement, proximal)

    def predict(self, displacement: Array, imposed: Array, weight: float) -> Array:
        """Return the displacement that follows, to first order, when prescribed values jump to those of `imposed`.

        Walls that touch stay closed; `weight` [stress / length**2] holds what else would float.
        """
        jump, model, matrix = self._jump(displacement, imposed, weight)
        touching = np.flatnonzero(model.gap <= self.options.touching * self.longest_step)
        jacobian, penalty = model.jacobian[touching], model.penalty[touching]
        matrix.factorise(model.stiffness, jacobian, penalty)
        self.effort.factorisations += 1
        pulled = matrix.multiply(model.stiffness, jump) + jacobian.T @ (penalty * (jacobian @ jump))
        return np.asarray(displacement + jump - matrix.solve(pulled))

    def foresee(self, displacement: Array, imposed: Array, weight: float) -> Array:
        """Return what `predict` does, with walls that open and close as the linearised gaps of all near ones say.

        Where the displacement is no equilibrium, as where bodies overlap at rest, what is out of balance stays so.
        """
        jump, model, matrix = self._jump(displacement, imposed, weight)
        driven = matrix.multiply(model.stiffness, jump) - model.pulled(model.penalty * np.minimum(model.gap, 0))
        moved = replace(model, gradient=np.where(self.problem.free, driven, 0.0), gap=model.gap + model.jacobian @ jump)
        found = minimise_one_sided(moved, matrix, self.options.foreseeing)
        self.effort.factorisations += found.factorisations
        return displacement + jump + found.step

    def _jump(self, displacement: Array, imposed: Array, weight: float) -> tuple[Array, OneSidedModel, Matrix]:
        """Return what prescribed values change by, and the model about a displacement."""
        state, held = self._at(displacement), ProximalTerm(weight, displacement)
        model, matrix = self.assembly.model(state, self.problem.linearise(state), held)
        return np.where(self.problem.free, 0.0, imposed - displacement), model, matrix

    def stiffened(self, minimum: Minimum, weight: float) -> Callable[[Array], Array]:
        """Return what solves with the tangent at a minimum plus a multiple of the mass; closed walls stay so."""
        line = self.problem.linearise(minimum.state)
        model, matrix = self.assembly.model(minimum.state, line, replace(minimum.proximal, weight=0.0))
        model = self.assembly.massive(model, weight)
        closed = np.flatnonzero(model.gap < 0)
        matrix.factorise(model.stiffness, model.jacobian[closed], model.penalty[closed])
        self.effort.factorisations += 1
        return matrix.solve

    def rounded(self, place: Array, digits: float = 1.0) -> Array:
        """Return a place without its last digits; so many times as large ones."""
        return without_last_digits(place, self.problem.free, digits * self.options.last_digit * self.longest_step)

    def make_matrix(self, displacement: Array) -> None:
        """Make the matrix of this problem, if there is none yet."""
        if not self.assembly.has_system:
            self.assembly.make_system(self._at(displacement))

    def adopt_matrix(self, other: Minimiser) -> None:
        """Take over a matrix of the same unknowns and bodies, if there is none yet."""
        self.assembly.adopt(other.assembly)

    def forget_matrix(self) -> None:
        """Make the next matrix anew: its order of elimination tells nothing of earlier ones."""
        self.assembly.forget()

    def release_matrix(self) -> None:
        """Give the memory of the matrix back, and what the problem can do without."""
        self.assembly.release()
        self.problem.release()

    @property
    def is_iterative(self) -> bool:
        """Whether systems are solved by iterations, and not factorised in one piece."""
        return self.assembly.is_iterative

    def proximal_energy(self, displacement: Array, proximal: ProximalTerm) -> float:
        """Return the energy of a proximal term."""
        return proximal.value(displacement, self.problem.metric)

    def total(self, state: State, proximal: ProximalTerm) -> float:
        """Return the energy with that of a proximal term."""
        return state.energy + self.proximal_energy(state.displacement, proximal)

    def _foreseen(self, advance: Advance, proximal: ProximalTerm) -> float:
        """Return the decrement of the next step: near a minimum, decrements are as the squares of forces."""
        left = float(np.linalg.norm(self._force(advance.state, proximal))) / advance.force
        return self.options.sure * advance.decrement * left**2

    def _force(self, state: State, proximal: ProximalTerm) -> Array:
        """Return the gradient of the energy with that of a proximal term, 0 where values are prescribed."""
        force = self.problem.gradient(state) + proximal.gradient(state.displacement, self.problem.metric)
        return np.where(self.problem.free, force, 0.0)

    def _is_lost(self, state: State, decrement: float) -> bool:
        """Return whether a decrement is round-off of the energy."""
        least = self.options.no_decrement
        return bool(decrement <= max(least * abs(state.energy), least**1.5 * self.energy_scale))

    def _unseen(self, state: State) -> float:
        """Return the decrement that is lost where iterations lead nowhere [energy]."""
        least, noise = self.options.stalled, self.options.unseen * self.options.noise
        return max(least * abs(state.energy), noise * self.energy_scale)

    def _ending_of_stall(self, state: State, proximal: ProximalTerm) -> Ending:
        """Return what iterations that lead nowhere mean: damping makes decrements small, whatever the forces are."""
        model, matrix = self.assembly.model(state, self.problem.linearise(state), proximal)
        found, least = self._newton.step(model, matrix), self._unseen(state)
        return Ending.STALLED if found.change <= 0 and found.decrement <= least else Ending.NO_DESCENT

    def _at(self, displacement: Array) -> State:
        with self.clock.phase("pairs and energies"):
            self.effort.evaluations += 1
            return self.problem.at(displacement)

    def _descend(
        self, state: State, proximal: ProximalTerm, damping: Array, tolerance: float, misfit: float
    ) -> Advance | None:
        """Return the next iterate, or None if no damping makes a step that lowers the energy.

        A state whose own decrement is within the tolerance is the last but one, even where a kink spoils its step.
        """
        with self.clock.phase("assembly"):
            line = self.problem.linearise(state)
        energy = self.total(state, proximal)
        lost = max(self.options.round_off * abs(energy), self.options.noise * self.energy_scale)
        undamped, matrix = self.assembly.model(state, line, proximal)
        is_last, is_whole = False, undamped.is_bent and self.problem.has_multipliers
        curved, force = Curved(self.problem, self._newton, state, line), float(np.linalg.norm(undamped.full_gradient))
        for _ in range(self.options.most_refusals):
            model = self.assembly.damped(undamped, damping)
            found, lacking = self._newton.step(model, matrix, misfit), self._damper.none
            step, change, slope = found.step, found.change, found.slope
            is_convex, is_led = change <= 0 and slope <= 0, bool(damping.any()) or found.not_convex is not None
            is_last = is_last or (is_convex and not is_led and found.decrement <= tolerance)
            if is_convex and found.share < self.options.short:
                damping = self._damper.shortened(damping, step, slope)
                self.effort.refusals += 1
                continue
            if is_convex:
                digit = self.options.last_digit * self.longest_step
                rounding = Rounding(model, matrix, digit, self.options.cheap * -change)
                trials = Trials(self.problem, self._at, state, proximal, rounding, energy)
                trial, gain = trials.after(step)
                if -lost < change and -lost < gain:
                    is_exact = self._is_lost(state, found.decrement - tolerance)
                    trial = trial if is_exact else trials.balanced(step, slope, trial, self._force)
                    return Advance(trial, self._damper.none, found.decrement, is_led, force=force)
                least = self.options.poor * -change
                if gain <= least:
                    model = self.assembly.damped(undamped := curved.with_kinks(undamped, trial), damping)
                    bent = curved.corrected((model, matrix), step, trial, least - gain)
                    again = (trial, gain) if bent is None else trials.after(bent)
                    trial, gain = again if again[1] > least else (trial, gain)
                if not gain >= self.options.fair * -change:  # or no energy at all
                    lacking = self._lacking(undamped, matrix, step, trial, proximal)
                if change < 0 and gain > least:
                    if not is_led and gain > self.options.straight * -change:
                        trial, gain = trials.farther(step, (trial, gain), self.longest_step)
                    relaxed = self._damper.relaxed(damping, step, slope, lacking, gain / -change)
                    off = float("inf") if is_led or found.share < 1 else abs(gain / -change - 1)
                    return Advance(trial, relaxed, found.decrement, is_led and not is_last, off, force, step)
            if not is_convex and is_whole:
                undamped, is_whole = self.assembly.convex(undamped, state), False
            elif is_convex or found.not_convex is None:
                damping = self._damper.raised(damping, step, slope, lacking)
            else:
                damping = self._damper.straightened(damping, *found.not_convex)
            self.effort.refusals += 1
        return None

    def _lacking(
        self, model: OneSidedModel, matrix: Matrix, step: Array, trial: State, proximal: ProximalTerm
    ) -> Array:
        """Return what the energy of each body has beyond a model after a step [energy], 1 where one has folded."""
        if not np.isfinite(trial.energy):
            return self.problem.folded(trial).astype(float)
        with self.clock.phase("assembly"):
            foreseen = model.gradient_after(matrix.multiply(model.stiffness, step), model.jacobian @ step)
            found = self._force(trial, proximal)
        return self._damper.by_body(np.where(self.problem.free, 0.5 * (found - foreseen) * step, 0.0))
