"""What is reported of an accepted step: numbers, rows of the tables, fields, and what the case expects beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ngcell.build.checkpoint import Checkpoint
from ngcell.geometry.bodies import BodyMesh
from ngcell.mechanics.term import Configuration
from ngcell.problem.problem import Problem
from ngcell.problem.reports import cell_fields
from ngcell.problem.state import State
from ngcell.results.cells import cell_records, debonding
from ngcell.results.checks import Path
from ngcell.results.fields import Label, take_snapshot
from ngcell.results.finding import Finding, compare
from ngcell.results.measure import Measurement, Setup, WorkPoint, measure
from ngcell.results.observables.observable import Observable, observed
from ngcell.results.onset import PairOnsets
from ngcell.results.quantities import View
from ngcell.results.record import CellRecord, StepRecord, WallRecord
from ngcell.results.report import StepReport
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
from ngcell.solve.effort import Effort
from ngcell.solve.step import Accepted

Array = NDArray[np.float64]

#: Gaps at rest below this share of the thickness are round-off.
_ROUND_OFF = 1e-10


@dataclass(frozen=True, eq=False)
class Step:
    """An accepted step with everything that is reported of it.

    Attributes
    ----------
    record : StepRecord
        The row of the history.
    walls : list of WallRecord
        A row a facing pair; empty in tied steps.
    cells : list of CellRecord
        A row a cell; empty in tied steps.
    measurement : Measurement
        The numbers behind them.
    displacement : array of float, shape (unknowns,)
        The displacement [length].
    snapshot : Snapshot or None
        The fields, at reported levels.
    findings : list of Finding
        What the case expects at this level, beside what was measured.
    checkpoint : Checkpoint
        Where the load path stands after it.
    effort : Effort
        What it took.
    """

    record: StepRecord
    walls: list[WallRecord]
    cells: list[CellRecord]
    measurement: Measurement
    displacement: NDArray[np.float64]
    snapshot: Snapshot | None
    findings: list[Finding]
    checkpoint: Checkpoint
    effort: Effort

    @property
    def report(self) -> StepReport:
        """What the summary needs to know of it."""
        measured = self.measurement
        return StepReport(
            self.record,
            measured.certificate,
            tuple(self.findings),
            measured.free_bodies,
            measured.unstored_work,
            debonding(self.walls, self.cells),
            self.effort.refusals,
            self.effort.cutbacks,
        )


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
    """

    def __init__(
        self,
        setup: Setup,
        bodies: BodyMesh,
        *,
        levels: Sequence[float],
        expected: Sequence[Expected | BodyExpected] = (),
        observables: Sequence[Observable] = (),
    ) -> None:
        self._setup, self._bodies = setup, bodies
        self._levels, self._expected, self._observables = levels, expected, observables

    @cached_property
    def gaps_at_rest(self) -> Array:
        """Mean gap of each facing pair at rest [length]; round-off counts as closed."""
        gap = pair_gaps(self._setup.facing, self._setup.facing.gaps(self._setup.walls, self._setup.walls.rest))
        return np.where(np.abs(gap) < _ROUND_OFF * self._bodies.thickness, 0.0, gap)

    def start(self) -> Checkpoint:
        """Return where a run starts whose bodies are in equilibrium at rest: no energy, and the gaps of the mesh."""
        onsets = PairOnsets.starting(0.0, self.gaps_at_rest, self._bodies.thickness)
        return Checkpoint(work={"tied": WorkPoint(), "released": WorkPoint()}, onsets=onsets)

    def step(
        self,
        accepted: Accepted,
        problem: Problem,
        checkpoint: Checkpoint,
        seconds: float,
        *,
        tied: Configuration | None = None,
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
        """
        path = Path(accepted.follows, tied, accepted.account, accepted.minimum.lowest_curvature)
        measured = self._measure(accepted, problem, checkpoint, path)
        after = checkpoint.after(accepted.phase, accepted.minimum.state.displacement, measured.work)
        view = View(problem, _state(accepted), self._setup.walls, self._setup.motion, measured.reaction)
        columns, fields = observed(self._observables, view)
        components = self._components(problem, measured)
        record = self._record(checkpoint.count, accepted, measured, components, seconds)
        record = replace(record, more={**record.more, **columns})
        step = Step(record, [], [], measured, view.state.at.displacement, None, [], after, accepted.effort)
        is_level = any(np.isclose(accepted.load_factor, level) for level in self._levels)
        if accepted.phase == "tied" or not is_level:
            return step
        return self._with_fields(step, view, components, fields)

    def _with_fields(self, step: Step, view: View, components: CellComponents, fields: Any) -> Step:
        """Return a step at a level, with fields, rows of walls and cells, and expected numbers."""
        record, measured, facing = step.record, step.measurement, self._setup.facing
        thickness, at = self._bodies.thickness, view.state.at
        before, gaps = step.checkpoint.onsets, pair_gaps(facing, measured.gap)
        follow = PairOnsets.starting if before is None else before.after
        onsets = follow(record.plate_displacement, gaps, thickness)
        gap, pressure = wall_fields(self._setup.walls, facing, view.problem, at)
        pressed = pressed_lengths(self._setup.walls, facing.pairs, view.problem, at)
        held = cell_fields(view.problem.terms, at, record.load_factor)
        free = np.isin(np.arange(self._bodies.body_count), measured.free_bodies).astype(np.int64)
        snapshot = take_snapshot(
            view.problem,
            at,
            Label(record.step, record.load_factor, record.plate_displacement),
            walls=self._setup.walls,
            wall_data={"gap": gap, "contact_pressure": pressure},
            body_data={"free": free, **held, **fields},
        )
        cells = cell_records(components, measured, record.step, record.plate_displacement, held.get("cell_pressure"))
        return replace(
            step,
            walls=wall_records(facing, measured, record.step, thickness, onsets.onset, pressed),
            cells=cells,
            snapshot=snapshot,
            findings=list(compare(self._expected, record, view, self._levels[-1])),
            checkpoint=replace(step.checkpoint, onsets=onsets),
        )

    def _measure(self, accepted: Accepted, problem: Problem, checkpoint: Checkpoint, path: Path) -> Measurement:
        state, proximal = _state(accepted), accepted.minimum.proximal
        return measure(
            self._setup,
            problem,
            state,
            load_factor=accepted.load_factor,
            proximal_force=-proximal.gradient(state.displacement, problem.mass),
            before=checkpoint.work.get(accepted.phase),
            path=path,
        )

    def _components(self, problem: Problem, measured: Measurement) -> CellComponents:
        """Return the components of a step; the tied solid is one."""
        facing, count = self._setup.facing, self._bodies.body_count
        if not problem.unknowns.lets_bodies_part:
            return CellComponents(np.zeros(count, dtype=np.int64), np.array([count]))
        return find_components(facing, parted_pairs(facing, measured.gap, self._bodies.thickness), count)

    def _record(
        self, number: int, accepted: Accepted, measured: Measurement, components: CellComponents, seconds: float
    ) -> StepRecord:
        thickness, facing, gap = self._bodies.thickness, self._setup.facing, measured.gap
        total, further = facing.weight.sum(), dict(measured.columns)
        x, y, *z = measured.plate_force
        return StepRecord(
            step=number,
            phase="tied" if accepted.phase == "tied" else "released",
            load_factor=accepted.load_factor,
            plate_displacement=accepted.load_factor * float(np.linalg.norm(self._setup.prescribed_displacement)),
            largest_gap=float(gap.max(initial=0.0)),
            mean_gap=float(facing.weight @ gap / total) if total else 0.0,
            smallest_gap=float(gap.min(initial=0.0)),
            parted_pairs=int(parted_pairs(facing, gap, thickness).sum()),
            opened_share=opened_share(facing, gap, thickness),
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
            more=further,
        )


def _state(accepted: Accepted) -> State:
    """Return the state of a step; the solver knows it by protocol only."""
    return cast(State, accepted.minimum.state)
