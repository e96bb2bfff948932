"""What is reported of an accepted step: numbers, rows of the tables, fields, and what the case expects beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.problem.assembly import Assembly
from ngcell.geometry.bodies import BodyMesh
from ngcell.results.cells import CellComponents, cell_pressures, cell_records, debonding, find_components
from ngcell.results.fields import take_snapshot
from ngcell.results.finding import Finding, compare
from ngcell.results.measure import Measurement, Scene, WorkPoint, measure, pair_gaps, parted_pairs, wall_records
from ngcell.results.onset import PairOnsets
from ngcell.results.quantities import View
from ngcell.results.record import CellRecord, StepRecord, WallRecord
from ngcell.results.report import StepReport
from ngcell.results.snapshot import Snapshot
from ngcell.results.surface import wall_fields
from ngcell.scene.expected import BodyExpected, Expected
from ngcell.solve.effort import Effort
from ngcell.solve.step import Accepted
from ngcell.build.checkpoint import Checkpoint

Array = NDArray[np.float64]


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
        Where the continuation stands after it.
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
    scene : Scene
        Walls, facing pairs, and what moves.
    bodies : BodyMesh
        The mesh.
    levels : sequence of float
        Load factors that fields and walls are reported at.
    expected : sequence of Expected or BodyExpected
        What the case expects.
    cell_pressure : array of float, shape (bodies,), optional
        Full pressure in each cell [stress], where it is given.
    """

    def __init__(
        self,
        scene: Scene,
        bodies: BodyMesh,
        *,
        levels: Sequence[float],
        expected: Sequence[Expected | BodyExpected],
        cell_pressure: Array | None,
    ) -> None:
        self._scene, self._bodies = scene, bodies
        self._levels, self._expected, self._given = levels, expected, cell_pressure

    def step(
        self,
        accepted: Accepted,
        assembly: Assembly,
        checkpoint: Checkpoint,
        memory: dict[str, Array] | None,
        seconds: float,
    ) -> Step:
        """Return what is reported of a step that follows where the continuation was checkpoint.

        Parameters
        ----------
        accepted : Accepted
            The step.
        assembly : Assembly
            The problem that it solves.
        checkpoint : Checkpoint
            Where the continuation stood before it.
        memory : dict of array, optional
            What terms with a memory keep of it.
        seconds : float
            What it took, on the clock.
        """
        measured = self._measure(accepted, assembly, checkpoint.work.get(accepted.phase))
        after = checkpoint.after(accepted.phase, accepted.minimum.state.displacement, measured.work, memory)
        components = find_components(self._scene, assembly, measured)
        record = self._record(checkpoint.count, accepted, measured, components, seconds)
        displacement = assembly.expand(accepted.minimum.state.displacement)
        is_level = any(np.isclose(accepted.load_factor, level) for level in self._levels)
        if accepted.phase == "tied" or not is_level:
            return Step(record, [], [], measured, displacement, None, [], after, accepted.effort)
        thickness, facing = self._bodies.thickness, self._scene.facing
        held = self._cell_pressure(assembly, displacement, measured)
        onsets = after.onsets or PairOnsets.closed(len(facing.pairs))
        onsets = onsets.after(record.plate_displacement, pair_gaps(facing, measured), thickness)
        view = View(assembly, accepted.minimum.state, self._scene.motion, measured.reaction)
        gap, pressure = wall_fields(self._scene.walls, facing, assembly, accepted.minimum.state)
        snapshot = take_snapshot(
            assembly,
            displacement,
            walls=self._scene.walls,
            step=record.step,
            load_factor=accepted.load_factor,
            plate_displacement=record.plate_displacement,
            gap=gap,
            contact_pressure=pressure,
            free_bodies=frozenset(measured.free_bodies),
            cell_pressure=held,
        )
        return Step(
            record,
            wall_records(self._scene, measured, record.step, thickness, onsets.onset),
            cell_records(components, measured, record.step, record.plate_displacement, held),
            measured,
            displacement,
            snapshot,
            list(compare(self._expected, record, view, self._levels[-1])),
            replace(after, onsets=onsets),
            accepted.effort,
        )

    def _measure(self, accepted: Accepted, assembly: Assembly, before: WorkPoint | None) -> Measurement:
        state, proximal = accepted.minimum.state, accepted.minimum.proximal
        force = proximal.weight * (assembly.mass @ (proximal.centre - state.displacement))
        # The solver's energy holds potentials of loads and fluids; what is reported as energy is what is stored.
        state = replace(state, energy=state.energy - assembly.potential(state.displacement))
        return measure(
            self._scene,
            assembly,
            state,
            load_factor=accepted.load_factor,
            proximal_force=force,
            before=before,
            account=accepted.account,
        )

    def _cell_pressure(self, assembly: Assembly, displacement: Array, measured: Measurement) -> Array | None:
        given = None if self._given is None else measured.load_share * self._given
        return cell_pressures(assembly, displacement, given)

    def _record(
        self, number: int, accepted: Accepted, measured: Measurement, components: CellComponents, seconds: float
    ) -> StepRecord:
        thickness, facing = self._bodies.thickness, self._scene.facing
        total = facing.weight.sum()
        return StepRecord(
            step=number,
            phase=accepted.phase,
            load_factor=accepted.load_factor,
            plate_displacement=accepted.load_factor * float(np.linalg.norm(self._scene.prescribed_displacement)),
            largest_gap=float(measured.gap.max(initial=0.0)),
            mean_gap=float(facing.weight @ measured.gap / total) if total else 0.0,
            smallest_gap=float(measured.gap.min(initial=0.0)),
            parted_pairs=int(parted_pairs(self._scene, measured, thickness).sum()),
            opened_share=measured.opened_share(facing, thickness),
            components=len(components.sizes),
            largest_component=int(components.sizes.max()),
            plate_force_x=float(measured.plate_force[0]),
            plate_force_y=float(measured.plate_force[1]),
            contact_force=measured.forces.total,
            energy=measured.energy,
            iterations=accepted.effort.iterations,
            factorisations=accepted.effort.factorisations,
            seconds=seconds,
            certified=measured.certificate.passed,
            separation_energy=measured.separation_energy,
            bonded_share=measured.bonded_share,
            dissipation=measured.dissipation,
            plate_force_z=float(measured.plate_force[2]) if self._bodies.dimension == 3 else 0.0,
        )
