"""What a sweep takes beside its runs: memory, and cores that wait.

python -m tools.studies sweeps rows --number 10000       many runs that do nothing: memory of driver and scheduler
python -m tools.studies sweeps cores wall-and-pressure   a study that really runs: share of the cores, and run again

Tables are kept in `tools/results/sweeps-*.csv`.
"""

from __future__ import annotations

import csv
import socket
import tempfile
import tomllib
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import click
import psutil

from ngcell.scene.study import Study
from ngcell.sweeps.options import SweepOptions
from ngcell.sweeps.sweep import Sweep
from ngcell.sweeps.task import Task
from tools.commands import described

RESULTS = Path(__file__).parents[1] / "results"
#: Samples of the memory along a sweep.
_SAMPLES = 20


def idle(task: Task) -> dict[str, Any]:
    """Return a result that follows from the case, at once."""
    wall = tomllib.loads(task.text)["tissue"]["wall"]
    levels = [{"load_factor": 1.0, "step": {"energy": wall**3, "certified": True}}]
    told = {"key": task.key, "outcome": "certified", "final": True, "detail": "", "levels": levels}
    return {**told, "attempts": task.attempt, "seconds": 0.01, "host": socket.gethostname()}


def memory_along(number: int, out: Path) -> list[dict[str, float]]:
    """Return the memory of this process, which holds the scheduler as well, along a sweep of so many idle runs [MiB].
    """
    drawn = {"kind": "random", "low": 0.05, "high": 0.2, "number": number}
    study = Study(case="shear-empty-3x3", set={"load.levels": 1}, axes={"tissue.wall": drawn}, outputs=["energy"])
    runs, process, started = Sweep(study, out, SweepOptions(function=idle)), psutil.Process(), perf_counter()
    rows: list[dict[str, float]] = []
    for ended in runs:
        if ended.done % max(1, number // _SAMPLES) == 0:
            mebibytes = process.memory_info().rss / 2**20
            rows.append({"done": ended.done, "memory_mib": mebibytes, "seconds": perf_counter() - started})
    mebibytes = process.memory_info().rss / 2**20
    rows.append({"done": runs.computed, "memory_mib": mebibytes, "seconds": perf_counter() - started})
    return rows


def use_of_cores(name: str, out: Path) -> dict[str, Any]:
    """Return how far a study keeps the cores of this machine busy.

    `cores_share` is the processor time of the runs over that of all cores; where other programs run, they take from
    it. `wanted_share` adds the time for which runs were ready and another program had the core: what runs would have
    used alone. `workers_share` is the time that workers had a run over the time that the sweep took, and
    `machine_share` what the system tells of all programs.
    """
    cores = psutil.cpu_count() or 1
    runs, before, started = Sweep(name, out), psutil.cpu_times(), perf_counter()
    found = [ended.result for ended in runs]
    clock, after = perf_counter() - started, psutil.cpu_times()
    used = _share(found, "processor_seconds", cores * clock)
    idle_time = after.idle - before.idle + getattr(after, "iowait", 0.0) - getattr(before, "iowait", 0.0)
    return {
        "study": name,
        "cases": len(runs.cases),
        "computed": runs.computed,
        "certified": runs.outcomes["certified"],
        "cores": cores,
        "seconds": round(clock, 2),
        "cores_share": used,
        "wanted_share": round(used + _share(found, "waited_seconds", cores * clock), 3),
        "workers_share": _share(found, "seconds", cores * clock),
        "machine_share": round(1 - idle_time / (cores * clock), 3),
    }


def _share(results: Sequence[dict[str, Any]], column: str, of: float) -> float:
    return round(sum(result.get(column) or 0.0 for result in results) / of, 3)


def _keep(name: str, rows: Sequence[dict[str, Any]]) -> None:
    with (RESULTS / name).open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    for row in rows:
        click.echo("  ".join(f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}"
                             for key, value in row.items()))  # fmt: skip


@described(__doc__)
@click.argument("what", type=click.Choice(["rows", "cores"]))
@click.argument("study", default="wall-and-pressure")
@click.option("--number", default=10_000, help="Number of idle runs.")
def command(what: str, study: str, number: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        if what == "rows":
            _keep("sweeps-rows.csv", memory_along(number, out))
        else:
            _keep("sweeps-cores.csv", [use_of_cores(study, out) for _ in range(2)])
