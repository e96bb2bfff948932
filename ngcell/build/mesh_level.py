"""One mesh of a scene, and how a step that was found on the mesh before goes on to it."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from math import inf
from typing import Generic, cast

from ngcell.build.attempt import Attempt, Minimisers, recall_stiffness
from ngcell.build.meshed import Refined, Scene, step_numbers
from ngcell.contact.methods.protocol import Adapting
from ngcell.contact.methods.terms import ContactTerm
from ngcell.mechanics.term import Array
from ngcell.mechanics.transfer import transferred
from ngcell.problem.problem import Problem
from ngcell.problem.state import State
from ngcell.results.error import Errors, Numbers
from ngcell.results.softness import beside_rigid_contact, loads_move_overlaps
from ngcell.solve.effort import OutOfIterations
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Minimum
from ngcell.solve.refined import has_contact, settled, stable
from ngcell.solve.released import Released
from ngcell.solve.rested import rested
from ngcell.solve.rigid_contact import toward_rigid_contact
from ngcell.solve.step import StepFailed, spent

#: Size of the digits that a place loses on a new mesh, in those that it loses on the way: the last minimisation on the
#: mesh before has kept them, and a third as many numbers lie so near to the middle of two that round-off decides.
_DIGITS = 3.0

_log = logging.getLogger(__name__)


class Level(Generic[Scene]):
    """The scene on one mesh, with the minimisers that take steps over from the mesh before."""

    def __init__(self, simulation: Scene) -> None:
        self.simulation = simulation
        self._used: list[Minimiser] = []

    @cached_property
    def _released(self) -> Released:
        released = self.simulation.released
        self._noted((released.apart, *released.minimisers))
        return released

    @cached_property
    def _tied(self) -> tuple[Minimiser, ...]:
        return self._noted(self.simulation.tied)

    @cached_property
    def _closing(self) -> tuple[Minimiser, ...]:
        return self._noted(self.simulation.closing)

    def _noted(self, minimisers: tuple[Minimiser, ...]) -> tuple[Minimiser, ...]:
        self._used += minimisers
        return minimisers

    def release(self) -> None:
        """Give the memory of all matrices back."""
        for minimiser in self._used:
            minimiser.release_matrix()

    def _tied_at(self, displacement: Array) -> Iterator[Attempt]:
        """Yield the minimiser of the tied solid, after those of smaller bulk moduli, and at last the one with contact:
        that alone where a body touches itself at a displacement."""
        if not has_contact(self._closing, displacement):
            yield Attempt(self._tied[:-1], self._tied[-1:])
        if self._closing:
            self._closing[-1].problem.reset()
            yield Attempt(self._closing[:-1], self._closing[-1:])

    def _passes_itself(self, minimisers: Minimisers, minimum: Minimum) -> bool:
        """Return whether a body touches itself in a minimum of the tied solid without contact."""
        is_open = minimum.is_found and minimisers[-1] is self._tied[-1]
        return is_open and has_contact(self._closing, minimum.state.displacement)

    @property
    def has_multipliers(self) -> bool:
        """Whether contact pressures are unknowns, to which a penalty leads."""
        return self.simulation.problem_of("released").has_multipliers

    def settled(
        self, coarse: Refined[Scene], *, only_leads: bool = False, is_finished_later: bool = False
    ) -> Refined[Scene] | None:
        """Return a step on this mesh that was found on the one before; None where it finds no equilibrium.

        Contact begins as stiff as it is meant; where bodies press each other so much that they pass through each other
        by it, it begins as stiff as it has become on the mesh before.

        If it `only_leads` to what is reported, released walls are in the contact of the stage before the last, and no
        last digits are looked for: multipliers take over from wherever the energy hardly falls. Few are where a
        released step `is_finished_later`, if it is reported, and all where nothing but the error of another is told by
        it.
        """
        mine, accepted = self.simulation, coarse.accepted
        load, is_tied = accepted.load_factor, accepted.phase == "tied"
        whole = coarse.problem.expand(accepted.minimum.state.displacement)
        start = mine.motion.imposed(transferred(whole, coarse.simulation.space, mine.space), load)
        path = self._released.path if accepted.minimum.proximal.weight else None
        share = mine.options.solver.handed_on if only_leads else None
        if path is not None and is_finished_later and not is_tied:
            share = inf if only_leads else path.options.of_leading
        for attempt in self._tied_at(start) if is_tied else self._attempts(only_leads):
            softer, last = attempt.softer, attempt.minimisers
            effort = spent((*softer, *last))
            own = mine.problem_of(accepted.phase, only_leads=only_leads)
            self._prepare(softer, last, coarse, start, own)
            if attempt.is_as_stiff:
                recall_stiffness(own, coarse.problem)
            begun = start if path is None else last[0].rounded(start, _DIGITS)
            try:
                length, options = self._released.longest_step, mine.options.solver
                minimum = settled(last, begun, softer=softer, length=length, options=options, path=path, share=share)
            except OutOfIterations:
                accepted = replace(accepted, effort=accepted.effort + (spent((*softer, *last)) - effort))
                break
            accepted = replace(accepted, effort=accepted.effort + (spent((*softer, *last)) - effort))
            if is_tied and self._passes_itself(last, minimum):
                continue
            if minimum.is_found:
                accepted = replace(accepted, minimum=minimum)
                problem = mine.problem_of(accepted.phase, only_leads=only_leads)
                step = replace(coarse, level=coarse.level + 1, simulation=mine, problem=problem, accepted=accepted)
                return replace(step, errors=Errors(), only_leads=only_leads, began=start)
            _log.info("mesh %d: %s", coarse.level + 1, minimum.ending.value)
        return self._anew(replace(coarse, accepted=accepted))

    def stiffer(self, found: Refined[Scene]) -> Refined[Scene]:
        """Return a step of this mesh by stiffer contact between bodies; as it is where that finds no equilibrium, or
        contact can be no stiffer."""
        minimiser, accepted, mine = self._released.minimisers[-1], found.accepted, self.simulation
        contact = (term.method for term in found.problem.terms if isinstance(term, ContactTerm))
        stiffened = [method for method in contact if isinstance(method, Adapting) and method.stiffen()]
        if not stiffened:
            return found
        path = self._released.path if accepted.minimum.proximal.weight else None
        share = None if path is None else path.options.of_leading
        length, options, effort = self._released.longest_step, mine.options.solver, spent((minimiser,))
        start = accepted.minimum.state.displacement
        mine.renew_budget()
        minimiser.forget_matrix()
        try:
            minimum = settled((minimiser,), start, length=length, options=options, path=path, share=share)
        except OutOfIterations:
            minimum = accepted.minimum
        is_stiffer = minimum is not accepted.minimum and minimum.is_found
        _log.info("contact made stiffer%s", "" if is_stiffer else " in vain")
        if not is_stiffer:
            minimum = accepted.minimum
            for method in stiffened:
                method.soften()
        accepted = replace(accepted, minimum=minimum, effort=accepted.effort + (spent((minimiser,)) - effort))
        return replace(found, accepted=accepted)

    def _anew(self, coarse: Refined[Scene]) -> Refined[Scene] | None:
        """Return a step that nothing was found beside, by the whole path on this mesh; None where there is none.

        A coarse mesh can hold walls in a state that no finer one has. The path depends on the load alone, where that
        has a lifting, and the step neither follows the one before nor has a history; it is dear, and followed on the
        second mesh only, which later ones go on from.
        """
        mine, before = self.simulation, coarse.accepted
        follows = before.follows or before.account is not None or not mine.motion.has_lifting
        if before.phase == "tied" or follows or coarse.level:
            return None
        _log.info("mesh %d: nothing was found beside the coarser mesh; the whole path is followed", coarse.level + 1)
        load = before.load_factor
        centre = mine.motion.lifting(load)
        mine.renew_budget(mine.options.solver.work_of_mesh)
        self._released.problem.reset()
        try:
            step = self._released.step(centre, centre, load)
        except (OutOfIterations, StepFailed):
            return None
        accepted = replace(step, effort=before.effort + step.effort)
        problem = mine.problem_of(before.phase)
        return Refined(coarse.level + 1, mine, problem, accepted, Errors(), coarse.is_judged)

    def finished(
        self, led: Refined[Scene], *, may_slide: bool = True, leads_below: float = -inf
    ) -> Refined[Scene] | None:
        """Return a step on this mesh at rest, by the contact that is meant; None where it finds no equilibrium.

        Or where walls slide away from where they have been led, if they may not. With an energy below `leads_below` it
        only leads to a finer mesh, and is not at rest.
        """
        if led.accepted.phase == "tied":
            return led
        minimiser, path = self._released.minimisers[-1], self._released.path
        effort, minimum = spent((minimiser,)), led.accepted.minimum
        self.simulation.renew_budget()
        try:
            if led.only_leads:
                minimum = self._by_meant_contact(led, may_slide, leads_below)
            elif minimum.proximal.weight:
                minimum = rested(minimiser, minimum, path.scale, path.options)
        except OutOfIterations:
            return None
        if not minimum.is_found:
            _log.info("mesh %d: %s", led.level, minimum.ending.value)
            return None
        effort = led.accepted.effort + (spent((minimiser,)) - effort)
        accepted = replace(led.accepted, minimum=minimum, effort=effort)
        return replace(led, problem=self.simulation.problem_of("released"), accepted=accepted, only_leads=False)

    def _by_meant_contact(self, led: Refined[Scene], may_slide: bool, leads_below: float) -> Minimum:
        """Return the minimum by the contact that is meant, beside one by a contact that only leads to it."""
        self._released.problem.apply(led.accepted.load_factor)
        led_to, before = led.accepted.minimum, led.problem
        return self._released.handed_over(led_to, before, may_slide=may_slide, leads_below=leads_below)

    def numbers(self, found: Refined[Scene]) -> Numbers:
        """Return the numbers of a step, with what a finite penalty takes of its energy where loads act."""
        numbers, minimum, problem = step_numbers(found), found.accepted.minimum, found.problem
        minimiser, path, state = self._released.minimisers[-1], self._released.path, cast(State, minimum.state)
        is_led = found.accepted.phase == "tied" or found.only_leads
        if is_led or minimiser.is_iterative or not loads_move_overlaps(problem, state):
            return numbers
        rigid = toward_rigid_contact(minimiser, minimum, path.scale * path.options.recentred)
        return beside_rigid_contact(numbers, problem, state, problem.at(rigid))

    def _prepare(
        self, softer: Minimisers, minimisers: Minimisers, coarse: Refined[Scene], start: Array, own: Problem
    ) -> None:
        """Let loads act, and terms take over what they may from stages before and from the coarser mesh."""
        accepted, released = coarse.accepted, self._released
        self.simulation.renew_budget(self.simulation.options.solver.work_of_mesh)
        for minimiser in (*softer, *minimisers):
            minimiser.forget_matrix()
            minimiser.problem.apply(accepted.load_factor)
        if accepted.phase != "tied":
            released.apply(accepted.load_factor)
            for before_it in released.minimisers[: -len(minimisers)][-1:]:  # none where contact has one stage
                minimisers[0].problem.start_from(before_it.problem, before_it.problem.at(start))
        own.refine(coarse.problem, cast(State, accepted.minimum.state))

    def _attempts(self, only_leads: bool) -> list[Attempt]:
        """Return minimisers of the released walls that a step may go through, the fewest first, after those of walls
        with smaller bulk moduli.

        A method with multipliers takes its first pressures from a penalty. Where contact is too stiff for what the
        coarser mesh has left between walls, softer stages lead to it.
        """
        left_out = 1 if only_leads else 0
        stages = self._released.minimisers[: len(self._released.minimisers) - left_out]
        few, most = 2 if self.has_multipliers and not only_leads else 1, len(stages) - len(self._tied)
        counts = [few, most] if few < most else [few]
        ways = [Attempt(self.simulation.softer_in_bulk(count + left_out), stages[-count:]) for count in counts]
        return [*ways, replace(ways[0], is_as_stiff=True)]

    def stable(self, found: Refined[Scene]) -> Refined[Scene]:
        """Return a step with its lowest curvature, below a saddle if it rests on one; errors are as before.

        None are known where its curvature is not. A tied solid that touches itself below a saddle is in contact there.
        """
        minimum, path = found.accepted.minimum, self._released.path
        is_tied = found.accepted.phase == "tied"
        length, options = self._released.longest_step, self.simulation.options.solver
        effort_in_all = found.accepted.effort
        attempts: Iterable[Attempt] = [Attempt((), self._released.minimisers)]
        if is_tied:
            attempts = self._tied_at(minimum.state.displacement)
        for number, attempt in enumerate(attempts):
            minimisers = attempt.minimisers
            effort, left = spent(minimisers[-1:]), minimum
            self.simulation.renew_budget()
            try:
                if number:
                    left = settled(minimisers[-1:], minimum.state.displacement, length=length, options=options)
                left = stable(minimisers[-1], left, length=length, options=options, path=path)
            except OutOfIterations:
                return replace(found, errors=Errors())
            effort_in_all = effort_in_all + (spent(minimisers[-1:]) - effort)
            if not (is_tied and self._passes_itself(minimisers, left)):
                break
        if not left.is_found:
            return replace(found, errors=Errors())
        return replace(found, accepted=replace(found.accepted, minimum=left, effort=effort_in_all))
