"""A run that writes its result folder as it goes."""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from hashlib import sha256
from importlib import metadata
from math import hypot
from pathlib import Path
from time import monotonic, perf_counter, process_time
from typing import Any

from ngcell.build.additions import Additions
from ngcell.build.checkpoint import Checkpoint
from ngcell.build.run_summary import onset_of_growth, reached, run_summary
from ngcell.build.simulation import Simulation
from ngcell.build.verification import check_has_penalty, finer_result, stiffer_result
from ngcell.clock import Clock, OutOfTime
from ngcell.errors import CaseError, NgcellError, NotConverged
from ngcell.export import Restart, ResultFolder, cannot_resume
from ngcell.results.record import StepRecord
from ngcell.results.report import StepReport
from ngcell.results.verdict import with_error
from ngcell.scene import AnyCase, BodyScene, resolved_toml
from ngcell.scene.kinds import check_is_scene
from ngcell.solve.outcome import Outcome
from ngcell.solve.step import StepFailed
from ngcell.threads import each_on_threads, threads, threads_for

#: True once: what the process has taken before its first run are imports.
_IS_FIRST = iter((True,))
#: The outcome of a run that converged elsewhere than its case expects.
_NOT_AS_EXPECTED = "converged, but a number is not as the case expects; see the expected numbers for which one"


@dataclass(frozen=True)
class RecordingOptions:
    """How a run is recorded; no number of its result depends on it.

    Attributes
    ----------
    threads : int, optional
        Number of threads of large scenes, by default one for each core and never more; small scenes use one.
    verify_penalty : bool
        Whether the last level is repeated with a stiffer penalty, to report how far the result moves.
    verify_mesh : bool
        Whether the last level is solved again on a finer mesh: on the finest one, to report how far its numbers move
        beside their estimated errors; by one order more where none are estimated, to report errors.
    force : bool
        Whether accepted steps of an earlier run that the folder holds may be replaced.
    max_minutes : float, optional
        Time on the clock after which the run ends, > 0; by default it takes as long as it needs.
    pictures : bool
        Whether pictures are drawn at the end.

    Raises
    ------
    CaseError
        `max_minutes` is no time, or `threads` no number of threads.
    """

    threads: int | None = None
    verify_penalty: bool = False
    verify_mesh: bool = False
    force: bool = False
    max_minutes: float | None = None
    pictures: bool = True

    def __post_init__(self) -> None:
        if self.max_minutes is not None and not self.max_minutes > 0:
            raise CaseError(f"max_minutes = {self.max_minutes}; allowed: a number > 0")
        if self.threads is not None and self.threads < 1:
            raise CaseError(f"threads = {self.threads}; allowed: a whole number >= 1")

    @property
    def end(self) -> float | None:
        """When a run that begins now has to end, as `time.monotonic` tells it [s]."""
        return None if self.max_minutes is None else monotonic() + 60 * self.max_minutes


class Recording:
    """A run that writes its result folder as it goes: iterate over it to run it.

    Parameters
    ----------
    case : Case, BodyCase or BodyScene
        What is simulated.
    out : Path
        The result folder.
    additions : Additions
        What a script adds to it.
    options : RecordingOptions
        How it is recorded.
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
        While iterating: a step found no equilibrium, or the time is over. Everything accepted before is kept.
    OutputError
        While iterating: the folder cannot be used or written.
    CaseError
        While iterating: the scene cannot be meshed. At once: it is no scene, or there is no penalty to verify.
    """

    def __init__(
        self,
        case: AnyCase | BodyScene,
        out: Path,
        *,
        additions: Additions,
        options: RecordingOptions,
        restart: Restart | None = None,
    ) -> None:
        check_is_scene(case)
        if options.verify_penalty:
            check_has_penalty(case)
        self._case, self._out, self._additions = case, Path(out), additions
        self._options, self._restart = options, restart
        self.summary: dict[str, Any] = {}
        self.outcome, self.certified = Outcome.STOPPED.value, False

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in the order of the load path."""
        return self._case.level_factors

    @property
    def accepted_before(self) -> tuple[StepRecord, ...]:
        """Steps that the run which this one resumes had accepted."""
        return tuple(report.record for report in self._restart.reports) if self._restart else ()

    def __iter__(self) -> Iterator[StepRecord]:
        clock = Clock(self._options.end)
        began = process_time()
        before = 0.0 if next(_IS_FIRST, False) else began
        clock.seconds["imports"] = began - before
        steps = list(self._restart.reports) if self._restart else []
        started = perf_counter()
        with self._folder() as folder:
            simulation = self._additions.simulation(self._case, clock)
            checkpoint = self._checkpoint(simulation)
            outcome, message, verified = None, "", dict[str, Any]()
            count = threads_for(self._options.threads)
            try:
                for step in each_on_threads(simulation.accepted_steps(checkpoint), count):
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
                with threads(count):
                    verified = self._verified(steps, simulation)
            except StepFailed as failure:
                outcome = failure.outcome
                message = f"at load factor {failure.load_factor:.6g}: {outcome.value}"
            except OutOfTime:
                outcome = Outcome.OUT_OF_TIME
                message = f"beyond load factor {reached(steps):.6g}: {outcome.value}{_on_the_way(simulation)}"
            self._judge(steps, outcome)
            undrawn: Exception | None = None
            with clock.phase("pictures"):
                try:
                    onset = onset_of_growth(simulation, steps)
                    folder.draw(title=self._case.title, certified=self.certified, onset=onset)
                except Exception as error:  # noqa: BLE001 - the run has ended, and its summary comes first
                    undrawn = error
            self.summary = run_summary(self._case.title, simulation, steps, self.outcome, self.certified)
            self.summary |= verified
            self.summary["versions"] = _versions()
            self.summary["seconds"] = _seconds(clock, perf_counter() - started, process_time() - before)
            if outcome is not Outcome.OUT_OF_TIME:  # such a run is stopped, and can be resumed
                folder.finish(self.summary)
            if undrawn is not None:
                raise undrawn
            if outcome is not None:
                raise NotConverged(message, outcome=outcome.name, steps=tuple(steps))

    def _folder(self) -> ResultFolder:
        text, options = recorded_text(self._case, self._additions), self._options
        return ResultFolder(
            self._out, case_text=text, restart=self._restart, force=options.force, pictures=options.pictures
        )

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

    def _verified(self, steps: list[StepReport], simulation: Simulation) -> dict[str, Any]:
        """Return what was asked for to be verified, by its name in the summary."""
        case, additions, last, end = self._case, self._additions, steps[-1], simulation.clock.end
        found: dict[str, Any] = {}
        if self._options.verify_penalty:
            raised = getattr(simulation.contact, "raised", 1.0)
            found["stiffer_penalty"] = _or_failed(lambda: stiffer_result(case, additions, last, raised, end=end))
        if self._options.verify_mesh:
            found["finer_mesh"] = _or_failed(lambda: finer_result(case, additions, last.record, end=end))
        return found

    def _judge(self, steps: list[StepReport], failure: Outcome | None) -> None:
        in_balance = failure is None and all(step.record.certified for step in steps)
        as_expected = all(finding.passed for step in steps for finding in step.findings)
        self.certified = in_balance and as_expected
        ended = Outcome.CERTIFIED if in_balance else Outcome.NOT_CERTIFIED
        self.outcome = (failure or ended).value if as_expected or not in_balance else _NOT_AS_EXPECTED


def recorded_text(case: AnyCase | BodyScene, additions: Additions) -> str:
    """Return what `case.toml` says of a run: the case, and as comments the file of its tissue and what a script added.
    """
    return resolved_toml(case) + file_told(case) + additions.told


def _or_failed(verify: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Return what a verification finds, or why it finds nothing: the run that it verifies has ended well."""
    try:
        return verify()
    except StepFailed as failure:
        return {"failed": failure.outcome.value}
    except OutOfTime:
        return {"failed": Outcome.OUT_OF_TIME.value}
    except NgcellError as error:
        return {"failed": str(error)}


def _on_the_way(simulation: Simulation) -> str:
    """Return what the last mesh of a step told that is not finished; empty where there was none."""
    if simulation.refinement.on_the_way is None:
        return ""
    mesh, found, errors = simulation.refinement.on_the_way
    plate = hypot(*found.plate_force)
    told = {"energy": found.energy, "mean gap": found.mean_gap, "plate force": plate}
    known = {"energy": errors.energy, "mean gap": errors.mean_gap, "plate force": errors.plate_force}
    numbers = ", ".join(f"{name} {with_error(value, known[name])}" for name, value in told.items())
    return f"; on mesh {mesh}, not accepted: {numbers}"


def file_told(case: AnyCase | BodyScene) -> str:
    """Return a comment that tells a file that the tissue of a case is read from; empty where it is read from none."""
    file = getattr(getattr(case, "tissue", None), "file", None)
    if file is None:
        return ""
    return f"# tissue.file {Path(file).name}: SHA-256 {sha256(Path(file).read_bytes()).hexdigest()}\n"


def _versions() -> dict[str, str]:
    """Return the versions of what a result depends on."""
    libraries = {name: metadata.version(name) for name in ("ngsolve", "numpy", "scipy")}
    own = sys.modules["ngcell"].__version__  # an import of the table of contents, which offers this module, is a circle
    return {"ngcell": own, "python": platform.python_version(), **libraries}


def _seconds(clock: Clock, wall: float, processor: float) -> dict[str, Any]:
    return {"on_the_clock": wall, "processor": processor, "processor_by_phase": dict(clock.seconds)}
