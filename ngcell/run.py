"""From a case to a result: the one place that wires the rooms; it reads like the method section of a paper."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import ngsolve
import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ngcell.clock import Clock
from ngcell.contact.assembly import Assembly
from ngcell.contact.facing import count_corners, find_facing
from ngcell.contact.penalty import DEFAULT_MULTIPLE, PenaltyContact, penalty_stiffness, softer_multiples
from ngcell.contact.tie import tie_walls
from ngcell.contact.walls import find_walls
from ngcell.errors import NotConverged
from ngcell.export import ResultFolder
from ngcell.geometry.tissue import tissue_mesh
from ngcell.mechanics.bulk import BulkEnergy
from ngcell.mechanics.hyperelastic import MooneyRivlinLaw
from ngcell.mechanics.loading import moved_region, plate_travel, prescribed_motion
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.certificate import worst
from ngcell.results.fields import take_snapshot
from ngcell.results.growth import growth_onset
from ngcell.results.measure import Measurement, Scene, measure, parted_pairs, wall_records
from ngcell.results.record import StepRecord, WallRecord
from ngcell.results.snapshot import Snapshot
from ngcell.results.surface import wall_fields
from ngcell.scene import Case, Sddp, resolved_toml
from ngcell.solve.minimise import Minimiser
from ngcell.solve.outcome import Outcome
from ngcell.solve.selection import Release
from ngcell.solve.strategy import Accepted, Released, StepFailed, compact_then_released, single_step

_log = logging.getLogger(__name__)

#: Below this number of unknowns a second thread costs more than it saves.
_UNKNOWNS_FOR_THREADS = 50_000
#: Walls that face each other nearer than this share of their thickness count as touching at rest.
_TOUCHING = 0.05


@dataclass(frozen=True, eq=False)
class Step:
    """An accepted step with everything that is reported of it.

    Attributes
    ----------
    record : StepRecord
        The row of the history.
    walls : list of WallRecord
        A row a facing pair; empty in compact steps.
    measurement : Measurement
        The numbers behind them.
    displacement : array of float, shape (unknowns,)
        The displacement [length].
    snapshot : Snapshot or None
        The fields, at reported levels.
    """

    record: StepRecord
    walls: list[WallRecord]
    measurement: Measurement
    displacement: NDArray[np.float64]
    snapshot: Snapshot | None


class Simulation:
    """A case, built: mesh, unknowns, energies, contact, and the walk along its load path."""

    def __init__(self, case: Case, clock: Clock | None = None) -> None:
        self.case = case
        self.clock = clock or Clock()
        with self.clock.phase("meshing"):
            self.bodies = tissue_mesh(case.tissue, case.load, case.mesh)
            self.space = DisplacementSpace(self.bodies, case.mesh.order)
            self.walls = find_walls(self.bodies, self.space.scalar, self.space.rest)
        material = case.material
        law = MooneyRivlinLaw(material.c1, material.c2, material.bulk_modulus)
        self.bulk = BulkEnergy(self.space, [law] * self.bodies.body_count)
        self.motion = prescribed_motion(self.space, case.load)
        self.longest_step = self.bodies.thickness / 2
        self.scene = Scene(
            walls=self.walls,
            facing=find_facing(self.walls, _TOUCHING * self.bodies.thickness),
            motion=self.motion,
            moved=moved_region(case.load),
            travel=plate_travel(self.space, case.load),
        )

    @cached_property
    def compact(self) -> Assembly:
        """The tissue as one compact solid."""
        return Assembly(self.space, self.bulk, self.motion.fixed, tie=tie_walls(self.walls, self.space.size))

    @cached_property
    def released(self) -> Assembly:
        """The tissue with its walls in unilateral contact."""
        return self._in_contact(DEFAULT_MULTIPLE * self.case.contact.stiffness)

    def _in_contact(self, multiple: float) -> Assembly:
        moduli = np.array([law.plane_strain_modulus for law in self.bulk.laws])
        stiffness = penalty_stiffness(self.walls, moduli, multiple)
        contact = PenaltyContact(self.walls, stiffness, reach=2 * self.longest_step)
        return Assembly(self.space, self.bulk, self.motion.fixed, contact=contact)

    def walk(self) -> Iterator[Step]:
        """Yield the accepted steps.

        Raises
        ------
        StepFailed
            If a step finds no equilibrium.
        """
        latest: dict[str, Measurement] = {}
        started = perf_counter()
        for number, accepted in enumerate(self._accepted()):
            with self.clock.phase("measuring"):
                measurement = self._measure(accepted, latest.get(accepted.phase))
                latest[accepted.phase] = measurement
                step = self._step(number, accepted, measurement, perf_counter() - started)
            yield step
            started = perf_counter()

    def _accepted(self) -> Iterator[Accepted]:
        levels = self.case.load.level_factors
        if isinstance(self.case.strategy, Sddp):
            compact = self._minimiser(self.compact, np.inf)
            return compact_then_released(
                compact, self._released(), self.motion, steps=self._steps(), levels=levels
            )
        return single_step(self._released(), self.motion, steps=self._steps())

    def _released(self) -> Released:
        meant = DEFAULT_MULTIPLE * self.case.contact.stiffness
        ladder = [self._in_contact(multiple) for multiple in softer_multiples(meant)]
        minimisers = [
            self._minimiser(assembly, self.longest_step) for assembly in (*ladder, self.released)
        ]
        shear_modulus = max(law.shear_modulus for law in self.bulk.laws)
        apart = self._minimiser(Assembly(self.space, self.bulk, self.motion.fixed), self.longest_step)
        path = Release(scale=shear_modulus / self.bodies.length**2)
        return Released(apart, tuple(minimisers), path)

    def _minimiser(self, assembly: Assembly, longest_step: float) -> Minimiser:
        modulus = max(law.shear_modulus for law in self.bulk.laws)
        volume = float(self.space.one @ self.space.scalar_mass @ self.space.one)
        return Minimiser(assembly, longest_step, energy_scale=modulus * volume, clock=self.clock)

    def _steps(self) -> list[float]:
        """Return the load factors of all steps: the levels, with equal steps between them where more are asked for."""
        levels, count = self.case.load.level_factors, self.case.smallest_step_count
        steps, before = [], 0.0
        for level in levels:
            pieces = max(1, round(count * (level - before) / levels[-1]))
            steps += list(np.linspace(before, level, pieces + 1)[1:])
            before = level
        return [float(step) for step in steps]

    def _measure(self, accepted: Accepted, before: Measurement | None) -> Measurement:
        assembly = self.compact if accepted.phase == "compact" else self.released
        state, tether = accepted.minimum.state, accepted.tether
        force = tether.strength * (assembly.mass @ (tether.anchor - state.displacement))
        return measure(
            self.scene,
            assembly,
            state,
            load_factor=accepted.load_factor,
            tether_force=force,
            before=before,
        )

    def _step(self, number: int, accepted: Accepted, measured: Measurement, seconds: float) -> Step:
        assembly = self.compact if accepted.phase == "compact" else self.released
        thickness, facing = self.bodies.thickness, self.scene.facing
        is_contact = accepted.phase == "contact"
        is_level = any(np.isclose(accepted.load_factor, level) for level in self.case.load.level_factors)
        travelled = accepted.load_factor * float(np.linalg.norm(self.scene.travel))
        rows = wall_records(self.scene, measured, number, thickness) if is_contact and is_level else []
        displacement = assembly.expand(accepted.minimum.state.displacement)
        total = facing.weight.sum()
        record = StepRecord(
            step=number,
            phase=accepted.phase,
            load_factor=accepted.load_factor,
            plate_displacement=travelled,
            largest_gap=float(measured.gap.max(initial=0.0)),
            mean_gap=float(facing.weight @ measured.gap / total) if total else 0.0,
            smallest_gap=float(measured.gap.min(initial=0.0)),
            parted_pairs=int(parted_pairs(self.scene, measured, thickness).sum()),
            opened_share=measured.opened_share(facing, thickness),
            plate_force_x=float(measured.plate_force[0]),
            plate_force_y=float(measured.plate_force[1]),
            contact_force=measured.forces.total,
            energy=measured.energy,
            iterations=accepted.effort.iterations,
            factorisations=accepted.effort.factorisations,
            seconds=seconds,
            certified=measured.certificate.passed,
        )
        snapshot = None
        if is_level and is_contact:
            gap, pressure = wall_fields(self.walls, facing, assembly, accepted.minimum.state)
            snapshot = take_snapshot(
                assembly,
                displacement,
                walls=self.walls,
                step=number,
                load_factor=accepted.load_factor,
                plate_displacement=travelled,
                gap=gap,
                contact_pressure=pressure,
                free_bodies=frozenset(measured.free_bodies),
            )
        return Step(record, rows, measured, displacement, snapshot)


class Recording:
    """A run that writes its result folder as it goes: iterate over it to run it.

    Parameters
    ----------
    case : Case
        What is simulated.
    out : Path
        The result folder.
    threads : int, optional
        Number of threads; by default one for small scenes, else one for each core.

    Attributes
    ----------
    summary : dict
        What `summary.json` holds, once the run has ended.
    outcome : str
        How the run ended, in words.
    certified : bool
        Whether it reached the last level and every step passed every check.

    Raises
    ------
    NotConverged
        While iterating: a step found no equilibrium. Everything accepted before is kept.
    OutputError
        While iterating: the folder cannot be used or written.
    """

    def __init__(self, case: Case, out: Path, *, threads: int | None = None) -> None:
        self._case, self._out, self._threads = case, Path(out), threads
        self.summary: dict[str, Any] = {}
        self.outcome, self.certified = Outcome.STOPPED.value, False

    def __iter__(self) -> Iterator[StepRecord]:
        clock = Clock()
        clock.seconds["imports"] = process_time()
        steps: list[Step] = []
        started = perf_counter()
        with ResultFolder(self._out, case_text=resolved_toml(self._case)) as folder:
            simulation = Simulation(self._case, clock)
            outcome, message = None, ""
            with _threads(self._threads, simulation.space.unknowns):
                try:
                    for step in simulation.walk():
                        with clock.phase("output"):
                            folder.accept(step.record, step.walls, step.snapshot)
                        steps.append(step)
                        yield step.record
                except StepFailed as failure:
                    outcome = failure.outcome
                    message = f"at load factor {failure.load_factor:.6g}: {outcome.value}"
            self._judge(steps, outcome)
            with clock.phase("pictures"):
                folder.draw(title=self._case.title, certified=self.certified, onset=_onset(simulation, steps))
            self.summary = _summary(simulation, steps, self.outcome, self.certified)
            self.summary["seconds"] = _seconds(clock, perf_counter() - started)
            folder.finish(self.summary)
        if outcome is not None:
            raise NotConverged(message, outcome=outcome.name, record_count=len(steps))

    def _judge(self, steps: list[Step], failure: Outcome | None) -> None:
        self.certified = failure is None and all(step.record.certified for step in steps)
        ended = Outcome.CERTIFIED if self.certified else Outcome.NOT_CERTIFIED
        self.outcome = (failure or ended).value


def record(case: Case, out: Path, *, threads: int | None = None) -> Recording:
    """Return a run of a case into a result folder; iterate over it to run it."""
    return Recording(case, out, threads=threads)


def simulate(case: Case) -> list[Step]:
    """Run a case without writing anything, and return its accepted steps.

    Raises
    ------
    NotConverged
        If a step finds no equilibrium.
    """
    steps: list[Step] = []
    try:
        simulation = Simulation(case)
        with _threads(None, simulation.space.unknowns):
            steps.extend(simulation.walk())
    except StepFailed as failure:
        raise NotConverged(
            f"at load factor {failure.load_factor:.6g}: {failure.outcome.value}",
            outcome=failure.outcome.name,
            record_count=len(steps),
        ) from failure
    return steps


def inspect(case: Case) -> dict[str, Any]:
    """Build a case without solving it, and return what would be solved."""
    simulation = Simulation(case)
    gap = simulation.scene.facing.gaps(simulation.walls, simulation.walls.rest)
    assembly = simulation.released
    return {
        "bodies": simulation.bodies.body_count,
        "elements": int(simulation.bodies.mesh.ne),
        "order": simulation.space.order,
        "unknowns": simulation.space.unknowns,
        "free_unknowns": int(assembly.free.sum()),
        "wall_edges": simulation.walls.edge_count,
        "facing_pairs": len(simulation.scene.facing.pairs),
        "three_cell_corners": count_corners(simulation.walls),
        "largest_initial_gap": float(gap.max(initial=0.0)),
        "largest_initial_overlap": float(max(0.0, -gap.min(initial=0.0))),
        "penalty_stiffness": [float(f(assembly.contact.stiffness)) for f in (np.min, np.max)],
        "levels": list(case.load.level_factors),
    }


def _summary(simulation: Simulation, steps: list[Step], outcome: str, certified: bool) -> dict[str, Any]:
    """Return what `summary.json` holds of a run."""
    last = steps[-1] if steps else None
    checks = worst(step.measurement.certificate for step in steps)
    return {
        "title": simulation.case.title,
        "outcome": outcome,
        "certified": certified,
        "certificate": {
            name: {"worst": check.value, "limit": check.limit, "passed": check.passed}
            for name, check in checks.items()
        },
        "failed_steps": {
            step.record.step: step.measurement.certificate.failures
            for step in steps
            if not step.record.certified
        },
        "accepted_steps": len(steps),
        "bodies": simulation.bodies.body_count,
        "unknowns": simulation.space.unknowns,
        "facing_pairs": len(simulation.scene.facing.pairs),
        "held_by_nothing": last.measurement.free_bodies if last else (),
        "released_energy": {
            step.record.step: step.measurement.released_energy
            for step in steps
            if step.measurement.released_energy > 0
        },
        "onset_of_growth": _onset(simulation, steps),
        "iterations": sum(step.record.iterations for step in steps),
        "factorisations": sum(step.record.factorisations for step in steps),
        "last_step": asdict(last.record) if last else None,
    }


def _onset(simulation: Simulation, steps: list[Step]) -> float | None:
    contact = [step.record for step in steps if step.record.phase == "contact"]
    displacement, mean = [row.plate_displacement for row in contact], [row.mean_gap for row in contact]
    return growth_onset(displacement, mean, simulation.bodies.thickness)


def _seconds(clock: Clock, wall: float) -> dict[str, Any]:
    return {"on_the_clock": wall, "processor": process_time(), "processor_by_phase": dict(clock.seconds)}


@contextmanager
def _threads(asked: int | None, unknowns: int) -> Iterator[None]:
    """Let NGSolve use more than one thread where that pays, or where it is asked for; dense blocks get one each."""
    count = asked or (1 if unknowns < _UNKNOWNS_FOR_THREADS else os.cpu_count() or 1)
    ngsolve.SetNumThreads(count)
    with threadpool_limits(1, user_api="blas"), ngsolve.TaskManager() if count > 1 else nullcontext():
        yield
