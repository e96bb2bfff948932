"""The steps of a scene along its load path: a strategy follows it over the problems of one mesh, each step goes on to
finer ones, and is measured there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from functools import cached_property
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from ngcell.build.balance import NO_OVERLAP, is_balanced_at_rest
from ngcell.build.checkpoint import Checkpoint
from ngcell.build.meshed import Refined
from ngcell.build.observation import Observer
from ngcell.build.options import Options
from ngcell.build.problems import OwnTerm, Problems
from ngcell.build.refinement import Refinement
from ngcell.build.reported import Mesh, Step
from ngcell.build.stages import Stage, not_estimated, stages_of
from ngcell.clock import Clock
from ngcell.mechanics.term import Configuration
from ngcell.mechanics.transfer import transferred
from ngcell.problem.problem import Problem
from ngcell.results.fields import FIELDS
from ngcell.results.observables.observable import Observable, check_names
from ngcell.results.record import StepRecord
from ngcell.results.rupture.strength import COLUMNS
from ngcell.scene import AnyCase, BodyScene
from ngcell.solve.step import Accepted, within_budget
from ngcell.solve.strategies.load_stepping import LoadStepping
from ngcell.solve.strategies.single_step import SingleStep
from ngcell.solve.strategies.strategy import Strategy, Task, load_steps


class Simulation(Problems):
    """A scene, built, and its steps.

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
        stages = stages_of(scene) if stage is None else (stage,)
        options = options or Options()
        finer_options = options.for_accuracy(scene.accuracy)
        # A mesh that is reported has contact as stiff as the accuracy asks, also if a case gives it.
        leads = len(stages) > 1 and stages[-1].is_reported
        is_given = len(stages) > 1 and not leads or not scene.estimate_error
        mine = finer_options if is_given else options.for_path() if leads else options
        super().__init__(stages[0].scene, clock or Clock(), mine, terms)

        def build(finer: Stage) -> Simulation:
            return Simulation(
                scene, self.clock, options=finer_options, terms=terms, observables=observables, stage=finer
            )

        self.refinement: Refinement[Simulation] = Refinement(self, stages, build, scene.accuracy)
        self._strategy = strategy
        measured_too = (*self._case.observables, *observables)
        check_names(measured_too, {*(column.name for column in fields(StepRecord)), *FIELDS, *COLUMNS})
        self._observer = Observer(
            self.setup,
            self.bodies,
            levels=self.levels,
            expected=() if isinstance(self._case, BodyScene) else self._case.expected,
            observables=measured_too,
            mesh=Mesh(**stages[0].entries, unknowns=self.space.unknowns),
        )

    @property
    def not_estimated(self) -> str:
        """Why the errors of this scene are not estimated; empty where they are."""
        return not_estimated(self._case)

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
            refined = self.refinement.refine(accepted)
            with self.clock.phase("measuring"):
                tied = self._released_from(refined, checkpoint)
                step = refined.simulation.observed(refined, checkpoint, perf_counter() - started, tied)
                after = step.checkpoint
                followed = {**checkpoint.displacement, accepted.phase: accepted.minimum.state.displacement}
                checkpoint = replace(after, displacement=followed, memory=self._memory(accepted))
                step = replace(step, checkpoint=checkpoint, meshes=self.refinement.table())
            yield step
            started = perf_counter()

    def observed(
        self, refined: Refined[Simulation], checkpoint: Checkpoint, seconds: float, tied: Configuration | None = None
    ) -> Step:
        """Return what is reported of a step on this mesh that follows a checkpoint, and a tied state at its load."""
        accepted, level = refined.accepted, refined.level
        return self._observer.step(
            accepted,
            refined.problem,
            checkpoint.on_level(accepted.phase, level),
            seconds,
            tied=tied,
            errors=refined.errors,
            accuracy=self.accuracy if refined.is_judged else None,
        )

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
        return self._observer.mean_gap_at_rest if self.starts_at_rest else None

    @cached_property
    def starts_at_rest(self) -> bool:
        """Whether bodies at rest are in equilibrium before the load: nothing acts in full then, and none overlap."""
        apart = Problem(self.space, self._volume_stages[-1], self.motion.fixed)
        return is_balanced_at_rest(apart, self.motion, self.setup.modulus) and not self._overlaps_at_rest(NO_OVERLAP)

    def follow(self, checkpoint: Checkpoint) -> Iterator[Accepted]:
        """Yield the steps that the strategy accepts after a checkpoint, before they are measured."""
        steps = load_steps(self.levels, self.strategy.steps or self._case.smallest_step_count)
        task = Task(self, self.motion, steps, self.levels, self.options.solver)
        if checkpoint.memory:
            self.problem.recall(checkpoint.memory)
        progress = checkpoint.progress
        return within_budget(self.strategy.follow(task, progress), self._budget, progress.load_factor)

    def _memory(self, accepted: Accepted) -> dict[str, NDArray[np.generic]]:
        """Return what terms remember, where a load path stands, and where its energy went."""
        memory, account = self.problem.memory(), accepted.account
        if account is None:
            return memory
        names = ("dissipation", "increment", "targets")
        return memory | {name: np.array(getattr(account, name)) for name in names}
