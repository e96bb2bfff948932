"""The problems that a scene poses on one mesh, and the minimisers of them.

It reads from top to bottom: mesh and terms, walls and who faces whom, contact and cohesion, the stages of the
continuation from soft to meant, and what minimises each.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from ngcell.build.balance import check_balance
from ngcell.build.discretisation import discretise
from ngcell.build.drift import check_nothing_drifts
from ngcell.build.options import Options
from ngcell.build.scales import scales_in_reach
from ngcell.build.spaces import contact_around_spaces
from ngcell.clock import Clock
from ngcell.contact.cohesion.bonds import bond_walls
from ngcell.contact.methods.by_penalty import Penalty
from ngcell.contact.methods.self_contact import SelfContact, self_contact_stages
from ngcell.contact.methods.terms import CohesionTerm, ContactTerm
from ngcell.contact.pairing.facing import find_facing
from ngcell.contact.pairing.near import Reach
from ngcell.contact.surface.find import find_lumen_surface, find_surface
from ngcell.contact.surface.lumens import LumenSurface
from ngcell.errors import CaseError
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.symbolic_sum import fused
from ngcell.mechanics.term import Term
from ngcell.problem.problem import Problem
from ngcell.problem.tie import Tie, tie_walls
from ngcell.results.equilibrium import Setup
from ngcell.results.overlap import deepest_overlap_of_bodies
from ngcell.results.rupture.strength import wall_strength
from ngcell.scene import AnyCase, BodyScene, Case
from ngcell.solve.continuation import Continuation
from ngcell.solve.effort import Budget, share_of_work
from ngcell.solve.minimise import Minimiser
from ngcell.solve.released import Released

Array = NDArray[np.float64]
OwnTerm = Callable[[DisplacementSpace], Term]

#: Walls that face each other nearer than this share of their thickness count as touching at rest.
_TOUCHING = 0.05


class Problems:
    """A scene on one mesh.

    Parameters
    ----------
    scene : Case, BodyCase or BodyScene
        What is simulated, with the mesh that is meant.
    clock : Clock
        Where the seconds are added up.
    options : Options
        The numbers of the solver and of contact.
    terms : sequence of callable
        Further terms of the energy, each made from the displacement space.

    Attributes
    ----------
    accuracy : float
        Relative error that is asked for.
    """

    def __init__(
        self, scene: AnyCase | BodyScene, clock: Clock, options: Options, terms: Sequence[OwnTerm] = ()
    ) -> None:
        self.clock, self.options, self.accuracy = clock, options, scene.accuracy
        self._case, self.levels = scene, scene.level_factors
        with clock.phase("meshing"):
            self.discretisation = built = discretise(scene)
            self.bodies, self.space, self.motion = built.space.bodies, built.space, built.motion
            self.walls = find_surface(self.bodies, self.space.scalar, self.space.rest)
        # Beyond `direct_bulk` stages lead to the ratio that is meant.
        bulk = min(max(law.bulk_modulus / law.shear_modulus for law in built.solids), options.solver.direct_bulk)
        self._budget = Budget(round(share_of_work(bulk) * options.solver.work_of(self.bodies.body_count)))
        self._scales = scales_in_reach(self.space, self.motion, built.walls, built.solids)
        self.longest_step = self._scales.thickness / 2
        self.setup = Setup(
            walls=self.walls,
            facing=find_facing(self.walls, _TOUCHING * self.bodies.thickness_of_body, self._facing_reach),
            motion=self.motion,
            moved=built.moved,
            prescribed_displacement=built.prescribed_displacement,
            modulus=min(law.shear_modulus for law in built.walls),
            # What ends earlier is told as an error; bonds, whose errors are not estimated, are followed to the end.
            accuracy=self.accuracy if scene.cohesion is None else inf,
            strength=wall_strength(self.space, built.walls),
        )
        self._terms = (*built.terms, *(own(self.space) for own in terms))
        check_balance(self.space, self._terms, self.motion.fixed)
        if scene.cohesion is None and not terms:
            check_nothing_drifts(self.space, self._terms, self.motion)

    @cached_property
    def shear_moduli(self) -> Array:
        """Shear modulus of each element [stress], shape (elements,)."""
        built, filling = self.discretisation, self.bodies.is_filling
        of_walls = np.array([law.shear_modulus for law in built.walls])[self.bodies.body_of_element]
        return of_walls if filling is None else np.where(filling, built.solids[-1].shear_modulus, of_walls)

    @cached_property
    def cohesion(self) -> tuple[Term, ...]:
        """What holds walls together, if anything does."""
        if self._case.cohesion is None:
            return ()
        return (CohesionTerm(bond_walls(self.walls, self._case.cohesion, self.options.contact)),)

    @cached_property
    def _volume_stages(self) -> tuple[tuple[Term, ...], ...]:
        """The terms of bodies and loads, from the bulk modulus that paths are followed with to the one meant."""
        return (*self._softened_from(self.options.solver.direct_bulk), fused(self._terms))

    def _softened_from(self, bound: float) -> list[tuple[Term, ...]]:
        """Return these terms with ratios of bulk to shear modulus from `bound` to less than the one that is meant."""
        stages = []
        while bound < max(term.incompressibility for term in self._terms):
            stages.append(fused([term.softened(bound) for term in self._terms]))
            bound *= self.options.solver.bulk_stage
        return stages

    @property
    def _moduli(self) -> Array:
        """Plane-strain modulus of each body [stress]."""
        return np.array([law.plane_strain_modulus for law in self.discretisation.walls])

    @property
    def _penalty(self) -> Penalty:
        """The penalty of what a case's own method does not act in, as stiff as that; methods without one have none."""
        return Penalty(stiffness=getattr(self._case.contact, "stiffness", 1.0))

    @cached_property
    def _contact_stages(self) -> tuple[Term, ...]:
        """Contact, from the softest, which follows paths, to the one that is meant."""
        contact = self._case.contact if self.walls.facet_count else Penalty()  # without walls all methods do nothing
        stages = contact.stages(self.walls, self._moduli, reach=self._reach, options=self.options.contact)
        terms = tuple(stage if isinstance(stage, Term) else ContactTerm(stage) for stage in stages)
        if len(terms) == 1 and getattr(terms[-1], "has_multipliers", False):
            raise CaseError("contact: its one stage has multipliers; allowed: stages without them that lead to it")
        return terms

    @cached_property
    def _lumens(self) -> LumenSurface | None:
        """The lumens that may close: those that are empty, unless fluids keep them open."""
        if any(term.keeps_lumens_open for term in self._terms):
            return None
        return find_lumen_surface(self.bodies, self.space.scalar, self.space.rest)

    def _self_contact(self, count: int) -> list[SelfContact]:
        """Return contact of lumens with themselves in so many stages; none where no lumen may close."""
        if self._lumens is None:
            return []
        options, stiffness = self.options.contact, self._penalty.stiffness
        return self_contact_stages(self._lumens, self._moduli, count, options, stiffness=stiffness)

    @property
    def contact(self) -> Term:
        """Contact as it is meant."""
        return self._contact_stages[-1]

    @cached_property
    def _reach(self) -> Array:
        """Distance up to which walls of each body are paired [length]: bodies that overlap at rest are found, too."""
        thickness = self.bodies.thickness_of_body
        # The thickest one is never the thinner of two.
        usual = np.minimum(thickness, np.sort(thickness)[-2:][0])
        if self.bodies.dimension == 3:
            return np.asarray(usual)
        deepest = deepest_overlap_of_bodies(self.space, self.walls, self.space.rest)
        return np.asarray(np.maximum(usual, deepest + self.longest_step))

    @property
    def _facing_reach(self) -> Reach:
        """Distance up to which walls face each other [length]: those of a tissue touch, others may be apart."""
        return 0.0 if isinstance(self._case, Case) else self._reach

    @cached_property
    def _tie(self) -> Tie:
        return tie_walls(self.walls, self.space.size)

    def _tied_problems(self, contact: Sequence[Term]) -> tuple[Problem, ...]:
        return tuple(self._problem((*terms, *contact), self._tie) for terms in self._volume_stages)

    def _problem(self, terms: Sequence[Term], tie: Tie | None = None) -> Problem:
        return Problem(self.space, terms, self.motion.fixed, tie=tie, length=self._scales.length)

    @cached_property
    def tied_problems(self) -> tuple[Problem, ...]:
        """The tissue as one tied solid, stage by stage, without contact."""
        return self._tied_problems(())

    @cached_property
    def closing_problems(self) -> tuple[Problem, ...]:
        """The tied solid whose lumens touch themselves, and walls each other around spaces, stage by stage."""
        around = contact_around_spaces(self._penalty, self.walls, self._moduli, self._reach, self.options.contact)
        return self._tied_problems((*self._self_contact(1), *around))

    @cached_property
    def _contacts(self) -> tuple[tuple[Term, ...], ...]:
        """Contact between bodies and of lumens with themselves, stage by stage."""
        count = len(self._contact_stages)
        within: list[tuple[Term, ...]] = [(stage,) for stage in self._self_contact(count)] or [()] * count
        return tuple((stage, *mine) for stage, mine in zip(self._contact_stages, within, strict=True))

    def _released_problem(self, terms: Sequence[Term], contact: Sequence[Term]) -> Problem:
        return self._problem((*terms, *contact, *self.cohesion))

    @cached_property
    def released_problems(self) -> tuple[Problem, ...]:
        """The tissue with its walls in unilateral contact, stage by stage."""
        *softer, meant = self._volume_stages
        stages = [(terms, self._contacts[0]) for terms in softer] + [(meant, contact) for contact in self._contacts]
        return tuple(self._released_problem(*stage) for stage in stages)

    @property
    def problem(self) -> Problem:
        """The released problem that is meant."""
        return self.released_problems[-1]

    @property
    def tied(self) -> tuple[Minimiser, ...]:
        """Minimisers of the tied solid without contact."""
        return tuple(self._minimiser(problem, np.inf) for problem in self.tied_problems)

    @property
    def closing(self) -> tuple[Minimiser, ...]:
        """Minimisers of the tied solid whose lumens and free walls touch; none where none can."""
        is_any = len(self.closing_problems[-1].terms) > len(self.tied_problems[-1].terms)
        return tuple(self._minimiser(problem, self.longest_step) for problem in self.closing_problems if is_any)

    @property
    def released(self) -> Released:
        """Minimisers of the released walls, and the continuation that selects one of their equilibria."""
        apart = self._released_problem(self._volume_stages[0], ())
        return Released(
            self._minimiser(apart, self.longest_step),
            tuple(self._minimiser(problem, self.longest_step) for problem in self.released_problems),
            self.continuation,
            is_alone=self.bodies.body_count == 1,
            is_mixed=self._scales.stiffest > self._scales.softest,
            options=self.options.solver,
        )

    def softer_in_bulk(self, count: int) -> tuple[Minimiser, ...]:
        """Return minimisers of released walls of smaller bulk moduli, with which a state from a coarser mesh goes on.

        Their contact is the first of the last `count` stages. There are none where nothing that needs the mixed method,
        whose volume is free between the points of the coarser mesh, needs stages on the path, too.
        """
        options = self.options.solver
        is_needed = any(term.mixed_incompressibility > options.direct_bulk for term in self._terms)
        stages = self._softened_from(options.transferred_bulk) if is_needed else []
        problems = (self._released_problem(terms, self._contacts[-count]) for terms in stages)
        return tuple(self._minimiser(problem, self.longest_step) for problem in problems)

    @property
    def continuation(self) -> Continuation:
        """The path on which equilibria of released walls are selected."""
        scales, options = self._scales, self.options.solver.continuation
        # Contact is as stiff as the softer body of a pair; at first the proximal term has to outweigh the stiffest.
        contrast = scales.stiffest / scales.softest
        first = options.first_overlapping if self._overlaps_at_rest(_TOUCHING) else options.first * contrast
        if isfinite(self.setup.accuracy):
            options = options.within(self.setup.accuracy)
        return Continuation(scales.softest / scales.length**2, replace(options, first=first))

    def _overlaps_at_rest(self, share: float) -> bool:
        """Return whether walls overlap at rest by more than a share of the thickness, as for a press-fit."""
        at_rest = self.space.configuration(self.motion.imposed(np.zeros(self.space.unknowns), 0.0))
        return (self.contact.overlap(at_rest) or 0.0) > share * self.bodies.thickness

    def _minimiser(self, problem: Problem, longest_step: float) -> Minimiser:
        volume = float(self.space.one @ self.space.scalar_mass @ self.space.one)
        scale, options = self._scales.stiffest * volume, self.options.solver.minimiser
        if not isfinite(self.setup.accuracy):  # the path goes to the last digits
            options = replace(options, cheap=options.cheap_at_last)
        return Minimiser(problem, longest_step, scale, options=options, clock=self.clock, budget=self._budget)

    def problem_of(self, phase: str, *, only_leads: bool = False) -> Problem:
        """Return the problem that steps of a phase solve; of released walls also the stage that leads to the last."""
        if only_leads:
            return self.released_problems[-2]
        return self.closing_problems[-1] if phase == "tied" else self.problem

    def renew_budget(self, times: float = 1.0) -> None:
        """Give the minimisers of this mesh all of their work, so many times the usual."""
        self._budget.renew(times)
