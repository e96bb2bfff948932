"""What is reported of an accepted step: numbers, rows of the tables, fields, and what the case expects beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ngcell.build.checkpoint import Checkpoint
from ngcell.build.reported import Mesh, Step
from ngcell.geometry.bodies import BodyMesh
from ngcell.mechanics.report import Check
from ngcell.mechanics.term import Configuration
from ngcell.problem.problem import Problem
from ngcell.problem.reports import cell_fields
from ngcell.problem.state import State
from ngcell.results.cells import cell_records
from ngcell.results.checks import Path
from ngcell.results.equilibrium import Setup, mean_and_largest
from ngcell.results.error import ERROR_NAMES, NO_ERRORS, Errors
from ngcell.results.fields import take_fields
from ngcell.results.finding import compare
from ngcell.results.measure import Measurement, WorkPoint, measure
from ngcell.results.observables.observable import Observable, observed
from ngcell.results.onset import PairOnsets
from ngcell.results.quantities import View
from ngcell.results.record import StepRecord
from ngcell.results.rupture.cells import CellEnds, at_rest, followed, parting
from ngcell.results.snapshot import Snapshot
from ngcell.results.surface import pressed_lengths, wall_fields
from ngcell.results.walls import (
    CellComponents,
    find_components,
    opened_share,
    pair_gaps,
    parted_pairs,
    wall_records,
)
from ngcell.scene.expected import BodyExpected, Expected
from ngcell.solve.step import Accepted

Array = NDArray[np.float64]

#: Gaps at rest below this share of the thickness are round-off.
_ROUND_OFF = 1e-10


class Observer:
    """Looks at accepted steps of one scene.

    Parameters
    ----------
    setup : Setup
        Walls, facing pairs, and what moves.
    bodies : BodyMesh
        The mesh.
    levels : sequence of float
        Load factors that fields and walls are reported at.
    expected : sequence of Expected or BodyExpected
        What the case expects.
    observables : sequence of Observable
        What is measured besides.
    mesh : Mesh
        What `bodies` are resolved by.
    """

    def __init__(
        self,
        setup: Setup,
        bodies: BodyMesh,
        *,
        levels: Sequence[float],
        expected: Sequence[Expected | BodyExpected] = (),
        observables: Sequence[Observable] = (),
        mesh: Mesh,
    ) -> None:
        self._setup, self._bodies, self._mesh = setup, bodies, mesh
        self._levels, self._expected, self._observables = levels, expected, observables

    @cached_property
    def gaps_at_rest(self) -> Array:
        """Mean gap of each facing pair at rest [length]; round-off counts as closed."""
        gap = pair_gaps(self._setup.facing, self._setup.facing.gaps(self._setup.walls, self._setup.walls.rest))
        return np.where(np.abs(gap) < _ROUND_OFF * self._setup.facing.thickness, 0.0, gap)

    @property
    def mean_gap_at_rest(self) -> float:
        """Mean gap of the facing walls at rest [length]."""
        length = np.bincount(self._setup.facing.pair, self._setup.facing.weight)
        return float(self.gaps_at_rest @ length / max(length.sum(), np.finfo(float).tiny))

    def start(self) -> Checkpoint:
        """Return where a run starts whose bodies are in equilibrium at rest: no energy, and the gaps of the mesh."""
        onsets = PairOnsets.starting(0.0, self.gaps_at_rest, self._setup.facing.thickness)
        ends = None if self._setup.strength is None else at_rest(self._bodies.body_count)
        return Checkpoint(work={"tied": WorkPoint(), "released": WorkPoint()}, onsets=onsets, ends=ends)

    def step(
        self,
        accepted: Accepted,
        problem: Problem,
        checkpoint: Checkpoint,
        seconds: float,
        *,
        tied: Configuration | None = None,
        errors: Errors = NO_ERRORS,
        accuracy: float | None = None,
    ) -> Step:
        """Return what is reported of a step that follows a checkpoint.

        Parameters
        ----------
        accepted : Accepted
            The step.
        problem : Problem
            The problem that it solves.
        checkpoint : Checkpoint
            The one before it.
        seconds : float
            What it took, on the clock.
        tied : Configuration, optional
            The tied state at the same load that walls were released from.
        errors : Errors
            Estimated errors.
        accuracy : float, optional
            What they are held to; None where none were to be estimated.
        """
        curvature, asked = accepted.minimum.lowest_curvature, self._setup.accuracy
        path = Path(accepted.follows, tied, accepted.account, curvature, asked)
        judged = () if accuracy is None else (errors.check(accuracy),)
        measured = self._measure(accepted, problem, checkpoint, path, judged)
        after = checkpoint.after(accepted.phase, _state(accepted).at.displacement, measured.work)
        view = View(problem, _state(accepted), self._setup.walls, self._setup.motion, measured.reaction)
        columns, fields = observed(self._observables, view)
        bears, ends = self._rupture(view, measured, checkpoint, accepted, errors)
        after = replace(after, ends=ends)
        components = self._components(problem, measured)
        record = self._record(checkpoint.count, accepted, measured, components, seconds)
        record = _with_errors(replace(record, more={**record.more, **columns, **bears}), errors)
        step = Step(record, [], [], measured, view.state.at.displacement, None, [], after, accepted.effort, self._mesh)
        level = None if accepted.phase == "tied" else self._level(accepted.load_factor, checkpoint.reached)
        if level is None:
            return step
        step = replace(step, checkpoint=replace(after, reached=level + 1))
        return self._with_fields(step, level, view, components, fields)

    def _level(self, load: float, reached: int) -> int | None:
        """Return the number of the level at a load factor, the next one of those that have not been reached; None where
        it is none of them."""
        ahead = range(reached, len(self._levels))
        return next((number for number in ahead if np.isclose(load, self._levels[number])), None)

    def _with_fields(self, step: Step, level: int, view: View, components: CellComponents, fields: Any) -> Step:
        """Return a step at a level, with fields, rows of walls and cells, and expected numbers."""
        record, measured, facing = step.record, step.measurement, self._setup.facing
        at = view.state.at
        before, gaps = step.checkpoint.onsets, pair_gaps(facing, measured.gap)
        follow = PairOnsets.starting if before is None else before.after
        onsets = follow(record.place_on_path, gaps, facing.thickness)
        gap, pressure = wall_fields(self._setup.walls, facing, view.problem, at)
        pressed = pressed_lengths(self._setup.walls, facing.pairs, view.problem, at)
        held = self._of_all_bodies(cell_fields(view.problem.terms, at, record.load_factor))
        free = np.isin(np.arange(self._bodies.body_count), measured.free_bodies).astype(np.int64)
        is_rigid = np.arange(self._bodies.body_count) >= self._bodies.cell_count
        rigid = {"rigid": is_rigid.astype(np.int64)} if is_rigid.any() else {}
        bulk, walls = take_fields(
            view.problem,
            at,
            walls=self._setup.walls,
            wall_data={"gap": gap, "contact_pressure": pressure},
            body_data={"free": free, **rigid, **held, **fields},
        )
        snapshot = Snapshot(record.step, record.load_factor, record.plate_displacement, bulk, walls)
        pressures, ends = held.get("cell_pressure"), step.checkpoint.ends
        cells = cell_records(components, measured, record.step, record.plate_displacement, pressures, ends)
        return replace(
            step,
            walls=wall_records(facing, measured, record.step, onsets.onset, pressed),
            cells=cells,
            snapshot=snapshot,
            findings=list(compare(self._expected, record, view, self._levels[level:])),
            checkpoint=replace(step.checkpoint, onsets=onsets),
        )

    def _rupture(
        self, view: View, measured: Measurement, checkpoint: Checkpoint, accepted: Accepted, errors: Errors
    ) -> tuple[dict[str, float], CellEnds | None]:
        """Return the columns of the walls' utilisation, and how cells have ended; nothing where no strength is said."""
        strength, before = self._setup.strength, checkpoint.ends
        if strength is None:
            return {}, None
        found = strength.utilisation(view.problem.terms, view.state.at.displacement)
        columns = found.columns(errors.utilisation)
        if accepted.phase == "tied":
            return columns, before
        parted = parting(self._setup.facing, measured.gap, view.problem, view.state.at)
        return columns, followed(before, accepted.load_factor, found.of_body, parted, view.problem, view.state.at)

    def _measure(
        self, accepted: Accepted, problem: Problem, checkpoint: Checkpoint, path: Path, judged: Sequence[Check]
    ) -> Measurement:
        state, proximal = _state(accepted), accepted.minimum.proximal
        return measure(
            self._setup,
            problem,
            state,
            load_factor=accepted.load_factor,
            proximal_force=-proximal.gradient(state.displacement, problem.metric),
            before=checkpoint.work.get(accepted.phase),
            path=path,
            judged=judged,
        )

    def _components(self, problem: Problem, measured: Measurement) -> CellComponents:
        """Return the components of a step; the tied solid is one."""
        facing, count = self._setup.facing, self._bodies.cell_count
        if not problem.unknowns.lets_bodies_part:
            return CellComponents(np.zeros(count, dtype=np.int64), np.array([count]))
        return find_components(facing, parted_pairs(facing, measured.gap), count)

    def _of_all_bodies(self, fields: dict[str, Array]) -> dict[str, Array]:
        """Return fields of cells as fields of all bodies: rigid ones, which come last, have 0."""
        cells, rigid = self._bodies.cell_count, self._bodies.rigid_count
        return {name: np.concatenate([values[:cells], np.zeros(rigid)]) for name, values in fields.items()}

    def _record(
        self, number: int, accepted: Accepted, measured: Measurement, components: CellComponents, seconds: float
    ) -> StepRecord:
        facing, gap = self._setup.facing, measured.gap
        further = dict(measured.columns)
        x, y, *z = measured.plate_force
        held = facing.between_held(measured.free_bodies)
        mean, largest = mean_and_largest(facing, gap, held)
        free_mean, free_largest = mean_and_largest(facing, gap, ~held)
        return StepRecord(
            step=number,
            phase="tied" if accepted.phase == "tied" else "released",
            load_factor=accepted.load_factor,
            plate_displacement=accepted.load_factor * float(np.linalg.norm(self._setup.prescribed_displacement)),
            largest_gap=largest,
            mean_gap=mean,
            smallest_gap=float(gap.min()) if gap.size else 0.0,
            parted_pairs=int(parted_pairs(facing, gap).sum()),
            opened_share=opened_share(facing, gap),
            components=len(components.sizes),
            largest_component=int(components.sizes.max()),
            plate_force_x=float(x),
            plate_force_y=float(y),
            contact_force=measured.forces.total,
            energy=measured.energy,
            iterations=accepted.effort.iterations,
            factorisations=accepted.effort.factorisations,
            seconds=seconds,
            certified=measured.certificate.passed,
            separation_energy=further.pop("separation_energy", 0.0),
            bonded_share=further.pop("bonded_share", 0.0),
            dissipation=measured.dissipation,
            plate_force_z=float(z[0]) if z else 0.0,
            free_largest_gap=free_largest,
            free_mean_gap=free_mean,
            more=further,
        )


def _with_errors(record: StepRecord, errors: Errors) -> StepRecord:
    """Return a row with its estimated errors."""
    columns: dict[str, Any] = {f"{name}_error": getattr(errors, name) for name in ERROR_NAMES}
    return replace(record, mean_gap_slid=errors.slid * abs(record.mean_gap), **columns)


def _state(accepted: Accepted) -> State:
    """Return the state of a step; the solver knows it by protocol only."""
    return cast(State, accepted.minimum.state)
