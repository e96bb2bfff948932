"""Run the study of error against run time, and write its tables and figures.

    python -m tools.study --quick                 under five minutes
    python -m tools.study [--jobs 2] [--peers]    all settings

Each run is a process of its own. Its row is appended to `tools/results/study.csv`, and a run that has its row there,
made by the same sources of the package, is not repeated, so that a study that was stopped goes on. At the end
`tools/results/study.md` (`study-quick.md`) tells errors, rates, costs and what follows, and `docs/study-*.png` shows
them; figures are left alone by `--quick`. Only rows of the same sources are compared.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from time import perf_counter
from typing import Any

import click

from tools import tables
from tools.settings import sources
from tools.study import peers
from tools.study.grid import Setting, grid
from tools.study.report import report

ROOT = Path(__file__).resolve().parent.parent.parent
RESULTS, DOCS = ROOT / "tools" / "results", ROOT / "docs"
MOST_JOBS = 2
COLUMNS = (
    *("run", "kind", "problem", "case", "method", "order", "size", "strategy", "steps", "outcome"),
    *("error_gap", "error_pressure", "error_force", "gap", "pressure", "force", "energy", "parted"),
    *("unknowns", "iterations", "factorisations", "wall_seconds", "seconds", "phases", "peak_mb", "certified"),
    *("code", "commit"),
)


def commit() -> str:
    """Return the commit that is checked out, with a mark where files differ from it."""
    called = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return called.stdout.strip()


def row(setting: Setting, timeout: float) -> dict[str, Any]:
    """Run in a process of its own and return the row."""
    line = {**setting.row(), "code": sources(), "commit": commit()}
    command = [sys.executable, "-m", "tools.study", "--one", json.dumps(asdict(setting))]
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        started = perf_counter()
        here = {**os.environ, "PYTHONPATH": str(ROOT)}
        process = subprocess.Popen(command, cwd=ROOT, stdout=out, stderr=err, env=here)
        timer = threading.Timer(timeout, process.kill)
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        ran_out = not timer.is_alive()
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        line["peak_mb"], line["wall_seconds"] = round(usage.ru_maxrss / 1024), round(perf_counter() - started, 2)
        if ran_out:
            return {**line, "outcome": "timeout"}
        if process.returncode:
            return {**line, "outcome": (err.read().strip().splitlines() or ["no log"])[-1][:120]}
        return {**line, "outcome": "converged", **json.loads(out.read().splitlines()[-1])}


def rows_in(table: Path, code: str) -> dict[str, dict[str, Any]]:
    """Return the rows that these sources made, by key."""
    return {line["run"]: line for line in tables.read(table) if line["code"] == code}


@click.command(help=__doc__.split("\n")[0])
@click.option("--quick", is_flag=True, help="Few settings, no figures.")
@click.option("--jobs", default=1, show_default=True, type=click.IntRange(1, MOST_JOBS), help="Processes at a time.")
@click.option("--timeout", default=600.0, show_default=True, help="Seconds on the clock for one run.")
@click.option("--only", default="", help="Take the runs whose key contains this text.")
@click.option("--peers", "with_peers", is_flag=True, help="Run other programs on the same scenes, too.")
@click.option("--report-only", is_flag=True, help="Write tables and figures of the rows that are there.")
@click.option("--code", help="Compare the rows of these sources; by default those that are here.")
@click.option("--one", hidden=True, help="Solve this setting here and print what was found.")
def main(
    quick: bool,
    jobs: int,
    timeout: float,
    only: str,
    with_peers: bool,
    report_only: bool,
    code: str | None,
    one: str | None,
) -> None:
    if one is not None:
        click.echo(json.dumps(solved_here(Setting(**json.loads(one)))))
        return
    RESULTS.mkdir(parents=True, exist_ok=True)
    table, code = RESULTS / "study.csv", code or sources()
    settings = list(grid(quick))
    if with_peers:
        settings += [setting for setting in peers.settings(quick) if peers.available(setting)]
        for line in peers.missing():
            click.echo(line, err=True)
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


def solved_here(setting: Setting) -> dict[str, Any]:
    """Solve a setting in this process."""
    if setting.kind in peers.SOLVERS:
        return peers.SOLVERS[setting.kind](setting)
    from tools.study.solve import solved

    return solved(setting)


if __name__ == "__main__":
    main()
