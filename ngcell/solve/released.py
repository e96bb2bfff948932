"""The released problem: walls in unilateral contact, and how one of its equilibria is selected."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.conditions import until_conditions_hold
from ngcell.solve.continuation import Continuation
from ngcell.solve.effort import Effort
from ngcell.solve.handing_over import HandingOver
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.options import SolverOptions
from ngcell.solve.outcome import Outcome
from ngcell.solve.problem import Problem
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.refined import stable
from ngcell.solve.step import Accepted, StepFailed, spent

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Released:
    """The released problem and the path on which its equilibria are selected.

    Attributes
    ----------
    apart : Minimiser
        Without contact.
    minimisers : tuple of Minimiser
        With contact from the softest, which follows the path, to the one that is meant.
    path : Continuation
        The path.
    is_alone : bool
        Whether there is one body only: it touches nothing, and no path has to be followed unless the straight way
        fails.
    is_mixed : bool
        Whether some bodies are stiffer than others. A decrement sees forces divided by stiffness, and would end with
        those on stiff bodies out of balance: there the last minimisation goes down to round-off.
    options : SolverOptions
        The solver's own numbers; those of the path are the path's.
    """

    apart: Minimiser
    minimisers: tuple[Minimiser, ...]
    path: Continuation
    is_alone: bool = False
    is_mixed: bool = False
    options: SolverOptions = field(default_factory=SolverOptions)

    @property
    def effort(self) -> Effort:
        """What was spent so far."""
        return spent((self.apart, *self.minimisers))

    @property
    def problem(self) -> Problem:
        """The problem that is meant, with its history."""
        return self.minimisers[-1].problem

    def apply(self, load: float) -> None:
        """Let all loads act as at this load factor."""
        for minimiser in (self.apart, *self.minimisers):
            minimiser.problem.apply(load)

    def forget_matrices(self) -> None:
        """Let what follows depend on where it starts alone, and on no matrix of an earlier place."""
        for minimiser in (self.apart, *self.minimisers):
            minimiser.forget_matrix()

    @property
    def longest_step(self) -> float:
        """The length beside which missed conditions are judged [length]."""
        return self.minimisers[-1].longest_step

    def predict(self, displacement: Array, imposed: Array) -> Array:
        """Return the displacement that follows, to first order, when prescribed values jump.

        Bodies are held back where they would run ahead: one that only slides, as a disc that turns in a ring, is driven
        by the round-off of its mesh alone, and a vanishing proximal term would send it anywhere. Where values jump by
        more than a longest step, walls are seen to open and close; shorter jumps meet them on the path.
        """
        options, minimiser = self.path.options, self.minimisers[-1]
        jump = float(np.abs(imposed - displacement).max())
        limit = options.farthest * max(self.longest_step, jump)
        is_long = jump > self.longest_step
        predict = minimiser.foresee if is_long else minimiser.predict
        weight = self.path.scale * (max(options.stiffen_at, options.last) if is_long else options.last)
        while True:
            foreseen = predict(displacement, imposed, weight)
            if float(np.abs(foreseen - displacement).max()) <= limit or weight > self.path.scale * options.first:
                return foreseen
            weight *= options.hold_back

    def pieces(self, displacement: Array, imposed: Array) -> int:
        """Return in how many increments prescribed values are to jump for no wall to be passed unseen.

        Contact is searched within two longest steps: walls of which none moves further than one of them cannot pass
        each other. Where nothing can touch on the whole way, one increment does.
        """
        way = float(np.abs(imposed - displacement).max())
        if self.is_alone or way <= self.longest_step or not self._may_touch(displacement, way):
            return 1
        return int(np.ceil(way / self.longest_step * (1 - 1e-9)))

    def _may_touch(self, displacement: Array, way: float) -> bool:
        """Return whether bodies may come into contact while nothing moves by more than `way` [length]."""
        row, column = self.problem.couplings(self.problem.at(displacement), 2 * way)
        return bool((self.problem.part[row] != self.problem.part[column]).any())

    def step(self, start: Array, centre: Array, load: float, *, may_stall: bool = True) -> Accepted:
        """Return the selected equilibrium; see `Continuation.select`.

        Raises
        ------
        StepFailed
            If a minimisation on the path fails.
        """
        before = self.effort
        self.apply(load)
        proximal = self.path.last_proximal(centre)
        minimum = self._alone(start, proximal) or self._selected(start, centre, may_stall)
        if minimum.ending is Ending.NO_ENERGY:  # elements were folded between the points of a rule that is finer now
            minimum = self._selected(start, centre, may_stall)
        if self.is_mixed and minimum.is_found:
            exact = self.minimisers[-1].minimise(minimum.state.displacement, minimum.proximal)
            minimum = replace(exact, to_fall=minimum.to_fall) if exact.is_found else minimum
        minimum = self._stable(minimum)
        if not minimum.is_found:
            raise StepFailed(Outcome.RELEASE_FAILED, load)
        return Accepted("released", load, minimum, self.effort - before)

    def _stable(self, minimum: Minimum) -> Minimum:
        """Return the minimum with its lowest curvature; one below it, at rest, if it is a saddle."""
        return stable(self.minimisers[-1], minimum, length=self.longest_step, options=self.options, path=self.path)

    def _selected(self, start: Array, centre: Array, may_stall: bool) -> Minimum:
        """Return the end of the path; where contact turns out too soft to follow it, that of a stiffer stage's.

        Soft contact lets bodies that hardly change their volume sink into each other until the nearest wall of a point
        changes from one to the next.
        """
        self.minimisers[0].make_matrix(start)
        self.apart.adopt_matrix(self.minimisers[0])
        begin = self.path.begin(self.apart, start, centre)
        if not begin.is_found:
            return begin
        is_led, stages, path = self._is_led, self.minimisers, self.path
        if is_led:
            stages, path = stages[:-1], replace(path, options=replace(path.options, only_leads=True))
        for first in range(len(stages)):
            minimum = path.select(begin.state, stages[first:], centre, may_stall=may_stall)
            if minimum.is_found or minimum.ending is Ending.NO_ENERGY:
                break
            if first + 1 < len(stages):
                stages[first + 1].problem.start_from(stages[first].problem, minimum.state)
        if is_led and minimum.is_found:
            minimum = self.handed_over(minimum, stages[-1].problem)
        return minimum

    @property
    def _is_led(self) -> bool:
        """Whether a penalty follows the whole path, and multipliers come in at its end."""
        ends_early = self.path.options.sufficient > 0 and not self.path.options.only_leads
        return ends_early and len(self.minimisers) > 1 and self.problem.has_multipliers

    def handed_over(
        self, led: Minimum, before: Problem, *, may_slide: bool = True, leads_below: float = -np.inf
    ) -> Minimum:
        """Return the equilibrium by the contact that is meant, beside one of the problem `before`, which leads to it;
        see `HandingOver.equilibrium`."""
        leads, last = self.minimisers[-2:]
        handing = HandingOver(leads, last, self.path, self.options)
        return handing.equilibrium(led, before, may_slide=may_slide, leads_below=leads_below)

    def _alone(self, start: Array, proximal: ProximalTerm) -> Minimum | None:
        """Return the minimum of a body that is alone; None if there are more, or if none was found."""
        if not self.is_alone:
            return None
        minimiser = self.minimisers[-1]
        minimiser.problem.reset()  # no softer stage leads to it, from which its contact would begin to adapt
        minimum = minimiser.minimise(start, proximal)
        if minimum.is_found:
            minimum = until_conditions_hold(minimiser, minimum, self.longest_step, self.path.options)
        return minimum if minimum.is_found else None
