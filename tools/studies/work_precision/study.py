"""Error against run time: one runner for exact problems, tissues, strategies and peers.

    python -m tools.studies work-precision --quick                 under five minutes
    python -m tools.studies work-precision [--jobs 2] [--peers]    all settings

Each run is a process of its own. Its row is appended to `tools/results/study.csv`, and a run that has its row there,
made by the same sources of the package, is not repeated, so that a study that was stopped goes on. At the end
`tools/results/study.md` (`study-quick.md`) tells errors, rates, costs and what follows, and `docs/study-*.png` shows
them; figures are left alone by `--quick`. Only rows of the same sources are compared.
"""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from tools import tables
from tools.commands import described
from tools.places import DOCS, RESULTS
from tools.runs import commit, ended, sources
from tools.studies.work_precision import peers
from tools.studies.work_precision.grid import Setting, grid
from tools.studies.work_precision.report import report
from tools.studies.work_precision.solve import solved

MOST_JOBS = 2
COLUMNS = (
    *("run", "kind", "problem", "case", "method", "order", "size", "strategy", "steps", "outcome"),
    *("error_gap", "error_pressure", "error_force", "gap", "pressure", "force", "energy", "parted"),
    *("unknowns", "iterations", "factorisations", "wall_seconds", "seconds", "phases", "peak_mb", "certified"),
    *("code", "commit"),
)


def row(setting: Setting, timeout: float) -> dict[str, Any]:
    """Run in a process of its own and return the row."""
    line = {**setting.row(), "code": sources(), "commit": commit()}
    run = ended("tools.studies", "work-precision", "--one", json.dumps(asdict(setting)), timeout=timeout)
    line["peak_mb"], line["wall_seconds"] = round(run.peak_mb), round(run.clock, 2)
    if run.timed_out:
        return {**line, "outcome": "timeout"}
    if run.exit_code:
        return {**line, "outcome": run.last_words("no log")[:120]}
    return {**line, "outcome": "converged", **json.loads(run.out.splitlines()[-1])}


def rows_in(table: Path, code: str) -> dict[str, dict[str, Any]]:
    """Return the rows that these sources made, by key."""
    return {line["run"]: line for line in tables.read(table) if line["code"] == code}


def solved_here(setting: Setting) -> dict[str, Any]:
    """Solve a setting in this process."""
    return peers.SOLVERS.get(setting.kind, solved)(setting)


@described(__doc__)
@click.option("--quick", is_flag=True, help="Few settings, no figures.")
@click.option("--jobs", default=1, show_default=True, type=click.IntRange(1, MOST_JOBS), help="Processes at a time.")
@click.option("--timeout", default=600.0, show_default=True, help="Seconds on the clock for one run.")
@click.option("--only", default="", help="Take the runs whose key contains this text.")
@click.option("--peers", "with_peers", is_flag=True, help="Run other programs on the same scenes, too.")
@click.option("--report-only", is_flag=True, help="Write tables and figures of the rows that are there.")
@click.option("--code", help="Compare the rows of these sources; by default those that are here.")
@click.option("--one", hidden=True, help="Solve this setting here and print what was found.")
def command(
    quick: bool,
    jobs: int,
    timeout: float,
    only: str,
    with_peers: bool,
    report_only: bool,
    code: str | None,
    one: str | None,
) -> None:
    """Run what has no row yet, and report."""
    if one is not None:
        click.echo(json.dumps(solved_here(Setting(**json.loads(one)))))
        return
    table, code = RESULTS / "study.csv", code or sources()
    settings = list(grid(quick))
    if with_peers:
        settings += [setting for setting in peers.settings(quick) if peers.available(setting)]
        for name in peers.missing():
            click.echo(name, err=True)
    done = rows_in(table, code)
    todo = [setting for setting in settings if setting.label not in done and only in setting.label]
    if not report_only:
        with ThreadPoolExecutor(jobs) as pool:
            for line in pool.map(lambda setting: row(setting, timeout), todo):
                tables.append(table, COLUMNS, [line])
                click.echo(f"{line.get('seconds', ''):>8} s  {line['run']}  {line['outcome']}", err=True)
    done = rows_in(table, code)
    every = [*grid(quick), *peers.settings(quick)]
    rows = [done[setting.label] for setting in every if setting.label in done]
    report(rows, len(every), RESULTS / ("study-quick.md" if quick else "study.md"), None if quick else DOCS)
