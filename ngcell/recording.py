"""A run that writes its result folder as it goes."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from time import monotonic, perf_counter, process_time
from typing import Any

from threadpoolctl import threadpool_limits

from ngcell.build.checkpoint import Checkpoint
from ngcell.build.penalty_error import check_has_penalty, stiffer_result
from ngcell.build.simulation import Simulation
from ngcell.clock import Clock, OutOfTime
from ngcell.errors import CaseError, NotConverged
from ngcell.export import Restart, ResultFolder, cannot_resume
from ngcell.mechanics.symbolic import assembly_threads
from ngcell.results.certificate import worst
from ngcell.results.growth import growth_onset
from ngcell.results.record import StepRecord
from ngcell.results.report import StepReport
from ngcell.scene import AnyCase, BodyScene, resolved_toml
from ngcell.solve.outcome import Outcome
from ngcell.solve.step import StepFailed

_log = logging.getLogger(__name__)

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
        Number of threads of large scenes, by default one for each core and never more; small scenes use one. Results
        do not depend on it.
    verify_penalty : bool
        Whether the last level is repeated with a stiffer penalty, to report how far the result moves.
    restart : Restart, optional
        Where an earlier run into this folder stood; this one goes on from there.
    force : bool
        Whether accepted steps of an earlier run that the folder holds may be replaced.
    max_minutes : float, optional
        Time on the clock after which the run ends, > 0; by default it takes as long as it needs.

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
        While iterating: a step found no equilibrium, or the time is over. Everything accepted before is kept.
    OutputError
        While iterating: the folder cannot be used or written.
    CaseError
        While iterating: the scene cannot be meshed. At once: `max_minutes` is no time.
    """

    def __init__(
        self,
        case: AnyCase | BodyScene,
        out: Path,
        *,
        threads: int | None = None,
        verify_penalty: bool = False,
        restart: Restart | None = None,
        force: bool = False,
        max_minutes: float | None = None,
    ) -> None:
        if max_minutes is not None and not max_minutes > 0:
            raise CaseError(f"max_minutes = {max_minutes}; allowed: a number > 0")
        if verify_penalty:
            check_has_penalty(case)
        self._case, self._out, self._threads = case, Path(out), threads
        self._verify_penalty, self._restart = verify_penalty, restart
        self._force, self._max_minutes = force, max_minutes
        self.summary: dict[str, Any] = {}
        self.outcome, self.certified = Outcome.STOPPED.value, False

    def __iter__(self) -> Iterator[StepRecord]:
        clock = Clock(None if self._max_minutes is None else monotonic() + 60 * self._max_minutes)
        clock.seconds["imports"] = process_time()
        steps = list(self._restart.reports) if self._restart else []
        started = perf_counter()
        with ResultFolder(
            self._out, case_text=resolved_toml(self._case), restart=self._restart, force=self._force
        ) as folder:
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
                    verified = self._verified(steps, simulation)
                except StepFailed as failure:
                    outcome = failure.outcome
                    message = f"at load factor {failure.load_factor:.6g}: {outcome.value}"
                except OutOfTime:
                    outcome = Outcome.OUT_OF_TIME
                    message = f"beyond load factor {_reached(steps):.6g}: {outcome.value}"
            self._judge(steps, outcome)
            with clock.phase("pictures"):
                folder.draw(title=self._case.title, certified=self.certified, onset=_onset(simulation, steps))
            self.summary = _summary(self._case.title, simulation, steps, self.outcome, self.certified)
            if verified is not None:
                self.summary["stiffer_penalty"] = verified
            self.summary["seconds"] = _seconds(clock, perf_counter() - started)
            if outcome is not Outcome.OUT_OF_TIME:  # such a run is stopped, and can be resumed
                folder.finish(self.summary)
            if outcome is not None:
                raise NotConverged(message, outcome=outcome.name, steps=tuple(steps))

    def _checkpoint(self, simulation: Simulation) -> Checkpoint:
        """Return where the load path starts."""
        if self._restart is None:
            return simulation.start
        try:
            checkpoint = Checkpoint.from_arrays(self._restart.checkpoint, simulation.space.unknowns)
            if checkpoint.count != len(self._restart.reports):
                raise ValueError(f"{checkpoint.count} steps where {len(self._restart.reports)} were accepted")
            return checkpoint
        except (ValueError, KeyError, TypeError, LookupError) as error:
            raise cannot_resume(self._out, f"the checkpoint does not fit the case ({error})") from error

    def _verified(self, steps: list[StepReport], simulation: Simulation) -> dict[str, Any] | None:
        if not self._verify_penalty:
            return None
        raised = getattr(simulation.contact, "raised", 1.0)
        try:
            return stiffer_result(self._case, steps[-1], raised, end=simulation.clock.end)
        except StepFailed as failure:
            return {"failed": failure.outcome.value}
        except OutOfTime:
            return {"failed": Outcome.OUT_OF_TIME.value}

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
            name: {
                "worst": check.value,
                "limit": check.limit,
                "passed": check.passed,
                **({"place": check.place} if check.place else {}),
            }
            for name, check in checks.items()
        },
        "meaning_of_checks": {name: check.meaning for name, check in checks.items()},
        "expected": [finding.table() for step in steps for finding in step.findings],
        "failed_steps": {step.record.step: step.certificate.failures for step in steps if not step.record.certified},
        "accuracy": simulation.accuracy,
        "accepted_steps": len(steps),
        "bodies": simulation.bodies.body_count,
        "unknowns": simulation.space.unknowns,
        "meshes": simulation.refinement.table(),
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


def _reached(steps: list[StepReport]) -> float:
    """Return the load factor that has been reached."""
    return steps[-1].record.load_factor if steps else 0.0


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


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def use_threads(asked: int | None, unknowns: int) -> Iterator[None]:
    """Let NGSolve assemble by more than one thread where that pays; no digit depends on it, see
    `ngcell.mechanics.symbolic`."""
    cores = available_cores()
    if asked is not None and asked > cores:
        _log.warning("%d threads were asked for; %d run, one for each core that this process may use", asked, cores)
    count = 1 if unknowns < _UNKNOWNS_FOR_THREADS else min(asked or cores, cores)
    with threadpool_limits(1, user_api="blas"), assembly_threads(count):
        yield
