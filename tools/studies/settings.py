"""Run a named grid of settings of the shipped cases, and tabulate what comes out of it.

    python -m tools.studies settings --grid scenes-3x3 [--quick] [--timeout 300] [--only TEXT] [--limit N]

Each run is a process of its own, one after the other, `ngcell solve CASE --set ... --out FOLDER`; a row is read from
the files that it leaves. Rows are appended to `tools/results/GRID.csv` as they come, and a run that has its row there
is not repeated: delete a row, or the file, to have it again. The last column tells which sources made a row, so that a
table of several is seen to be one. At the end the rows are written as a Markdown table to `tools/results/GRID.md`.
Result folders and logs stay in `ngcell-settings` in the folder for temporary files, where the second tables find them:
of `steps` and `penalty`, how far energy, plate force, mean gap and the displacement of any point differ between the
runs, level by level; of `far`, the levels.

Columns are explained by `COLUMNS`, grids in `tools/studies/grids.py`; lengths are in sides, stresses in the unit of the
material's constants.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import click
import numpy as np
import pyvista

from ngcell import Case, read_case
from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.runs import Ended, ended, released_rows, solve_words, sources, summary_in
from tools.studies.grids import GRIDS, Setting

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


def run(setting: Setting, timeout: float) -> Ended:
    """Run a setting in a process of its own; its log stands beside its results."""
    setting.folder.mkdir(parents=True, exist_ok=True)
    for old in setting.folder.iterdir():
        old.unlink()
    words = solve_words(setting.case, setting.folder, (*setting.overrides, "accuracy=inf"))
    found = ended(*words, "--verbose", timeout=timeout)
    setting.log.write_text(found.out + found.err)
    return found


def row(setting: Setting, process: Ended, code: str) -> dict[str, Any]:
    """Return a row of the table."""
    case = read_case(setting.case, setting.overrides)
    assert isinstance(case, Case) and case.strategy is not None
    tissue = case.tissue
    last: dict[str, Any] = (released_rows(setting.folder) or [{}])[-1]
    summary = summary_in(setting.folder)
    phases = summary.get("seconds", {}).get("processor_by_phase", {})
    return {
        "settings": setting.label,
        "scene": f"{tissue.rows}x{tissue.cols} to {getattr(case.load, 'displacement', [0])[0]:g}",
        "strategy": case.strategy.kind,
        "wall": tissue.wall,
        "order": case.mesh.plain_order,
        "edges": tissue.density(case.mesh)[0],
        "radius": tissue.corner_radius,
        "levels": len(case.level_factors),
        "stiffness": case.contact.stiffness,
        "outcome": _outcome(process),
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
        "cpu": round(process.processor, 2),
        "cpu_aside": round(phases.get("imports", 0.0) + phases.get("pictures", 0.0), 2),
        "peak_mb": round(process.peak_mb),
        "why": "" if process.exit_code == 0 else _why(setting, summary),
        "code": code,
    }


def _outcome(process: Ended) -> str:
    if process.timed_out:
        return "timeout"
    return {0: "certified", 4: "not certified"}.get(process.exit_code, "crashed")


def _why(setting: Setting, summary: dict[str, Any]) -> str:
    """Return the failed checks with their worst values, or what the log says of the last proximal term, or last."""
    checks = summary.get("certificate", {})
    failed = [f"{name} {check['worst']:.2g}" for name, check in checks.items() if not check["passed"]]
    log = setting.log.read_text().splitlines()
    proximals = [line.partition(": ")[2] for line in log if "proximal term" in line]
    stopped = proximals[-1:] if proximals and "converged," not in proximals[-1] else []
    return "; ".join(failed + stopped) or (log[-1] if log else "no log")


def differences(settings: list[Setting]) -> Iterator[dict[str, Any]]:
    """Yield, for each case and level that several runs reached, how far they differ."""
    runs: dict[tuple[str, float], list[tuple[Setting, int, dict[str, str]]]] = defaultdict(list)
    for setting in settings:
        for number, step in enumerate(released_rows(setting.folder)):
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
    fields = [
        np.asarray(pyvista.read(setting.folder / f"tissue_{number:04d}.vtu").point_data["displacement"])
        for setting, number, _ in found
    ]
    return max(float(np.linalg.norm(field - fields[0], axis=1).max()) for field in fields[1:])


def markdown(rows: list[dict[str, Any]], title: str) -> str:
    """Return rows as a Markdown table under a title; numbers are cut to what tells them apart."""
    names = [name for name in rows[0] if name not in _CSV_ONLY]
    shown = [[str(line[name]) if name == "code" else _short(line[name]) for name in names] for line in rows]
    return f"## {title}\n\n{tables.markdown(names, shown)}\n"


def _short(value: Any) -> str:
    try:
        return f"{float(value):.6g}"
    except ValueError:
        return str(value).replace("|", "/")


def page(grid: str, settings: list[Setting], rows: list[dict[str, Any]]) -> str:
    """Return the tables of a grid, as Markdown."""
    parts = [markdown(rows, grid)]
    kept = [setting for setting in settings if released_rows(setting.folder)]
    if grid in ("steps", "penalty") and (spread := list(differences(kept))):
        parts.append(markdown(spread, "Relative spread between the runs, and largest difference in displacement"))
    if grid == "far":
        parts += [markdown(released_rows(setting.folder), setting.label) for setting in kept]
    return "\n".join(parts)


@described(__doc__)
@click.option("--grid", type=click.Choice(sorted(GRIDS)), required=True, help="Which settings.")
@click.option("--quick", is_flag=True, help="A few of them only.")
@click.option("--timeout", default=300.0, show_default=True, help="Seconds on the clock for one run.")
@click.option("--only", default="", help="Run the settings whose key contains this text.")
@click.option("--limit", default=1000, help="Stop after so many new runs.")
def command(grid: str, quick: bool, timeout: float, only: str, limit: int) -> None:
    """Run what has no row yet, and tabulate."""
    table = RESULTS / f"{grid}.csv"
    settings = list(GRIDS[grid](quick))
    done = {line["settings"]: line for line in tables.read(table)}
    todo = [setting for setting in settings if setting.label not in done and only in setting.label]
    for setting in todo[:limit]:
        code = sources()
        line = row(setting, run(setting, timeout), code)
        tables.append(table, list(COLUMNS), [line])
        click.echo(f"{line['outcome']:14s}{line['cpu']:8.1f} s  {setting.label}  {line['why']}", err=True)
    done = {line["settings"]: line for line in tables.read(table)}
    rows = [done[setting.label] for setting in settings if setting.label in done]
    if rows:
        (RESULTS / f"{grid}.md").write_text(page(grid, settings, rows))
