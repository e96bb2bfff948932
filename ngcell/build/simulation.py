"""A scene, built: its unknowns, the problems that they pose, and the steps along its load path.

It reads from top to bottom: mesh and terms, walls and who faces whom, contact and cohesion, the stages of the
continuation from soft to meant, and the strategy that follows the load path over them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from math import isfinite
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from ngcell.build.balance import check_balance
from ngcell.build.checkpoint import Checkpoint
from ngcell.build.discretisation import discretise
from ngcell.build.observation import Mesh, Observer, Step
from ngcell.build.options import Options
from ngcell.build.refinement import Refined, Refinement
from ngcell.build.stages import Stage, stages_of
from ngcell.clock import Clock
from ngcell.contact.cohesion.bonds import bond_walls
from ngcell.contact.methods.terms import CohesionTerm, ContactTerm
from ngcell.contact.pairing.facing import find_facing
from ngcell.contact.surface.find import find_surface
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.symbolic import fused
from ngcell.mechanics.term import Configuration, Term
from ngcell.mechanics.transfer import transferred
from ngcell.problem.problem import Problem
from ngcell.problem.reports import memory
from ngcell.problem.tie import tie_walls
from ngcell.results.measure import Setup
from ngcell.results.observables.observable import Observable
from ngcell.results.overlap import deepest_overlap_of_bodies
from ngcell.scene import AnyCase, BodyScene, Case
from ngcell.solve.continuation import Continuation
from ngcell.solve.effort import Budget
from ngcell.solve.minimise import Minimiser
from ngcell.solve.released import Released
from ngcell.solve.step import Accepted, within_budget
from ngcell.solve.strategies.load_stepping import LoadStepping
from ngcell.solve.strategies.single_step import SingleStep
from ngcell.solve.strategies.strategy import Strategy, Task

Array = NDArray[np.float64]
OwnTerm = Callable[[DisplacementSpace], Term]

#: Walls that face each other nearer than this share of their thickness count as touching at rest.
_TOUCHING = 0.05
#: Forces at rest, as shares of modulus and thickness, and overlaps, as shares of the thickness, that count as none:
#: round-off, and what curved elements of two meshes leave between them.
_NO_FORCE, _NO_OVERLAP = 1e-8, 1e-3


class Simulation:
    """A scene, built.

    Parameters
    ----------
    scene : Case, BodyCase or BodyScene
        What is simulated.
    clock : Clock, optional
        Where the seconds are added up.
    options : Options, optional
        The numbers of the solver and of contact.
    terms : sequence of callable
        Further terms of the energy, each made from the displacement space.
    observables : sequence of Observable
        What is measured besides what every run measures.
    strategy : Strategy, optional
        How the load path is followed, in place of what the scene says.
    stage : Stage, optional
        The mesh; by default that of the load path, from which steps go on to finer ones.

    Attributes
    ----------
    refinement : Refinement
        The meshes that steps are reported on.
    accuracy : float
        Relative error that is asked for.
    """

    def __init__(
        self,
        scene: AnyCase | BodyScene,
        clock: Clock | None = None,
        *,
        options: Options | None = None,
        terms: Sequence[OwnTerm] = (),
        observables: Sequence[Observable] = (),
        strategy: Strategy | None = None,
        stage: Stage | None = None,
    ) -> None:
        self.clock, self.options = clock or Clock(), options or Options()
        stages = stages_of(scene) if stage is None else (stage,)

        def build(finer: Stage) -> Simulation:
            return Simulation(
                scene, self.clock, options=self.options, terms=terms, observables=observables, stage=finer
            )

        self.refinement: Refinement[Simulation] = Refinement(self, stages, build, scene.accuracy)
        self.accuracy, scene = scene.accuracy, stages[0].scene
        self._case, self.levels, self._strategy = scene, scene.level_factors, strategy
        self._budget = Budget(self.options.solver.most_iterations)
        with self.clock.phase("meshing"):
            self.discretisation = built = discretise(scene)
            self.bodies, self.space, self.motion = built.space.bodies, built.space, built.motion
            self.walls = find_surface(self.bodies, self.space.scalar, self.space.rest)
        self.longest_step = self.bodies.thickness / 2
        self.setup = Setup(
            walls=self.walls,
            facing=find_facing(self.walls, _TOUCHING * self.bodies.thickness, self._facing_reach),
            motion=self.motion,
            moved=built.moved,
            prescribed_displacement=built.prescribed_displacement,
            modulus=min(law.shear_modulus for law in built.walls),
        )
        self._terms = (*built.terms, *(own(self.space) for own in terms))
        check_balance(self.space, self._terms, self.motion.fixed)
        self._observer = Observer(
            self.setup,
            self.bodies,
            levels=self.levels,
            expected=() if isinstance(scene, BodyScene) else scene.expected,
            observables=(*scene.observables, *observables),
            mesh=Mesh(stages[0].order, stages[0].grading, self.space.unknowns),
        )

    @cached_property
    def cohesion(self) -> tuple[Term, ...]:
        """What holds walls together, if anything does."""
        if self._case.cohesion is None:
            return ()
        return (CohesionTerm(bond_walls(self.walls, self._case.cohesion, self.options.contact)),)

    @cached_property
    def _volume_stages(self) -> tuple[tuple[Term, ...], ...]:
        """The terms of bodies and loads, from the bulk modulus that paths are followed with to the one that is meant.
        """
        bound, stages = self.options.solver.direct_bulk, []
        while bound < max(term.incompressibility for term in self._terms):
            stages.append(fused([term.softened(bound) for term in self._terms]))
            bound *= self.options.solver.bulk_stage
        return (*stages, fused(self._terms))

    @cached_property
    def _contact_stages(self) -> tuple[Term, ...]:
        """Contact, from the softest, which follows paths, to the one that is meant."""
        moduli = np.array([law.plane_strain_modulus for law in self.discretisation.walls])
        stages = self._case.contact.stages(self.walls, moduli, reach=self._reach, options=self.options.contact)
        return tuple(stage if isinstance(stage, Term) else ContactTerm(stage) for stage in stages)

    @property
    def contact(self) -> Term:
        """Contact as it is meant."""
        return self._contact_stages[-1]

    @cached_property
    def _reach(self) -> float:
        """Distance up to which walls are paired [length]: bodies that overlap at rest are found, too."""
        usual = 2 * self.longest_step
        if self.bodies.dimension == 3:
            return usual
        deepest = deepest_overlap_of_bodies(self.space, self.walls, self.space.rest)
        return max(usual, deepest + self.longest_step)

    @property
    def _facing_reach(self) -> float:
        """Distance up to which walls face each other [length]: those of a tissue touch, others may be apart."""
        return 0.0 if isinstance(self._case, Case) else self._reach

    @cached_property
    def tied_problems(self) -> tuple[Problem, ...]:
        """The tissue as one tied solid, stage by stage."""
        tie = tie_walls(self.walls, self.space.size)
        return tuple(Problem(self.space, terms, self.motion.fixed, tie=tie) for terms in self._volume_stages)

    @cached_property
    def released_problems(self) -> tuple[Problem, ...]:
        """The tissue with its walls in unilateral contact, stage by stage."""
        *softer, meant = self._volume_stages
        stages = [(*terms, self._contact_stages[0]) for terms in softer]
        stages += [(*meant, contact) for contact in self._contact_stages]
        return tuple(Problem(self.space, (*terms, *self.cohesion), self.motion.fixed) for terms in stages)

    @property
    def problem(self) -> Problem:
        """The released problem that is meant."""
        return self.released_problems[-1]

    @property
    def tied(self) -> tuple[Minimiser, ...]:
        """Minimisers of the tied solid."""
        return tuple(self._minimiser(problem, np.inf) for problem in self.tied_problems)

    @property
    def released(self) -> Released:
        """Minimisers of the released walls, and the continuation that selects one of their equilibria."""
        apart = Problem(self.space, (*self._volume_stages[0], *self.cohesion), self.motion.fixed)
        softest, stiffest = self._moduli
        return Released(
            self._minimiser(apart, self.longest_step),
            tuple(self._minimiser(problem, self.longest_step) for problem in self.released_problems),
            self.continuation,
            is_alone=self.bodies.body_count == 1,
            is_mixed=stiffest > softest,
            stability=self.options.solver.stability,
        )

    @property
    def continuation(self) -> Continuation:
        """The path on which equilibria of released walls are selected."""
        (softest, stiffest), options = self._moduli, self.options.solver.continuation
        # Contact is as stiff as the softer body of a pair; what the proximal term has to outweigh at first is the
        # stiffest.
        first = options.first_overlapping if self._overlaps_at_rest else options.first * stiffest / softest
        last = options.last
        if isfinite(self.accuracy):
            last = max(last, self.options.solver.proximal_share * self.accuracy)
        return Continuation(softest / self.bodies.length**2, replace(options, first=first, last=last))

    @property
    def _moduli(self) -> tuple[float, float]:
        """Shear modulus of the softest wall, and of the stiffest solid there is."""
        return self.setup.modulus, max(law.shear_modulus for law in self.discretisation.solids)

    @property
    def _overlaps_at_rest(self) -> bool:
        """Whether walls overlap at rest, as for a press-fit."""
        at_rest = self.space.configuration(np.zeros(self.space.unknowns))
        return (self.contact.overlap(at_rest) or 0.0) > _TOUCHING * self.bodies.thickness

    def _minimiser(self, problem: Problem, longest_step: float) -> Minimiser:
        volume = float(self.space.one @ self.space.scalar_mass @ self.space.one)
        scale, options = self._moduli[1] * volume, self.options.solver.minimiser
        return Minimiser(problem, longest_step, scale, options=options, clock=self.clock, budget=self._budget)

    @property
    def strategy(self) -> Strategy:
        """How the load path is followed: as the scene says, else as its terms allow."""
        given: Strategy | None = self._strategy or self._case.strategy
        return given or (LoadStepping() if self.cohesion else SingleStep())

    def accepted_steps(self, checkpoint: Checkpoint | None = None) -> Iterator[Step]:
        """Yield the accepted steps, or those that follow a checkpoint.

        Raises
        ------
        StepFailed
            If a step finds no equilibrium.
        """
        checkpoint, started = checkpoint or self.start, perf_counter()
        for accepted in self.follow(checkpoint):
            refined = self.refinement.refine(accepted, checkpoint.levels.get(accepted.phase, 0))
            with self.clock.phase("measuring"):
                tied = self._released_from(refined, checkpoint)
                step = refined.simulation.observed(refined, checkpoint, perf_counter() - started, tied)
                after = step.checkpoint
                followed = {**checkpoint.displacement, accepted.phase: accepted.minimum.state.displacement}
                checkpoint = replace(after, displacement=followed, memory=self._memory(accepted))
                step = replace(step, checkpoint=checkpoint)
            yield step
            started = perf_counter()

    def observed(
        self, refined: Refined[Simulation], checkpoint: Checkpoint, seconds: float, tied: Configuration | None = None
    ) -> Step:
        """Return what is reported of a step on this mesh that follows a checkpoint, and a tied state at its load."""
        accepted, level = refined.accepted, refined.level
        return self._observer.step(
            accepted,
            self.problem_of(accepted.phase),
            checkpoint.on_level(accepted.phase, level),
            seconds,
            tied=tied,
            errors=refined.errors,
            accuracy=self.accuracy if refined.is_judged else None,
        )

    def problem_of(self, phase: str) -> Problem:
        """Return the problem that steps of a phase solve."""
        return self.tied_problems[-1] if phase == "tied" else self.problem

    def renew_budget(self) -> None:
        """Give the minimisers of this mesh all of their iterations."""
        self._budget.renew()

    def _released_from(self, refined: Refined[Simulation], checkpoint: Checkpoint) -> Configuration | None:
        """Return the tied state at the load of a released step on its mesh, if that was the step before."""
        tied, load, space = checkpoint.reported.get("tied"), refined.accepted.load_factor, refined.simulation.space
        if refined.accepted.phase == "tied" or tied is None or checkpoint.work["tied"].load_factor != load:
            return None
        coarse = self.refinement.level(checkpoint.levels["tied"]).space
        return space.configuration(transferred(tied, coarse, space))

    @property
    def start(self) -> Checkpoint:
        """Where a run starts: at rest, as far as that is an equilibrium."""
        return self._observer.start() if self.starts_at_rest else Checkpoint()

    @property
    def mean_gap_at_rest(self) -> float | None:
        """Mean gap of the facing walls before the load [length]; None where bodies at rest are in no equilibrium."""
        length = np.bincount(self.setup.facing.pair, self.setup.facing.weight)
        gaps = self._observer.gaps_at_rest
        return float(gaps @ length / max(length.sum(), np.finfo(float).tiny)) if self.starts_at_rest else None

    @cached_property
    def starts_at_rest(self) -> bool:
        """Whether bodies at rest are in equilibrium before the load: nothing acts in full then, and none overlap."""
        apart = Problem(self.space, self._volume_stages[-1], self.motion.fixed)
        apart.apply(0.0)
        rest = apart.at(self.motion.imposed(np.zeros(self.space.unknowns), 0.0))
        force = float(np.abs(apart.gradient(rest)[apart.free]).max(initial=0.0))
        nothing = _NO_FORCE * self._moduli[0] * self.bodies.thickness ** (self.bodies.dimension - 1)
        overlap = self.contact.overlap(rest.at) or 0.0
        return force <= nothing and overlap <= _NO_OVERLAP * self.bodies.thickness

    def follow(self, checkpoint: Checkpoint) -> Iterator[Accepted]:
        """Yield the steps that the strategy accepts after a checkpoint, before they are measured."""
        task = Task(self, self.motion, self._steps(), self.levels, self.options.solver)
        for term in self.cohesion if checkpoint.memory else ():
            term.recall(checkpoint.memory)
        progress = checkpoint.progress
        return within_budget(self.strategy.follow(task, progress), self._budget, progress.load_factor)

    def _memory(self, accepted: Accepted) -> dict[str, NDArray[np.generic]]:
        """Return what terms remember, and where energy went; nothing where there is no history."""
        if accepted.account is None or not self.problem.has_history:
            return {}
        account = accepted.account
        names = ("dissipation", "increment", "targets")
        return {**memory(self.problem.terms), **{name: np.array(getattr(account, name)) for name in names}}

    def _steps(self) -> list[float]:
        """Return the load factors of all steps: the levels, with equal steps between them where more are asked for."""
        levels, count = self.levels, self.strategy.steps or self._case.smallest_step_count
        length = float(np.abs(np.diff(levels, prepend=0.0)).sum())
        steps, before = [], 0.0
        for level in levels:
            pieces = max(1, round(count * abs(level - before) / length)) if level != before else 1
            steps += list(np.linspace(before, level, pieces + 1)[1:])
            before = level
        return [float(step) for step in steps]
