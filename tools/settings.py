"""Run a named grid of settings of the shipped cases, and tabulate what comes out of it.

    python tools/settings.py --grid scenes [--quick] [--timeout 300] [--only TEXT] [--limit N]

Each run is a process of its own, one after the other, `python -m ngcell solve CASE --set ... --out FOLDER`; a row
is read from the files that it leaves. Rows are appended to `tools/results/GRID.csv` as they come, and a run that
has its row there is not repeated: delete a row, or the file, to have it again. The last column tells which sources
made a row, so that a table of several is seen to be one. At the end the rows are written as a
Markdown table to `tools/results/GRID.md`. Result folders and logs stay in
`ngcell-settings` in the folder for temporary files, where the second tables find them.

Grids:

scenes-3x3, scenes-5x7
    Strategy, wall, edges to a side, order and corner radius: all of them together, or one at a time.
steps
    Both strategies with different numbers of levels. A second table tells, level by level, how far energy, plate
    force, mean gap and the displacement of any point differ between them.
penalty
    The contact's stiffness, with the same second table.
far
    The plates moved by half of the tissue's height, with a table of the levels.

Columns are explained by `COLUMNS`; lengths are in sides, stresses in the unit of the material's constants.
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import Any

import click

ROOT = Path(__file__).resolve().parent.parent
RESULTS, RUNS = ROOT / "tools" / "results", Path(tempfile.gettempdir()) / "ngcell-settings"

COLUMNS = {
    "settings": "case and overrides; the key of the row",
    "scene": "rows x columns, plate displacement",
    "strategy": "sddp or single-step",
    "wall": "wall thickness",
    "order": "polynomial order",
    "edges": "element edges to a side",
    "radius": "corner radius",
    "levels": "number of reported levels",
    "stiffness": "multiple of the derived contact stiffness",
    "outcome": "certified, not certified, failed, timeout or crashed",
    "certified": "whether every step passed every check",
    "energy": "stored energy of the last step with contact",
    "force_x": "its plate force along x",
    "mean_gap": "its mean gap",
    "largest_gap": "its largest gap",
    "parted": "its parted pairs of walls",
    "reached": "its load factor",
    "iterations": "Newton iterations of the whole run",
    "factorisations": "factorisations of the whole run",
    "unknowns": "displacement unknowns",
    "cpu": "processor seconds of the process",
    "cpu_aside": "of these, imports and pictures",
    "peak_mb": "largest resident memory [MB]",
    "why": "failed checks, or where the run stopped",
    "code": "digest of the sources of the package that ran",
}
#: Columns that a Markdown table leaves out, for width.
_CSV_ONLY = {"settings", "certified"}


@dataclass(frozen=True)
class Setting:
    """A shipped case and what is set in it.

    Attributes
    ----------
    case : str
        Name of the case.
    overrides : tuple of str
        Each ``key=value``.
    """

    case: str
    overrides: tuple[str, ...]

    @property
    def label(self) -> str:
        """The row's key."""
        return " ".join((self.case, *self.overrides))

    @property
    def folder(self) -> Path:
        """Where its results are kept."""
        name = "".join(letter if letter.isalnum() or letter in ".=-" else "_" for letter in self.label)
        return RUNS / name


def default_edges(wall: float) -> int:
    """Return the default number of edges to a side of length 1."""
    from ngcell import MeshChoice, Tissue

    return Tissue(rows=1, cols=1, wall=wall).density(MeshChoice())[0]


def _scene(
    case: str, strategy: str, wall: float, finer: int, order: int, radius: float, levels: str = "[1.0]"
) -> Setting:
    size = () if finer == 1 else (f"mesh.size={1 / (finer * default_edges(wall)):.6g}",)
    return Setting(
        case,
        (
            f"load.levels={levels}",
            f'strategy.kind="{strategy}"',
            f"tissue.wall={wall}",
            f"mesh.order={order}",
            f"tissue.corner_radius={radius}",
            *size,
        ),
    )


def scenes_3x3(quick: bool) -> Iterator[Setting]:
    """All settings together; the finest of them at sharp corners only."""
    walls, orders = ((0.1,), (2, 3)) if quick else ((0.05, 0.1, 0.2), (1, 2, 3, 4))
    for radius, finer, order, wall, strategy in product((0.0, 0.1), (1, 2), orders, walls, ("sddp", "single-step")):
        if not (radius and finer == 2 and order > 2):
            yield _scene("shear-empty-3x3", strategy, wall, finer, order, radius)


def scenes_5x7(quick: bool) -> Iterator[Setting]:
    """Both strategies, then one setting changed at a time."""
    usual = {"strategy": "sddp", "wall": 0.1, "finer": 1, "order": 3, "radius": 0.0}
    changes: list[dict[str, Any]] = [{}, {"strategy": "single-step"}]
    if not quick:
        changes += [{"wall": 0.05}, {"wall": 0.2}, {"finer": 2}, {"order": 1}, {"order": 2}, {"radius": 0.1}]
    for change in changes:
        yield _scene("shear-empty", **{**usual, **change})


def steps(quick: bool) -> Iterator[Setting]:
    """Both strategies with more and more levels."""
    cases = {"shear-empty-3x3": (5, 10, 20)} if quick else {"shear-empty-3x3": (5, 10, 20), "shear-empty": (5, 10)}
    for case, counts in cases.items():
        for count, strategy in product(counts, ("sddp", "single-step")):
            yield Setting(case, (f"load.levels={count}", f'strategy.kind="{strategy}"'))


def penalty(quick: bool) -> Iterator[Setting]:
    """The contact's stiffness."""
    for multiple in (0.3, 1.0, 3.0) if quick else (0.1, 0.3, 1.0, 3.0, 10.0, 30.0):
        yield Setting("shear-empty-3x3", ("load.levels=[1.0]", f"contact.stiffness={multiple}"))


def far(quick: bool) -> Iterator[Setting]:
    """Half of the tissue's height."""
    if quick:
        yield Setting("shear-empty-3x3", ("load.displacement=[2.5,0.0]", "load.levels=5"))
    else:
        yield Setting("shear-empty", ("load.displacement=[4.0,0.0]", "load.levels=10"))


GRIDS = {
    "scenes-3x3": scenes_3x3, "scenes-5x7": scenes_5x7, "steps": steps, "penalty": penalty, "far": far,
}  # fmt: skip


@dataclass(frozen=True)
class Ended:
    """How a process ended.

    Attributes
    ----------
    exit_code : int
        Its exit code; negative if a signal ended it.
    cpu, peak_mb : float
        Processor seconds, and largest resident memory [MB].
    timed_out : bool
        Whether time ran out.
    sources : str
        Digest of the package's sources when it started.
    """

    exit_code: int
    cpu: float
    peak_mb: float
    timed_out: bool
    sources: str


def sources() -> str:
    """Return a digest of the sources of the package that is installed."""
    package = Path(find_spec("ngcell").submodule_search_locations[0])
    digest = sha256()
    for path in sorted(package.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:8]


def run(setting: Setting, timeout: float) -> Ended:
    """Run a setting in a process of its own; its log is `log.txt` beside its results."""
    version = sources()
    setting.folder.mkdir(parents=True, exist_ok=True)
    for old in setting.folder.iterdir():
        old.unlink()
    arguments = [argument for override in setting.overrides for argument in ("--set", override)]
    with (setting.folder.parent / f"{setting.folder.name}.log").open("w") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "ngcell", "solve", setting.case, *arguments]
            + ["--out", str(setting.folder), "--verbose", "--threads", "1"],
            stdout=log,
            stderr=log,
            cwd=RUNS,  # not here, where `-m` would find this working copy instead of what is installed
        )
        timer = threading.Timer(timeout, process.kill)
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        timed_out = not timer.is_alive()
        timer.cancel()
    process.returncode = os.waitstatus_to_exitcode(status)
    cpu = usage.ru_utime + usage.ru_stime
    return Ended(process.returncode, cpu, usage.ru_maxrss / 1024, timed_out, version)


def row(setting: Setting, ended: Ended) -> dict[str, Any]:
    """Return a row of the table."""
    from ngcell import read_case
    from ngcell.scene import find_case

    case = read_case(find_case(setting.case), setting.overrides)
    tissue = case.tissue
    contact = [step for step in history(setting) if step["phase"] == "contact"]
    last: dict[str, Any] = contact[-1] if contact else {}
    summary = _summary(setting)
    phases = summary.get("seconds", {}).get("processor_by_phase", {})
    return {
        "settings": setting.label,
        "scene": f"{tissue.rows}x{tissue.cols} to {getattr(case.load, 'displacement', [0])[0]:g}",
        "strategy": case.strategy.kind,
        "wall": tissue.wall,
        "order": case.mesh.order,
        "edges": tissue.density(case.mesh)[0],
        "radius": tissue.corner_radius,
        "levels": len(case.level_factors),
        "stiffness": case.contact.stiffness,
        "outcome": _outcome(ended),
        "certified": summary.get("certified", False),
        "energy": last.get("energy", ""),
        "force_x": last.get("plate_force_x", ""),
        "mean_gap": last.get("mean_gap", ""),
        "largest_gap": last.get("largest_gap", ""),
        "parted": last.get("parted_pairs", ""),
        "reached": last.get("load_factor", ""),
        "iterations": summary.get("iterations", ""),
        "factorisations": summary.get("factorisations", ""),
        "unknowns": summary.get("unknowns", ""),
        "cpu": round(ended.cpu, 2),
        "cpu_aside": round(phases.get("imports", 0.0) + phases.get("pictures", 0.0), 2),
        "peak_mb": round(ended.peak_mb),
        "why": "" if ended.exit_code == 0 else _why(setting, summary),
        "code": ended.sources,
    }


def history(setting: Setting) -> list[dict[str, str]]:
    """Return the rows of its `history.csv`, those of a run that was stopped included."""
    path = setting.folder / "history.csv"
    return list(csv.DictReader(path.open())) if path.exists() else []


def _summary(setting: Setting) -> dict[str, Any]:
    path = setting.folder / "summary.json"
    return json.loads(path.read_text()) if path.exists() else {}


def _outcome(ended: Ended) -> str:
    if ended.timed_out:
        return "timeout"
    return {0: "certified", 4: "not certified"}.get(ended.exit_code, "crashed")


def _why(setting: Setting, summary: dict[str, Any]) -> str:
    """Return the failed checks with their worst values, or the last proximal term on the path, or the last line of the log."""
    checks = summary.get("certificate", {})
    failed = [f"{name} {check['worst']:.2g}" for name, check in checks.items() if not check["passed"]]
    log = (setting.folder.parent / f"{setting.folder.name}.log").read_text().splitlines()
    proximals = [line.partition(": ")[2] for line in log if "proximal term" in line]
    stopped = proximals[-1:] if proximals and "converged," not in proximals[-1] else []
    return "; ".join(failed + stopped) or (log[-1] if log else "no log")


def differences(settings: list[Setting]) -> Iterator[dict[str, Any]]:
    """Yield, for each case and level that several runs reached, how far they differ."""
    runs: dict[tuple[str, float], list[tuple[Setting, int, dict[str, str]]]] = defaultdict(list)
    for setting in settings:
        contact = [step for step in history(setting) if step["phase"] == "contact"]
        for number, step in enumerate(contact):
            runs[setting.case, round(float(step["load_factor"]), 9)].append((setting, number, step))
    for (case, level), found in sorted(runs.items()):
        if len(found) > 1:
            spread = {name: _spread(step[name] for *_, step in found) for name in _COMPARED}
            yield {
                "case": case,
                "level": level,
                "runs": len(found),
                **spread,
                "displacement": _farthest(found),
            }


#: Quantities of which the relative spread is given.
_COMPARED = ("energy", "plate_force_x", "mean_gap", "largest_gap")


def _spread(values: Iterator[str]) -> float:
    numbers = [float(value) for value in values]
    return (max(numbers) - min(numbers)) / max(max(map(abs, numbers)), sys.float_info.min)


def _farthest(found: list[tuple[Setting, int, dict[str, str]]]) -> float:
    """Return the largest difference in displacement of any point between the first run and another."""
    import numpy as np
    import pyvista

    fields = [
        np.asarray(pyvista.read(setting.folder / f"tissue_{number:04d}.vtu").point_data["displacement"])
        for setting, number, _ in found
    ]
    return max(float(np.linalg.norm(field - fields[0], axis=1).max()) for field in fields[1:])


def markdown(rows: list[dict[str, Any]], title: str) -> str:
    """Return rows as a Markdown table; numbers are cut to what tells them apart."""
    names = [name for name in rows[0] if name not in _CSV_ONLY]
    lines = ["| " + " | ".join(names) + " |", "|" + "---|" * len(names)]
    shown = ((str(line[name]) if name == "code" else _short(line[name]) for name in names) for line in rows)
    lines += ["| " + " | ".join(entries) + " |" for entries in shown]
    return "\n".join((f"## {title}", "", *lines, ""))


def _short(value: Any) -> str:
    try:
        return f"{float(value):.6g}"
    except ValueError:
        return str(value).replace("|", "/")


def _rows(path: Path) -> dict[str, dict[str, Any]]:
    return {line["settings"]: line for line in csv.DictReader(path.open())} if path.exists() else {}


def _append(path: Path, line: dict[str, Any]) -> None:
    is_new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, list(COLUMNS), lineterminator="\n")
        if is_new:
            writer.writeheader()
        writer.writerow(line)


def _tables(grid: str, settings: list[Setting], rows: list[dict[str, Any]]) -> str:
    tables = [markdown(rows, grid)]
    kept = [setting for setting in settings if setting.folder.exists()]
    if grid in ("steps", "penalty") and (spread := list(differences(kept))):
        tables.append(markdown(spread, "Relative spread between the runs, and largest difference in displacement"))
    if grid == "far":
        tables += [markdown(history(setting), setting.label) for setting in kept if history(setting)]
    return "\n".join(tables)


@click.command(help=__doc__.split("\n")[0])
@click.option("--grid", type=click.Choice(sorted(GRIDS)), required=True, help="Which settings.")
@click.option("--quick", is_flag=True, help="A few of them only.")
@click.option("--timeout", default=300.0, show_default=True, help="Seconds on the clock for one run.")
@click.option("--only", default="", help="Run the settings whose key contains this text.")
@click.option("--limit", default=1000, help="Stop after so many new runs.")
def main(grid: str, quick: bool, timeout: float, only: str, limit: int) -> None:
    RESULTS.mkdir(parents=True, exist_ok=True)
    table = RESULTS / f"{grid}.csv"
    settings = list(GRIDS[grid](quick))
    done = _rows(table)
    todo = [setting for setting in settings if setting.label not in done and only in setting.label]
    for setting in todo[:limit]:
        line = row(setting, run(setting, timeout))
        _append(table, line)
        click.echo(f"{line['outcome']:14s}{line['cpu']:8.1f} s  {setting.label}  {line['why']}", err=True)
    done = _rows(table)
    rows = [done[setting.label] for setting in settings if setting.label in done]
    if rows:
        (RESULTS / f"{grid}.md").write_text(_tables(grid, settings, rows))


if __name__ == "__main__":
    main()
