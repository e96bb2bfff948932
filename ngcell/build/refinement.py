"""From a step on the mesh of the load path to what is reported: finer meshes, one after the other, until the estimated
error is what the scene asks for.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Generic, Protocol, TypeVar, cast

from ngcell.build.options import Options
from ngcell.build.stages import Stage, singular_exponent
from ngcell.clock import Clock
from ngcell.contact.methods.terms import ContactTerm
from ngcell.errors import CaseError
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Array
from ngcell.mechanics.transfer import transferred
from ngcell.problem.problem import Problem
from ngcell.problem.state import State
from ngcell.results.equilibrium import Setup, numbers_of
from ngcell.results.error import Errors, Numbers, Refining, estimate
from ngcell.solve.effort import OutOfIterations
from ngcell.solve.minimise import Minimiser
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.refined import has_contact, settled, stable
from ngcell.solve.released import Released
from ngcell.solve.step import Accepted, spent

_log = logging.getLogger(__name__)

#: Refinements that most runs come to.
_USUAL = 2


class Meshed(Protocol):
    """A scene on one mesh; see `ngcell.build.simulation.Simulation`."""

    clock: Clock
    options: Options
    setup: Setup
    space: DisplacementSpace
    motion: PrescribedMotion

    @property
    def tied(self) -> tuple[Minimiser, ...]:
        """Minimisers of the tied solid."""

    @property
    def closing(self) -> tuple[Minimiser, ...]:
        """Minimisers of the tied solid whose lumens touch themselves; none where no lumen can."""

    @property
    def released(self) -> Released:
        """Minimisers of the released walls."""

    def problem_of(self, phase: str) -> Problem:
        """Return the problem that steps of a phase solve."""

    def renew_budget(self) -> None:
        """Give the minimisers of this mesh all of their iterations."""


Scene = TypeVar("Scene", bound=Meshed)


@dataclass(frozen=True, eq=False)
class Refined(Generic[Scene]):
    """A step on one mesh.

    Attributes
    ----------
    level : int
        Number of the mesh, 0 for that of the load path.
    simulation : Simulation
        The scene on this mesh.
    accepted : Accepted
        The step, with the effort of all meshes.
    errors : Errors
        Its estimated errors.
    is_judged : bool
        Whether they are held to what is asked for: not where none can be estimated, nor of tied states, which walls are
        released from.
    """

    level: int
    simulation: Scene
    accepted: Accepted
    errors: Errors
    is_judged: bool


class Refinement(Generic[Scene]):
    """The meshes of a scene, each built when it is needed.

    Parameters
    ----------
    base : Simulation
        The scene on the mesh of the load path.
    stages : sequence of Stage
        All meshes, the coarsest first.
    build : function
        Makes the scene on the mesh of a stage.
    accuracy : float
        Relative error that is asked for.

    Attributes
    ----------
    estimates : bool
        Whether errors are to be estimated, also where the machine has no room for the finer mesh that it takes.
    """

    def __init__(self, base: Scene, stages: Sequence[Stage], build: Callable[[Stage], Scene], accuracy: float) -> None:
        self._stages, self._build, self._accuracy = list(stages), build, accuracy
        self.estimates = len(self._stages) > 1
        self._levels = [_Level(base)]

    def table(self) -> tuple[dict[str, int], ...]:
        """Return order, grading and unknowns of the meshes that were used, the coarsest first."""
        return tuple(
            {"order": stage.order, "grading": stage.grading, "unknowns": level.simulation.space.unknowns}
            for stage, level in zip(self._stages, self._levels, strict=False)
        )

    def expected(self) -> Scene:
        """Return the scene on the finest mesh that most runs come to."""
        for number in range(1, 1 + _USUAL):
            if self._level(number) is None:
                break
        return self._levels[-1].simulation

    def level(self, number: int) -> Scene:
        """Return the scene on one of the meshes."""
        found = self._level(number)
        assert found is not None
        return found.simulation

    def refine(self, accepted: Accepted) -> Refined[Scene]:
        """Return a step with an error within the accuracy, or with as small a one as there is.

        It depends on the step alone, not on the meshes of steps before it.
        """
        found = self._refined(accepted)
        return found if found.level == 0 else self._levels[found.level].stable(found)

    def _refined(self, accepted: Accepted) -> Refined[Scene]:
        """Return a step on the mesh that it is reported on."""
        is_judged = self.estimates and accepted.phase != "tied"
        last = Refined(0, self._levels[0].simulation, accepted, Errors(), is_judged)
        if not self.estimates:
            return last
        found, refined = [self._numbers(last)], list[Refining]()
        while True:
            finer = self._next(last)
            if finer is None:
                return last
            found.append(self._numbers(finer))
            refined.append(self._stages[finer.level].refining(self._stages[last.level], self._exponent))
            is_reported = self._stages[finer.level].is_reported
            errors = estimate(found, refined, of_last=is_reported)
            _log.info("mesh %d: energy %.6e, estimated error %.1e", finer.level, found[-1].energy, errors.relative)
            if not is_reported:
                effort = finer.accepted.effort
                return replace(last, accepted=replace(last.accepted, effort=effort), errors=errors)
            last = replace(finer, errors=errors)
            if not is_judged or errors.relative <= self._accuracy:
                return last

    @cached_property
    def _exponent(self) -> float:
        return singular_exponent(self._levels[0].simulation.space)

    def _level(self, number: int) -> _Level[Scene] | None:
        """Return a mesh; None where there are no more, or where the machine has no room for it."""
        if number >= len(self._stages):
            return None
        if number == len(self._levels):
            try:
                self._levels.append(_Level(self._build(self._stages[number])))
            except CaseError as error:
                _log.info("no finer mesh: %s", error)
                del self._stages[number:]
                return None
        return self._levels[number]

    def _next(self, coarse: Refined[Scene]) -> Refined[Scene] | None:
        """Return a step on the next mesh; None where there is none, or where it finds no equilibrium."""
        level = self._level(coarse.level + 1)
        if level is None:
            return None
        return level.settled(coarse)

    def _numbers(self, one: Refined[Scene]) -> Numbers:
        simulation, minimum = one.simulation, one.accepted.minimum
        with simulation.clock.phase("measuring"):
            problem = simulation.problem_of(one.accepted.phase)
            return numbers_of(simulation.setup, problem, cast(State, minimum.state), minimum.proximal)


class _Level(Generic[Scene]):
    """The scene on one mesh, with the minimisers that take steps over from the mesh before."""

    def __init__(self, simulation: Scene) -> None:
        self.simulation = simulation

    @cached_property
    def _released(self) -> Released:
        return self.simulation.released

    @cached_property
    def _tied(self) -> tuple[Minimiser, ...]:
        return self.simulation.tied

    @cached_property
    def _closing(self) -> tuple[Minimiser, ...]:
        return self.simulation.closing

    def _tied_at(self, displacement: Array, load: float) -> Minimiser:
        """Return the minimiser of the tied solid: with contact where a body touches itself."""
        if not has_contact(self._closing, displacement, load):
            return self._tied[-1]
        self._closing[-1].problem.reset()
        return self._closing[-1]

    def settled(self, coarse: Refined[Scene]) -> Refined[Scene] | None:
        """Return a step on this mesh that was found on the one before; None where it finds no equilibrium."""
        mine, accepted = self.simulation, coarse.accepted
        load, is_tied = accepted.load_factor, accepted.phase == "tied"
        before = coarse.simulation.problem_of(accepted.phase)

        def taken(displacement: Array) -> Array:
            whole = before.expand(displacement)
            return transferred(whole, coarse.simulation.space, mine.space)

        proximal = accepted.minimum.proximal
        start = mine.motion.imposed(taken(accepted.minimum.state.displacement), load)
        held = ProximalTerm(proximal.weight, taken(proximal.centre) if proximal.weight else start)
        for minimisers in [(self._tied_at(start, load),)] if is_tied else self._attempts():
            effort = spent(minimisers)
            self._prepare(minimisers, before, accepted, start)
            try:
                length, options = self._released.longest_step, mine.options.solver
                path = self._released.path if held.weight else None
                minimum = settled(minimisers, start, held, length=length, options=options, path=path)
            except OutOfIterations:
                return None
            accepted = replace(accepted, effort=accepted.effort + (spent(minimisers) - effort))
            if minimum.is_found:
                accepted = replace(accepted, minimum=minimum)
                return replace(coarse, level=coarse.level + 1, simulation=mine, accepted=accepted)
            _log.info("mesh %d: %s", coarse.level + 1, minimum.ending.value)
        return None

    def _prepare(self, minimisers: Sequence[Minimiser], before: Problem, accepted: Accepted, start: Array) -> None:
        """Let loads act, and terms take over what they may from stages before and from the coarser mesh."""
        mine, released = self.simulation, self._released
        mine.renew_budget()
        if accepted.phase == "tied":
            minimisers[-1].problem.apply(accepted.load_factor)
        else:
            released.apply(accepted.load_factor)
            for softer in released.minimisers[: -len(minimisers)][-1:]:  # none where contact has one stage
                minimisers[0].problem.start_from(softer.problem, softer.problem.at(start))
        mine.problem_of(accepted.phase).refine(before, cast(State, accepted.minimum.state))

    def _attempts(self) -> list[tuple[Minimiser, ...]]:
        """Return minimisers of the released walls that a step may go through, the fewest first.

        A method with multipliers takes its first pressures from a penalty. Where contact is too stiff for what the
        coarser mesh has left between walls, softer stages lead to it.
        """
        terms, stages = self.simulation.problem_of("released").terms, self._released.minimisers
        has_multipliers = any(isinstance(term, ContactTerm) and term.has_multipliers for term in terms)
        few = stages[-2 if has_multipliers else -1 :]
        return [few, stages[1:]] if len(few) < len(stages) - 1 else [few]

    def stable(self, found: Refined[Scene]) -> Refined[Scene]:
        """Return a step with its lowest curvature, below a saddle if it rests on one; errors of that are not known."""
        minimum, path = found.accepted.minimum, self._released.path
        is_tied, load = found.accepted.phase == "tied", found.accepted.load_factor
        minimiser = self._tied_at(minimum.state.displacement, load) if is_tied else self._released.minimisers[-1]
        effort = spent((minimiser,))
        length, options = self._released.longest_step, self.simulation.options.solver
        self.simulation.renew_budget()
        try:
            left = stable(minimiser, minimum, scale=path.scale, length=length, options=options)
        except OutOfIterations:
            return replace(found, errors=Errors())
        if not left.is_found:
            return replace(found, errors=Errors())
        effort = found.accepted.effort + (spent((minimiser,)) - effort)
        errors = found.errors if left.state is minimum.state else Errors()
        return replace(found, accepted=replace(found.accepted, minimum=left, effort=effort), errors=errors)
