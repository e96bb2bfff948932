"""A scene, built: mesh, unknowns, energies, contact, and the continuation along its load path.

Here the rooms are wired, and it reads like the method section of a paper. A tissue of a case and own bodies from Python
differ in their discretisation only: the mesh, the laws, and what moves.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ngcell.build.discretisation import draw_up
from ngcell.clock import Clock
from ngcell.problem.assembly import Assembly
from ngcell.contact.pairing.facing import find_facing
from ngcell.contact.methods.protocol import ContactMethod
from ngcell.problem.tie import Tie, tie_walls
from ngcell.contact.surface.find import find_surface
from ngcell.mechanics.bulk import BulkEnergy
from ngcell.build.observation import Observer, Step
from ngcell.results.measure import Scene
from ngcell.results.overlap import deepest_overlap_of_bodies
from ngcell.scene import AnyCase, BodyScene
from ngcell.solve.minimise import Minimiser
from ngcell.solve.released import Released
from ngcell.solve.sddp import tied_then_released
from ngcell.solve.continuation import FIRST, Continuation
from ngcell.solve.single_step import single_step
from ngcell.solve.step import Accepted
from ngcell.build.checkpoint import Checkpoint

if TYPE_CHECKING:
    from ngcell.contact.cohesion.bonds import Bonds

#: Ratio of bulk to shear modulus up to which paths are followed with a law as it is. Beyond it Newton's method crawls
#: along the curved valley of constant volume: paths are followed with this ratio, which rises to the one that is meant.
PATH_BULK, BULK_STAGE_FACTOR = 1e4, 30.0
#: Walls that face each other nearer than this share of their thickness count as touching at rest.
_TOUCHING = 0.05
#: Strength at which continuation paths start where walls overlap at rest, in units of the path's scale. A stronger proximal term
#: would hold them deep in each other, where the nearest wall changes from point to point and the energy is not smooth.
_FIRST_OVERLAPPING = 1.0


class Simulation:
    """A scene, built, and ready to follow.

    Parameters
    ----------
    scene : Case, BodyCase or BodyScene
        What is simulated.
    clock : Clock, optional
        Where the seconds are added up.
    """

    def __init__(self, scene: AnyCase | BodyScene, clock: Clock | None = None) -> None:
        self._contact, self._cohesion = scene.contact, scene.cohesion
        self._step_count = scene.smallest_step_count
        self.levels = scene.level_factors
        self.clock = clock or Clock()
        with self.clock.phase("meshing"):
            self.discretisation = draw_up(scene)
            self.bodies, self.space = self.discretisation.bodies, self.discretisation.space
            self.walls = find_surface(self.bodies, self.space.scalar, self.space.rest)
        drawn = self.discretisation
        self.bulk = BulkEnergy(self.space, drawn.laws, drawn.loads, drawn.filling, drawn.fibre_direction)
        self.motion = self.discretisation.motion
        self.longest_step = self.bodies.thickness / 2
        self.scene = Scene(
            walls=self.walls,
            facing=find_facing(self.walls, _TOUCHING * self.bodies.thickness),
            motion=self.motion,
            moved=self.discretisation.moved,
            prescribed_displacement=self.discretisation.prescribed_displacement,
        )
        self._observer = Observer(
            self.scene,
            self.bodies,
            levels=self.levels,
            expected=() if isinstance(scene, BodyScene) else scene.expected,
            cell_pressure=self.discretisation.cell_pressure,
        )

    @cached_property
    def _bulks(self) -> tuple[BulkEnergy, ...]:
        """The stored energy, from the bulk modulus that paths are followed with to the one that is meant."""
        drawn = self.discretisation
        laws = (*drawn.laws, *filter(None, (drawn.filling,)))
        bound, bulks = PATH_BULK, []
        while bound < max(law.bulk_modulus / law.shear_modulus for law in laws):
            softened = [law.softened(bound) for law in drawn.laws]
            filling = drawn.filling and drawn.filling.softened(bound)
            bulks.append(BulkEnergy(self.space, softened, drawn.loads, filling, drawn.fibre_direction))
            bound *= BULK_STAGE_FACTOR
        return (*bulks, self.bulk)

    @property
    def tied(self) -> Assembly:
        """The tissue as one tied solid."""
        return self._tied_stages[-1]

    @cached_property
    def _tied_stages(self) -> tuple[Assembly, ...]:
        tie = tie_walls(self.walls, self.space.size)
        return tuple(self._assembly(bulk, tie=tie) for bulk in self._bulks)

    @property
    def released(self) -> Assembly:
        """The tissue with its walls in unilateral contact."""
        return self._stages[-1]

    @cached_property
    def _stages(self) -> tuple[Assembly, ...]:
        """The released tissue, from the contact and bulk modulus that paths are followed with to those that are meant."""
        moduli = np.array([law.plane_strain_modulus for law in self.bulk.laws])
        methods = self._contact.stages(self.walls, moduli, reach=self._reach)
        softer = [self._assembly(bulk, contact=methods[0]) for bulk in self._bulks[:-1]]
        return (*softer, *(self._assembly(self.bulk, contact=method) for method in methods))

    @property
    def _reach(self) -> float:
        """Distance up to which walls are paired [length]: bodies that are drawn into each other are found, too."""
        usual = 2 * self.longest_step
        if self.bodies.dimension == 3:
            return usual
        deepest = deepest_overlap_of_bodies(self.space, self.walls, self.space.rest)
        return max(usual, deepest + self.longest_step)

    @cached_property
    def _bonds(self) -> Bonds | None:
        """What holds walls together, if anything does."""
        if self._cohesion is None:
            return None
        from ngcell.contact.cohesion.bonds import bond_walls

        return bond_walls(self.walls, self._cohesion)

    def _assembly(
        self, bulk: BulkEnergy, *, contact: ContactMethod | None = None, tie: Tie | None = None
    ) -> Assembly:
        fluid, bonds = self.discretisation.fluid, self._bonds if tie is None else None
        return Assembly(self.space, bulk, self.motion.fixed, contact=contact, tie=tie, fluid=fluid, bonds=bonds)

    def accepted_steps(self, checkpoint: Checkpoint | None = None) -> Iterator[Step]:
        """Yield the accepted steps, or those that follow where an earlier continuation stood.

        Raises
        ------
        StepFailed
            If a step finds no equilibrium.
        """
        checkpoint = checkpoint or Checkpoint()
        started = perf_counter()
        for accepted in self._accepted(checkpoint):
            with self.clock.phase("measuring"):
                assembly = self.tied if accepted.phase == "tied" else self.released
                # Terms with a memory hand it over here, and take it up again from `checkpoint.memory` at the start.
                memory = self._memory(accepted)
                step = self._observer.step(accepted, assembly, checkpoint, memory, perf_counter() - started)
                checkpoint = step.checkpoint
            yield step
            started = perf_counter()

    def _accepted(self, checkpoint: Checkpoint) -> Iterator[Accepted]:
        steps, done, last = self._steps(), checkpoint.count, checkpoint.displacement
        if self.discretisation.tied_first:
            return tied_then_released(
                [self._minimiser(assembly, np.inf) for assembly in self._tied_stages],
                self._released(),
                self.motion,
                steps=steps,
                levels=self.levels,
                done=done,
                last_tied=last.get("tied"),
            )
        if self._bonds is not None:
            return self._with_history(self._bonds, steps, checkpoint)
        return single_step(self._released(), self.motion, steps=steps, done=done, last=last.get("contact"))

    def _with_history(self, bonds: Bonds, steps: list[float], checkpoint: Checkpoint) -> Iterator[Accepted]:
        """Yield the accepted steps of a continuation whose bonds remember, after those that are done."""
        from ngcell.solve.load_stepping import LoadStepping

        accepted_steps = LoadStepping(self._released(), self.motion)
        if not checkpoint.count:
            return accepted_steps.steps(steps)
        bonds.largest = checkpoint.memory["largest_opening"]
        return accepted_steps.steps(
            steps,
            done=int(checkpoint.memory["targets"]),
            load=checkpoint.work["contact"].load_factor,
            displacement=checkpoint.displacement["contact"],
            dissipation=float(checkpoint.memory["dissipation"]),
            increment=float(checkpoint.memory["increment"]),
        )

    def _memory(self, accepted: Accepted) -> dict[str, NDArray[np.float64]] | None:
        """Return what a continuation with bonds has to know to go on; None where nothing is remembered."""
        if self._bonds is None or self.discretisation.tied_first or accepted.account is None:
            return None
        account = accepted.account
        return {
            "largest_opening": self._bonds.largest,
            "dissipation": np.array(account.dissipation),
            "increment": np.array(account.increment),
            "targets": np.array(account.targets),
        }

    def _released(self) -> Released:
        minimisers = [self._minimiser(assembly, self.longest_step) for assembly in self._stages]
        apart = self._minimiser(self._assembly(self._bulks[0]), self.longest_step)
        history = None if self._bonds is None else self.released
        loads = self.discretisation.loads or self.discretisation.fluid
        softest, stiffest = self._moduli
        return Released(
            apart,
            tuple(minimisers),
            self.continuation,
            loads,
            history,
            is_alone=self.bodies.body_count == 1,
            is_mixed=stiffest > softest,
        )

    @property
    def continuation(self) -> Continuation:
        """The path on which equilibria of released walls are selected."""
        softest, stiffest = self._moduli
        # Contact is as stiff as the softer body of a pair; what the proximal term has to outweigh at first is the stiffest.
        first = _FIRST_OVERLAPPING if self._overlaps_at_rest else FIRST * stiffest / softest
        return Continuation(softest / self.bodies.length**2, first=first)

    @property
    def _moduli(self) -> tuple[float, float]:
        """Shear modulus of the softest wall, and of the stiffest solid there is."""
        walls = [law.shear_modulus for law in self.bulk.laws]
        filling = [self.bulk.filling.shear_modulus] if self.bulk.filling else []
        return min(walls), max(walls + filling)

    @property
    def _overlaps_at_rest(self) -> bool:
        """Whether walls are drawn into each other, as for a press-fit."""
        gap = self.released.contact.pair(self.space.rest).kinematics.gaps(self.space.rest)
        return float(gap.min(initial=0.0)) < -_TOUCHING * self.bodies.thickness

    def _minimiser(self, assembly: Assembly, longest_step: float) -> Minimiser:
        volume = float(self.space.one @ self.space.scalar_mass @ self.space.one)
        return Minimiser(assembly, longest_step, energy_scale=self._moduli[1] * volume, clock=self.clock)

    def _steps(self) -> list[float]:
        """Return the load factors of all steps: the levels, with equal steps between them where more are asked for."""
        levels, count = self.levels, self._step_count
        length = float(np.abs(np.diff(levels, prepend=0.0)).sum())
        steps, before = [], 0.0
        for level in levels:
            pieces = max(1, round(count * abs(level - before) / length))
            steps += list(np.linspace(before, level, pieces + 1)[1:])
            before = level
        return [float(step) for step in steps]
