"""A run that writes its result folder as it goes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import asdict
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import ngsolve
from threadpoolctl import threadpool_limits

from ngcell.build.checkpoint import Checkpoint
from ngcell.build.penalty_error import check_has_penalty, stiffer_result
from ngcell.build.simulation import Simulation
from ngcell.clock import Clock
from ngcell.errors import NotConverged
from ngcell.export import Restart, ResultFolder, cannot_resume
from ngcell.results.certificate import worst
from ngcell.results.growth import growth_onset
from ngcell.results.record import StepRecord
from ngcell.results.report import StepReport
from ngcell.scene import AnyCase, BodyScene, resolved_toml
from ngcell.solve.outcome import Outcome
from ngcell.solve.step import StepFailed

#: Below this number of unknowns a second thread costs more than it saves.
_UNKNOWNS_FOR_THREADS = 50_000
#: The outcome of a run that converged elsewhere than its case expects.
_NOT_AS_EXPECTED = "converged, but a number is not as the case expects; see the expected numbers for which one"


class Recording:
    """A run that writes its result folder as it goes: iterate over it to run it.

    Parameters
    ----------
    case : Case, BodyCase or BodyScene
        What is simulated.
    out : Path
        The result folder.
    threads : int, optional
        Number of threads; by default one for small scenes, else one for each core.
    verify_penalty : bool
        Whether the last level is repeated with a stiffer penalty, to report how far the result moves.
    restart : Restart, optional
        Where an earlier run into this folder stood; this one goes on from there.

    Attributes
    ----------
    summary : dict
        What `summary.json` holds, once the run has ended.
    outcome : str
        How the run ended, in words.
    certified : bool
        Whether it reached the last level and every step passed every check and every expected number.

    Raises
    ------
    NotConverged
        While iterating: a step found no equilibrium. Everything accepted before is kept.
    OutputError
        While iterating: the folder cannot be used or written.
    """

    def __init__(
        self,
        case: AnyCase | BodyScene,
        out: Path,
        *,
        threads: int | None = None,
        verify_penalty: bool = False,
        restart: Restart | None = None,
    ) -> None:
        if verify_penalty:
            check_has_penalty(case)
        self._case, self._out, self._threads = case, Path(out), threads
        self._verify_penalty, self._restart = verify_penalty, restart
        self.summary: dict[str, Any] = {}
        self.outcome, self.certified = Outcome.STOPPED.value, False

    def __iter__(self) -> Iterator[StepRecord]:
        clock = Clock()
        clock.seconds["imports"] = process_time()
        steps = list(self._restart.reports) if self._restart else []
        started = perf_counter()
        with ResultFolder(self._out, case_text=resolved_toml(self._case), restart=self._restart) as folder:
            simulation = Simulation(self._case, clock)
            checkpoint = self._checkpoint(simulation)
            outcome, message, verified = None, "", None
            with use_threads(self._threads, simulation.space.unknowns):
                try:
                    for step in simulation.accepted_steps(checkpoint):
                        with clock.phase("output"):
                            folder.accept(
                                step.record,
                                step.walls,
                                step.snapshot,
                                step.cells,
                                report=step.report,
                                checkpoint=step.checkpoint.arrays(),
                            )
                        steps.append(step.report)
                        yield step.record
                    verified = self._verified(steps, getattr(simulation.contact, "raised", 1.0))
                except StepFailed as failure:
                    outcome = failure.outcome
                    message = f"at load factor {failure.load_factor:.6g}: {outcome.value}"
            self._judge(steps, outcome)
            with clock.phase("pictures"):
                folder.draw(title=self._case.title, certified=self.certified, onset=_onset(simulation, steps))
            self.summary = _summary(self._case.title, simulation, steps, self.outcome, self.certified)
            if verified is not None:
                self.summary["stiffer_penalty"] = verified
            self.summary["seconds"] = _seconds(clock, perf_counter() - started)
            folder.finish(self.summary)
        if outcome is not None:
            raise NotConverged(message, outcome=outcome.name, steps=tuple(steps))

    def _checkpoint(self, simulation: Simulation) -> Checkpoint:
        """Return where the continuation starts."""
        if self._restart is None:
            return simulation.start
        try:
            return Checkpoint.from_arrays(self._restart.checkpoint, simulation.space.unknowns)
        except (ValueError, KeyError, TypeError) as error:
            raise cannot_resume(self._out, f"what the continuation stood at does not fit the case ({error})") from error

    def _verified(self, steps: list[StepReport], raised: float) -> dict[str, Any] | None:
        if not self._verify_penalty:
            return None
        try:
            return stiffer_result(self._case, steps[-1], raised)
        except StepFailed as failure:
            return {"failed": failure.outcome.value}

    def _judge(self, steps: list[StepReport], failure: Outcome | None) -> None:
        in_balance = failure is None and all(step.record.certified for step in steps)
        as_expected = all(finding.passed for step in steps for finding in step.findings)
        self.certified = in_balance and as_expected
        ended = Outcome.CERTIFIED if in_balance else Outcome.NOT_CERTIFIED
        self.outcome = (failure or ended).value if as_expected or not in_balance else _NOT_AS_EXPECTED


def _summary(
    title: str, simulation: Simulation, steps: list[StepReport], outcome: str, certified: bool
) -> dict[str, Any]:
    """Return what `summary.json` holds of a run."""
    last = steps[-1] if steps else None
    checks = worst(step.certificate for step in steps)
    return {
        "title": title,
        "outcome": outcome,
        "certified": certified,
        "certificate": {
            name: {"worst": check.value, "limit": check.limit, "passed": check.passed} for name, check in checks.items()
        },
        "meaning_of_checks": {name: check.meaning for name, check in checks.items()},
        "expected": [finding.table() for step in steps for finding in step.findings],
        "failed_steps": {step.record.step: step.certificate.failures for step in steps if not step.record.certified},
        "accepted_steps": len(steps),
        "bodies": simulation.bodies.body_count,
        "unknowns": simulation.space.unknowns,
        "facing_pairs": len(simulation.setup.facing.pairs),
        "held_by_nothing": last.free_bodies if last else (),
        "changes_of_branch": {
            step.record.step: {"unstored_work": step.unstored_work}
            for step in steps
            if step.record.phase == "released" and step.unstored_work != 0
        },
        "debonding": next((step.debonding for step in reversed(steps) if step.debonding), {}),
        "onset_of_growth": _onset(simulation, steps),
        "onset_is_a_bound": _onset_is_a_bound(simulation, steps),
        "iterations": sum(step.record.iterations for step in steps),
        "factorisations": sum(step.record.factorisations for step in steps),
        "refused": sum(step.refused for step in steps),
        "cut_backs": sum(step.cutbacks for step in steps),
        "last_step": asdict(last.record) if last else None,
    }


def _released(steps: list[StepReport]) -> list[StepRecord]:
    return [step.record for step in steps if step.record.phase == "released"]


def _onset_is_a_bound(simulation: Simulation, steps: list[StepReport]) -> bool:
    """Return whether gaps had grown at the first level already, and nobody knows how much earlier."""
    contact, onset = _released(steps), _onset(simulation, steps)
    starts_later = bool(contact) and contact[0].load_factor > 0 and not simulation.starts_at_rest
    return starts_later and onset == contact[0].plate_displacement


def _onset(simulation: Simulation, steps: list[StepReport]) -> float | None:
    contact = _released(steps)
    displacement, mean = [row.plate_displacement for row in contact], [row.mean_gap for row in contact]
    return growth_onset(displacement, mean, simulation.bodies.thickness, at_rest=simulation.mean_gap_at_rest)


def _seconds(clock: Clock, wall: float) -> dict[str, Any]:
    return {"on_the_clock": wall, "processor": process_time(), "processor_by_phase": dict(clock.seconds)}


@contextmanager
def use_threads(asked: int | None, unknowns: int) -> Iterator[None]:
    """Let NGSolve use more than one thread where that pays, or where it is asked for; dense blocks get one each."""
    count = asked or (1 if unknowns < _UNKNOWNS_FOR_THREADS else os.cpu_count() or 1)
    ngsolve.SetNumThreads(count)
    with threadpool_limits(1, user_api="blas"), ngsolve.TaskManager() if count > 1 else nullcontext():
        yield
