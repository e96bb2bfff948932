"""From a step on the mesh of the load path to what is reported: finer meshes, one after the other, until the estimated
error is what the scene asks for.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from math import inf
from typing import Generic, cast

from ngcell.build.mesh_level import Level
from ngcell.build.meshed import Refined, Scene, step_numbers
from ngcell.build.stages import Stage, singular_exponent
from ngcell.errors import CaseError
from ngcell.problem.state import State
from ngcell.results.elsewhere import share_elsewhere
from ngcell.results.error import Errors, Numbers, errors_beside, estimate
from ngcell.results.parts_of_error import Refining
from ngcell.solve.step import Accepted

_log = logging.getLogger(__name__)

#: Refinements that most runs come to.
_USUAL = 2
#: Mesh on which multipliers take over from the penalty that leads to them where walls slip, whatever its error, and on
#: which penalty terms that leave too much overlap are made stiffer: what slides there takes a tenth of the time that it
#: takes on the finest one, and later meshes do not tell of an error what stiffness has changed.
_SETTLED_ON = 1
#: Share of the error on the mesh before above which it falls slowly; on sheared tissues an eighth to a third is left
#: where walls stay. They have come to other places then, and by multipliers would do so on the finest mesh.
_SLOW = 0.5
#: Share of what a mean gap may err by that penalty terms may leave as overlaps.
_OF_CONTACT = 0.25


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
    on_the_way : tuple of int, Numbers and Errors, optional
        The mesh that a step which is not finished has come to, and what it told; None where there is none.
    """

    def __init__(self, base: Scene, stages: Sequence[Stage], build: Callable[[Stage], Scene], accuracy: float) -> None:
        self._stages, self._build, self._accuracy = list(stages), build, accuracy
        self.estimates = len(self._stages) > 1
        self._levels = [Level(base)]
        self.on_the_way: tuple[int, Numbers, Errors] | None = None

    def table(self) -> tuple[dict[str, int], ...]:
        """Return order, grading, halvings and unknowns of the meshes that were used, the coarsest first."""
        return tuple(
            {**stage.entries, "unknowns": level.simulation.space.unknowns}
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

        It depends on the step alone, not on the meshes of steps before it, of which no matrix is kept.
        """
        try:
            slid = self._slid_share(accepted)
            found = self._refined_and_stable(accepted)
        finally:
            self._release()
        self.on_the_way = None  # it is accepted: what stops on the way to the next step tells nothing of it
        return replace(found, errors=replace(found.errors, slid=slid))

    def _slid_share(self, accepted: Accepted) -> float:
        """Return the share of itself by which the mean gap changed as walls were followed to rest on the first mesh."""
        base, firm = self._levels[0].simulation, accepted.minimum.slid_from
        if firm is None:
            return 0.0
        there = Refined(0, base, base.problem_of(accepted.phase), accepted, Errors(), is_judged=False)
        here, minimum = step_numbers(there), replace(accepted.minimum, state=there.problem.at(firm))
        before = step_numbers(replace(there, accepted=replace(accepted, minimum=minimum))).over_walls_of(here)
        return abs(before.mean_gap - here.mean_gap) / max(abs(here.mean_gap), here.scales[2])

    def taken_on(self, reported: Refined[Scene], stages: Sequence[Stage]) -> Refined[Scene] | None:
        """Return a step on the finest of some meshes that finds an equilibrium beside it; None where no finer one does.

        They begin with those that there are.
        """
        last, self._stages = reported, list(stages)
        try:
            while (finer := self._next(last)) is not None:
                last = finer
            return None if last is reported else self._levels[last.level].finished(last) or last
        finally:
            self._release()

    def _release(self) -> None:
        """Give the memory of all matrices back."""
        for level in self._levels:
            level.release()

    def _refined_and_stable(self, accepted: Accepted) -> Refined[Scene]:
        found = self._refined(accepted)
        if found.accepted.minimum is accepted.minimum:  # the load path has told the curvature of its own
            return found
        below = self._levels[found.level].stable(found)
        if below.accepted.minimum.state is found.accepted.minimum.state:
            return below
        return replace(below, errors=errors_beside(below.errors, step_numbers(found), step_numbers(below)))

    def _refined(self, accepted: Accepted, *, is_slipping: bool = False) -> Refined[Scene]:
        """Return a step on the mesh that it is reported on.

        Contact pressures that are unknowns are solved for where a step is reported; a penalty leads there. Where they
        find no equilibrium near its own, or the error hardly falls from mesh to mesh, walls are slipping: the pressures
        then come in on a coarser mesh.
        """
        is_released, base = accepted.phase != "tied", self._levels[0].simulation
        is_judged = self.estimates and is_released
        reported = last = Refined(0, base, base.problem_of(accepted.phase), accepted, Errors(), is_judged)
        if not self.estimates:
            return last
        is_first_reported = len(self._stages) > 1 and not self._stages[1].is_reported
        first = self._levels[0].numbers(last) if is_first_reported else step_numbers(last)
        found, refined, errors = [first], list[Refining](), Errors()
        while (finer := self._next(last)) is not None:
            finer, here = self._by_firm_contact(finer)
            found.append(here)
            refined.append(self._refining(last, finer))
            if not self._stages[finer.level].is_reported:
                errors = estimate(found, [how.unmeasured for how in refined], of_last=False)
                accepted = replace(reported.accepted, effort=finer.accepted.effort)
                return replace(reported, accepted=accepted, errors=errors)
            last, before = finer, errors.relative
            errors = estimate(found, refined, meant=found[-1].without_contact if last.only_leads else found[-1])
            _log.info("mesh %d: energy %.6e, estimated error %.1e", last.level, found[-1].energy, errors.relative)
            self.on_the_way = (last.level, found[-1], errors)
            is_fine, is_enough = last.level > _SETTLED_ON, not (is_judged and errors.relative > self._accuracy)
            may_slip = last.only_leads and is_fine and not is_slipping
            is_slow = last.level == _SETTLED_ON + 1 and errors.relative > _SLOW * before
            if may_slip and not is_enough and is_slow:
                return self._refined(replace(accepted, effort=last.accepted.effort), is_slipping=True)
            if not is_enough and not (is_slipping and last.level == _SETTLED_ON):
                continue
            slid = self._slid(found[-1], 1.0 if is_enough else 0.5) if is_released else -inf
            leads_below = slid if is_enough else inf
            finished = self._reported(last, found, refined, may_slide=not may_slip, leads_below=leads_below)
            if finished is None and may_slip:
                return self._refined(replace(accepted, effort=last.accepted.effort), is_slipping=True)
            if finished is None:
                continue
            here = self._levels[finished.level].numbers(finished)
            if here.potential < slid:  # no mesh has told anything of what is here, nor is it at rest where that leads
                found, refined = [here.without_contact if last.only_leads else here], []
                last = replace(finished, errors=Errors())
                continue
            if not last.only_leads:
                found[-1] = here
            if not is_enough:
                last = replace(last, accepted=replace(last.accepted, effort=finished.accepted.effort))
                continue
            if not is_judged or finished.errors.relative <= self._accuracy:
                return finished
            reported, spent = finished, replace(last.accepted, effort=finished.accepted.effort)
            last = replace(last, accepted=spent) if last.only_leads else finished
        if last.level == reported.level:
            return reported if last.level else self._levels[0].finished(reported) or reported
        return self._reported(last, found, refined) or reported

    def _by_firm_contact(self, finer: Refined[Scene]) -> tuple[Refined[Scene], Numbers]:
        """Return a step, by stiffer contact where walls overlap by too much beside their gaps, and its numbers.

        Penalty terms adapt to energies. Walls that hardly open may overlap by more than their gaps may err.
        """
        numbers = self._levels[finer.level].numbers(finer)
        if not finer.is_judged or finer.only_leads or finer.level != _SETTLED_ON:
            return finer, numbers
        while numbers.overlap > _OF_CONTACT * self._accuracy * max(abs(numbers.mean_gap), numbers.scales[2]):
            stiffer = self._levels[finer.level].stiffer(finer)
            if stiffer.accepted.minimum is finer.accepted.minimum:
                return stiffer, numbers
            finer, numbers = stiffer, self._levels[finer.level].numbers(stiffer)
        return finer, numbers

    def _reported(
        self,
        last: Refined[Scene],
        found: Sequence[Numbers],
        refined: Sequence[Refining],
        *,
        may_slide: bool = True,
        leads_below: float = -inf,
    ) -> Refined[Scene] | None:
        """Return a step at rest by the contact that is meant, with its errors; None where it finds no equilibrium.

        With a potential below `leads_below` it is not at rest. What the meshes have changed is told by minima that are
        as much at rest on each; what changes as walls come to rest by the same contact, counts besides.
        """
        finished = self._levels[last.level].finished(last, may_slide=may_slide, leads_below=leads_below)
        if finished is None:
            return None
        here = self._levels[last.level].numbers(finished)
        errors = estimate(found, refined, meant=here)
        if refined and not last.only_leads and finished is not last:
            errors = errors_beside(errors, found[-1], here)
        return replace(finished, errors=errors)

    def _slid(self, led: Numbers, times: float) -> float:
        """Return the potential below which walls have slid on as they came to rest, or as multipliers took over, at so
        many times the fall that the solver takes for a slide. Without slides the potential rises there, as overlaps
        go."""
        numbers = self._levels[0].simulation.options.solver.continuation
        share = times * numbers.slid * numbers.sufficient_of_accuracy * self._accuracy
        return led.potential - share * max(abs(led.energy), led.scales[0])

    def _refining(self, coarse: Refined[Scene], finer: Refined[Scene]) -> Refining:
        """Return how the mesh of a step is finer than the one before."""
        how = self._stages[finer.level].refining(self._stages[coarse.level], self._exponent)
        if not how.is_graded_alone or coarse.began is None or not finer.is_judged:
            return how
        mine, after = coarse.simulation, cast(State, coarse.accepted.minimum.state).displacement
        share = share_elsewhere(mine.space, mine.shear_moduli, coarse.began, after, finer.simulation.space)
        return replace(how, unsplit=share)

    @cached_property
    def _exponent(self) -> float:
        return singular_exponent(self._levels[0].simulation.space)

    def _level(self, number: int) -> Level[Scene] | None:
        """Return a mesh; None where there are no more, or where the machine has no room for it."""
        if number >= len(self._stages):
            return None
        if number == len(self._levels):
            try:
                self._levels.append(Level(self._build(self._stages[number])))
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
        is_reported, phase = self._stages[coarse.level + 1].is_reported, coarse.accepted.phase
        only_leads = is_reported and phase != "tied" and level.has_multipliers
        self._levels[coarse.level].release()
        return level.settled(coarse, only_leads=only_leads, is_finished_later=is_reported)
