"""`ngcell sweep STUDY`: run what is missing of a study, into one table."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ngcell.cli.arguments import finite, study_names
from ngcell.cli.interrupts import remembered_interrupts
from ngcell.cli.pace import duration
from ngcell.cli.streams import note
from ngcell.cli.sweep_progress import silent, sweep_progress
from ngcell.errors import NotConverged

if TYPE_CHECKING:
    from ngcell.sweeps.foresee import Outlook
    from ngcell.sweeps.sweep import Sweep


@click.command(short_help="Run a case along axes into one table.")
@click.argument("study", type=click.Path(path_type=Path), shell_complete=study_names)
@click.option("--out", type=click.Path(path_type=Path), help="Folder of the table; default out/<study name>.")
@click.option(
    "--store",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of results, which sweeps may share; default `store` in the folder of the table.",
)
@click.option("--scheduler", metavar="ADDRESS", help="Use the Dask cluster of this scheduler, as tcp://host:8786.")
@click.option("--workers", metavar="N", type=click.IntRange(min=1), help="Processes here; default one for each core.")
@click.option(
    "--memory",
    metavar="GIB",
    type=click.FloatRange(min=0, min_open=True),
    callback=finite,
    help="Memory that one run may take; a run that needs more ends as out-of-memory.",
)
@click.option(
    "--wait",
    metavar="MINUTES",
    type=click.FloatRange(min=0, min_open=True),
    callback=finite,
    default=60,
    show_default=True,
    help="End the sweep where the cluster has had no worker for so long.",
)
@click.option(
    "--pictures",
    metavar="N",
    type=click.IntRange(min=0),
    default=24,
    show_default=True,
    help="Cases, spread over the study, that get a small picture of their tissue.",
)
@click.option("--dry-run", is_flag=True, help="Tell cases, unknowns, memory and hours, and run nothing.")
@click.option("--quiet", "-q", is_flag=True, help="Show no progress.")
def sweep(
    study: Path,
    out: Path | None,
    store: Path | None,
    scheduler: str | None,
    workers: int | None,
    memory: float | None,
    wait: float,
    pictures: int,
    dry_run: bool,
    quiet: bool,
) -> None:
    """Run the cases of STUDY, a TOML file, that have no result yet, and write one table of all of them.

    The folder gets sweep.parquet and sweep.csv, a row for each run and level. Runs that fail are rows with their
    outcome. A sweep that was stopped, or killed, goes on where it was when it is started again.
    """
    from ngcell.sweeps.options import SweepOptions
    from ngcell.sweeps.sweep import Sweep

    if scheduler is not None and workers is not None:
        raise click.UsageError("--workers is for the cluster that is started here: not together with --scheduler")
    folder = out or Path("out") / study.stem
    runs = Sweep(study, folder, SweepOptions(store, scheduler, workers, memory, pictures=pictures, wait=wait))
    if dry_run:
        for line in outlook_lines(runs.outlook(), workers):
            click.echo(line)
        return
    try:
        with silent() if quiet else sweep_progress() as show, remembered_interrupts() as check:
            for ended in runs:
                show(ended)
                check()
    except KeyboardInterrupt:
        counted = f"{sum(runs.outcomes.values())} of {len(runs.cases)}"
        note(f"stopped by Ctrl-C; {counted} cases have ended, kept in {folder}; start again for the rest")
        sys.exit(NotConverged.exit_code)
    for line in summary_lines(runs):
        click.echo(line)
    if not runs.certified:
        note(f"not all runs are certified; {runs.out / 'sweep.csv'} tells of each how it ended")
        sys.exit(NotConverged.exit_code)


def outlook_lines(outlook: Outlook, workers: int | None) -> Iterator[str]:
    """Yield what is foreseen of a study."""
    from ngcell.sweeps.driver import workers_here

    cores = workers_here(workers)
    few, many = outlook.unknowns
    yield f"cases        {outlook.cases}, of which {outlook.missing} have to be run"
    if outlook.refused:
        yield f"refused      {outlook.refused}: their values make no case"
    if many:
        yield f"unknowns     {few:.0f} to {many:.0f} on the mesh that most runs end on"
    yield f"memory       {outlook.memory:.2g} GiB a run, {outlook.memory * cores:.2g} GiB for {cores} at a time"
    told = f"{duration(3600 * outlook.hours(cores))} on {cores} workers here"
    others = ", ".join(f"{duration(3600 * outlook.hours(count))} on {count}" for count in (8, 32, 128))
    yield f"time         {told}; {others}"
    if outlook.measured:
        yield f"             from {outlook.measured} runs of this study in the store"
    else:
        yield "             from sheared tissues of 9 and 35 cells; for other scenes within a factor of three"


def summary_lines(runs: Sweep) -> Iterator[str]:
    """Yield the lines that the terminal shows at the end."""
    ways = ", ".join(f"{count} {outcome}" for outcome, count in sorted(runs.outcomes.items()))
    yield f"cases        {len(runs.cases)}: {ways}"
    yield f"run          {runs.computed} now, {runs.reused} were in the store"
    yield f"table        {runs.out / 'sweep.parquet'}, sweep.csv"
