"""`ngcell solve CASE`: follow the load path, show each accepted step, end with the verdict of the certificate."""

from __future__ import annotations

import atexit
import gc
import logging
import sys
from collections.abc import Mapping
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any, NoReturn

import click

from ngcell.cli.arguments import finite, optional_case_argument, set_option
from ngcell.cli.members import holds_members, members_lines
from ngcell.cli.pace import Pace
from ngcell.cli.progress import silent_progress, step_progress
from ngcell.cli.streams import note
from ngcell.cli.summary import summary_lines
from ngcell.errors import NotConverged

if TYPE_CHECKING:
    from ngcell.ensemble import Ensemble
    from ngcell.recording import Recording
    from ngcell.scene import AnyCase


@click.command(short_help="Solve a case, or resume a run that stopped.")
@optional_case_argument
@set_option
@click.option("--out", type=click.Path(path_type=Path), help="Result folder; default out/<case name>.")
@click.option(
    "--resume",
    metavar="DIR",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Resume the run that stopped in DIR; takes no CASE.",
)
@click.option("--force", is_flag=True, help="Replace the accepted steps of an earlier run in the result folder.")
@click.option(
    "--max-minutes",
    metavar="MINUTES",
    type=click.FloatRange(min=0, min_open=True),
    callback=finite,
    help="End the run after this time; it keeps every accepted step, and --resume computes the rest.",
)
@click.option(
    "--threads", type=click.IntRange(min=1), help="Number of threads; never more than the cores that are free to use."
)
@click.option(
    "--verify-penalty", is_flag=True, help="Repeat the last level with a stiffer penalty and report what changes."
)
@click.option(
    "--verify-mesh",
    is_flag=True,
    help="Take the last level on to the finest mesh and report what changes; where errors are not estimated, repeat "
    "the run with elements of one order more and report its errors.",
)
@click.option(
    "--members",
    metavar="N",
    type=click.IntRange(min=2),
    help="Run N members of the case, whose geometries differ a little, and tell mean and spread of each number.",
)
@click.option("--seed", type=click.IntRange(min=0), help="Seed of the first member, by default 0; the others follow.")
@click.option(
    "--spread",
    metavar="SHARE",
    type=click.FloatRange(min=0, max=0.1, min_open=True),
    callback=finite,
    help="Share of the side by which corners are displaced at most, and of their thickness by which walls deviate, "
    "by default 0.001. Tissues that are drawn from a seed differ as they say.",
)
@click.option("--quiet", "-q", is_flag=True, help="Show no progress.")
@click.option("--verbose", "-v", is_flag=True, help="Show the log of the solver.")
def solve(
    case: str | None,
    overrides: tuple[str, ...],
    out: Path | None,
    resume: Path | None,
    force: bool,
    max_minutes: float | None,
    threads: int | None,
    verify_penalty: bool,
    verify_mesh: bool,
    members: int | None,
    seed: int | None,
    spread: float | None,
    quiet: bool,
    verbose: bool,
) -> None:
    """Solve CASE, a TOML file or the name of a case that comes with ngcell (`ngcell cases` lists them).

    The result folder gets summary.json, tables of steps, walls and cells (CSV), fields for ParaView (tissue.pvd), and
    pictures. The terminal tells at the end whether the result is certified, and how large its errors may be.

    Results are written during the run: a run that is stopped keeps every step that it accepted, and --resume
    computes the rest. A folder that holds accepted steps of an earlier run is left as it is, unless --force is given;
    even then they stay until the new run accepts its first step.

    With --members the folder (by default out/<case name>-members) holds one result for each member, members.csv with
    their numbers, and spread.csv with mean, standard deviation, smallest and largest value of each number at each
    level. Members that are not certified are told and do not count. Seeds S, S + 1, ... give the same members again;
    --resume runs those that are missing.
    """
    _collect_garbage_rarely()
    if resume is not None and force:
        raise click.UsageError("--resume DIR replaces nothing: no --force")
    if members is None and (seed is not None or spread is not None):
        raise click.UsageError("--seed and --spread say which members are run: together with --members N only")
    if members is not None and (resume is not None or verify_penalty or verify_mesh):
        raise click.UsageError(
            "--members takes neither --resume DIR, which knows its members, nor --verify-penalty or --verify-mesh"
        )
    scene, folder, accepted = _task(case, overrides, out, resume, suffix="" if members is None else "-members")
    if members is None and holds_members(folder, resume) and (verify_penalty or verify_mesh):
        raise click.UsageError(f"{folder} holds members: they take neither --verify-penalty nor --verify-mesh")
    if members is not None or holds_members(folder, resume):
        given = {"count": members, "seed": seed or 0, "spread": spread}
        options = {"threads": threads, "force": force, "max_minutes": max_minutes}
        _solve_members(scene, folder, given, options, quiet, verbose)
        return
    verify = {"verify_penalty": verify_penalty, "verify_mesh": verify_mesh}
    how: dict[str, Any] = {"threads": threads, "max_minutes": max_minutes, **verify}
    try:
        from ngcell import run

        with silent_progress() if quiet else step_progress() as show:
            # The log is opened after the live line has replaced stderr; a handler made before would write across it.
            _log_to_stderr(logging.INFO if verbose else logging.WARNING)
            recording: Recording
            if scene is None:
                recording = run.resume(folder, **how)
            else:
                recording = run.record(scene, folder, force=force, **how)
            pace = Pace(recording.level_factors)
            for record in recording.accepted_before:
                pace.accept(record)
            for record in recording:
                accepted = record.step + 1
                pace.accept(record)
                show(record, pace)
    except KeyboardInterrupt:
        _give_up("stopped by Ctrl-C", accepted, folder, can_go_on=True)
    except NotConverged as error:
        _give_up(str(error), len(error.steps), folder, can_go_on=error.outcome == "OUT_OF_TIME")
    for line in summary_lines(recording, folder):
        click.echo(line)
    if not recording.certified:
        note(f"not certified; accepted steps kept in {folder}: {accepted}")
        sys.exit(NotConverged.exit_code)


def _solve_members(
    scene: AnyCase | None,
    folder: Path,
    choice: Mapping[str, Any],
    options: Mapping[str, Any],
    quiet: bool,
    verbose: bool,
) -> None:
    """Run members of a case, or without one those that are missing in a folder, and tell what they have in common."""
    ensemble = None
    try:
        from ngcell.ensemble import ensemble_of

        with silent_progress() if quiet else step_progress() as show:
            _log_to_stderr(logging.INFO if verbose else logging.WARNING)
            ensemble = ensemble_of(scene, folder, choice, options)
            pace = Pace(ensemble.case.level_factors, ensemble.choice.count)
            for number, record in ensemble:
                pace.accept(record, number)
                show(record, pace, f"member {number + 1} of {ensemble.choice.count}  ")
    except KeyboardInterrupt:
        _give_up_members("stopped by Ctrl-C", ensemble, folder)
    except NotConverged as error:
        _give_up_members(str(error), ensemble, folder)
    for line in members_lines(ensemble):
        click.echo(line)
    if not ensemble.certified:
        _give_up_members("not all members are certified", ensemble, folder)


def _task(
    case: str | None, overrides: tuple[str, ...], out: Path | None, resume: Path | None, *, suffix: str = ""
) -> tuple[AnyCase | None, Path, int]:
    """Return the case, None to resume a run, the result folder, and the number of steps accepted before."""
    if resume is not None:
        if case is not None or overrides or out is not None:
            raise click.UsageError("--resume DIR takes the case and the folder from DIR: no CASE, --set or --out")
        return None, resume, _accepted_before(resume)
    if case is None:
        raise click.UsageError("a CASE to solve, or --resume DIR, is missing")
    from ngcell.scene import case_name, find_case, read_case

    return read_case(case, overrides), out or Path("out") / f"{case_name(find_case(case))}{suffix}", 0


def _accepted_before(folder: Path) -> int:
    """Return the number of accepted steps of a stopped run; if it was not stopped, tell so and exit."""
    from ngcell.export.summary import accepted_steps, read_summary

    summary = read_summary(folder)
    if summary.get("status") == "finished":
        click.echo(f"nothing to resume: the run in {folder} has ended ({summary.get('outcome')})")
        sys.exit(0 if summary.get("certified") else NotConverged.exit_code)
    return accepted_steps(folder, summary)


def _collect_garbage_rarely() -> None:
    # Imports and pictures allocate many objects, and a step leaves only a few dozen in reference cycles: the collector
    # would take a tenth of a short run and free next to nothing.
    gc.set_threshold(1_000_000)
    atexit.register(gc.freeze)  # nor does it have to search at exit


def _log_to_stderr(level: int) -> None:
    logging.basicConfig(level=level, format="%(name)s: %(message)s", stream=sys.stderr)


def _give_up_members(reason: str, ensemble: Ensemble | None, folder: Path) -> NoReturn:
    ended = len(ensemble.members) if ensemble else 0
    note(f"{reason}; members that have ended, kept in {folder}: {ended}")
    sys.exit(NotConverged.exit_code)


def _give_up(reason: str, accepted: int, folder: Path, *, can_go_on: bool = False) -> NoReturn:
    from ngcell.export.ownership import holds_result

    kept = f"accepted steps kept in {folder}: {accepted}" if accepted else "no step was accepted"
    if not accepted and holds_result(folder):
        kept += f", and the earlier result in {folder} is as it was"
    if accepted:
        go_on = f"go on with: ngcell solve --resume {quote(str(folder))}; " if can_go_on else ""
        note(f"{go_on}see how far it got with: ngcell report {quote(str(folder))}")
    note(f"{reason}; {kept}")
    sys.exit(NotConverged.exit_code)
