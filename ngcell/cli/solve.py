"""`ngcell solve CASE`: follow the load path, show each accepted step, end with the verdict of the certificate."""

from __future__ import annotations

import atexit
import gc
import logging
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import click

from ngcell.cli.arguments import set_option
from ngcell.cli.progress import silent_progress, step_progress
from ngcell.cli.summary import summary_lines
from ngcell.errors import NotConverged

if TYPE_CHECKING:
    from ngcell.recording import Recording
    from ngcell.scene import AnyCase


@click.command()
@click.argument("case", required=False)
@set_option
@click.option("--out", type=click.Path(path_type=Path), help="Result folder; default out/<case name>.")
@click.option(
    "--resume",
    metavar="DIR",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Resume the run that stopped in DIR; takes no CASE.",
)
@click.option("--threads", type=click.IntRange(min=1), help="Number of threads; default one for each core.")
@click.option(
    "--verify-penalty", is_flag=True, help="Repeat the last level with a stiffer penalty and report what changes."
)
@click.option("--quiet", "-q", is_flag=True, help="Show no progress.")
@click.option("--verbose", "-v", is_flag=True, help="Show the log of the solver.")
def solve(
    case: str | None,
    overrides: tuple[str, ...],
    out: Path | None,
    resume: Path | None,
    threads: int | None,
    verify_penalty: bool,
    quiet: bool,
    verbose: bool,
) -> None:
    """Solve CASE, a TOML file or the name of a case that comes with ngcell.

    Results are written during the run: a run that is stopped keeps every step that it accepted, and --resume
    computes the rest.
    """
    _collect_garbage_rarely()
    scene, folder, accepted = _task(case, overrides, out, resume)
    try:
        from ngcell import run

        with silent_progress() if quiet else step_progress() as show:
            # The log is opened after the live line has replaced stderr; a handler made before would write across it.
            _log_to_stderr(logging.INFO if verbose else logging.WARNING)
            recording: Recording
            if scene is None:
                recording = run.resume(folder, threads=threads, verify_penalty=verify_penalty)
            else:
                recording = run.record(scene, folder, threads=threads, verify_penalty=verify_penalty)
            for record in recording:
                accepted = record.step + 1
                show(record)
    except KeyboardInterrupt:
        _give_up("stopped by Ctrl-C", accepted, folder)
    except NotConverged as error:
        _give_up(str(error), len(error.steps), folder)
    for line in summary_lines(recording, folder):
        click.echo(line)
    if not recording.certified:
        _give_up("not certified", accepted, folder)


def _task(
    case: str | None, overrides: tuple[str, ...], out: Path | None, resume: Path | None
) -> tuple[AnyCase | None, Path, int]:
    """Return the case, None to resume a run, the result folder, and the number of steps accepted before."""
    if resume is not None:
        if case is not None or overrides or out is not None:
            raise click.UsageError("--resume DIR takes the case and the folder from DIR: no CASE, --set or --out")
        return None, resume, _accepted_before(resume)
    if case is None:
        raise click.UsageError("a CASE to solve, or --resume DIR, is missing")
    from ngcell.scene import case_name, find_case, read_case

    return read_case(case, overrides), out or Path("out") / case_name(find_case(case)), 0


def _accepted_before(folder: Path) -> int:
    """Return the number of accepted steps of a stopped run; if it was not stopped, tell so and exit."""
    from ngcell.export.summary import read_summary

    summary = read_summary(folder)
    if summary.get("status") == "finished":
        click.echo(f"nothing to resume: the run in {folder} has ended ({summary.get('outcome')})")
        sys.exit(0 if summary.get("certified") else NotConverged.exit_code)
    return int(summary.get("accepted_steps") or 0)


def _collect_garbage_rarely() -> None:
    # Imports and pictures allocate many objects, and a step leaves only a few dozen in reference cycles: the collector
    # would take a tenth of a short run and free next to nothing.
    gc.set_threshold(1_000_000)
    atexit.register(gc.freeze)  # nor does it have to search at exit


def _log_to_stderr(level: int) -> None:
    logging.basicConfig(level=level, format="%(name)s: %(message)s", stream=sys.stderr)


def _give_up(reason: str, accepted: int, folder: Path) -> NoReturn:
    kept = f"accepted steps kept in {folder}: {accepted}" if accepted else "no step was accepted"
    click.echo(f"{reason}; {kept}", err=True)
    sys.exit(NotConverged.exit_code)
