"""`ngcell solve CASE`: walk the load path, show the steps, end with a verdict."""

from __future__ import annotations

import atexit
import gc
import logging
import sys
from pathlib import Path
from typing import NoReturn

import click

from ngcell.cli.arguments import case_argument, set_option
from ngcell.cli.progress import silent_progress, step_progress
from ngcell.cli.summary import summary_lines
from ngcell.errors import NotConverged


@click.command()
@case_argument
@set_option
@click.option("--out", type=click.Path(path_type=Path), help="Result folder; default out/<case name>.")
@click.option("--threads", type=click.IntRange(min=1), help="Number of threads; default one for each core.")
@click.option(
    "--verify-penalty", is_flag=True, help="Repeat the last level with a stiffer penalty; report what moves."
)
@click.option("--quiet", "-q", is_flag=True, help="Show no progress.")
@click.option("--verbose", "-v", is_flag=True, help="Show what the solver logs.")
def solve(
    case: str,
    overrides: tuple[str, ...],
    out: Path | None,
    threads: int | None,
    verify_penalty: bool,
    quiet: bool,
    verbose: bool,
) -> None:
    """Solve CASE, a TOML file or the name of a case that comes with ngcell.

    The results are written as the run goes; a run that is stopped keeps every step that it accepted.
    """
    _look_rarely_for_cycles()
    from ngcell.scene import case_name, find_case, read_case

    scene = read_case(case, overrides)
    folder = out or Path("out") / case_name(find_case(case))
    accepted = 0
    try:
        from ngcell import run

        with silent_progress() if quiet else step_progress() as show:
            # After the live line has taken over stderr: a log handler made before would write across it.
            _log_to_stderr(logging.INFO if verbose else logging.WARNING)
            recording = run.record(scene, folder, threads=threads, verify_penalty=verify_penalty)
            for record in recording:
                accepted += 1
                show(record)
    except KeyboardInterrupt:
        _give_up("stopped by Ctrl-C", accepted, folder)
    except NotConverged as error:
        _give_up(str(error), error.record_count, folder)
    for line in summary_lines(recording, folder):
        click.echo(line)
    if not recording.certified:
        _give_up("not certified", accepted, folder)


def _look_rarely_for_cycles() -> None:
    # Imports and pictures make many objects and hardly any cycles: looking for them takes a tenth of a short run.
    gc.set_threshold(50_000)
    atexit.register(gc.freeze)  # and none need to be found at the end


def _log_to_stderr(level: int) -> None:
    logging.basicConfig(level=level, format="%(name)s: %(message)s", stream=sys.stderr)


def _give_up(reason: str, accepted: int, folder: Path) -> NoReturn:
    kept = f"accepted steps kept in {folder}: {accepted}" if accepted else "no step was accepted"
    click.echo(f"{reason}; {kept}", err=True)
    sys.exit(NotConverged.exit_code)
