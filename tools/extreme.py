"""What happens far outside comfort: each scene of `tools.extreme_points` in a process of its own, and what came of it.

    python -m tools.extreme --quick               some forty points, in about five minutes
    python -m tools.extreme [--timeout 120]       all of them, and the perturbed ones

A point ends as one of three:

certified
    The run passed its certificate and, where an exact answer exists, comes within `WRONG` of it.
named
    The run says that it did not reach an answer that it stands for, and why, or the time it was given ran out;
    everything accepted is on disk.
WRONG
    Anything else: an answer that looks right and is not, a number that is none, a traceback.

Rows are kept in `tools/results/extreme.csv`; a point that has its row there, made by the same sources of the package,
is not repeated, so that a run that was stopped goes on. At the end `extreme.md` beside it tells what came of every
point, and `docs/extreme.png` shows it; `--quick` writes to `extreme-quick.csv` and `.md`, and no figure.
"""

from __future__ import annotations

import csv
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import click
import tomli_w

from tools.extreme_points import Point, points
from tools.settings import sources

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "tools" / "results"
RUNS = Path(tempfile.gettempdir()) / "ngcell-extreme"

CERTIFIED, NAMED, WRONG = "certified", "named", "WRONG"
#: Columns of `history.csv` that are compared between points that must agree, with their powers of length and stress.
COMPARED = {
    "energy": (2, 1),
    "plate_force_x": (1, 1),
    "contact_force": (1, 1),
    "mean_gap": (1, 0),
    "largest_gap": (1, 0),
}
#: Largest difference that counts as agreement, in units of the compared number and at least of a thousandth of a side.
AGREEMENT = 1e-8


@dataclass
class Row:
    """What came of a point."""

    label: str
    group: str
    setting: str
    has_solution: bool
    perturbed: str
    outcome: str
    cause: str = ""
    steps: int = 0
    iterations: int = 0
    refused: int = 0
    cut_backs: int = 0
    smallest_jacobian: float = math.nan
    condition: float = math.nan
    penetration: float = math.nan
    error: float = math.nan
    seconds: float = math.nan
    energy: float = math.nan
    plate_force_x: float = math.nan
    contact_force: float = math.nan
    mean_gap: float = math.nan
    largest_gap: float = math.nan
    code: str = ""


def solve(point: Point, timeout: float, code: str) -> Row:
    """Run a point and return its row."""
    folder = RUNS / "".join(letter if letter.isalnum() or letter in "+-" else "_" for letter in point.label)
    folder.parent.mkdir(exist_ok=True)
    case = folder.parent / f"{folder.name}.toml"
    case.write_text(tomli_w.dumps(point.case))
    command = [sys.executable, "-m", "tools.extreme_run", str(case), str(folder), "--tolerance", f"{point.tolerance:g}"]
    row = Row(point.label, point.group, point.setting, point.has_solution, point.perturbed_from, WRONG, code=code)
    here = {**os.environ, "PYTHONPATH": str(ROOT)}
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=timeout, cwd=ROOT, env=here)
    except subprocess.TimeoutExpired:
        row.outcome, row.cause = NAMED, f"not at an end after {timeout:g} s"
        return row
    if "Traceback" in run.stderr or run.returncode not in (0, 4):
        row.cause = f"exit {run.returncode}: {(run.stderr.strip().splitlines() or [''])[-1]}"
        return row
    summary = json.loads((folder / "summary.json").read_text())
    with (folder / "history.csv").open(newline="") as file:
        history = list(csv.DictReader(file))
    row.condition = float(run.stdout.split()[-1])
    _fill(row, summary, history, run.returncode)
    if row.outcome == CERTIFIED and not point.has_solution:
        row.outcome, row.cause = WRONG, "certified where there is no equilibrium"
    return row


def _fill(row: Row, summary: dict[str, Any], history: Sequence[dict[str, str]], code: int) -> None:
    checks = summary.get("certificate", {})
    row.steps = len(history)
    for name in ("iterations", "refused", "cut_backs"):
        setattr(row, name, summary[name])
    row.smallest_jacobian = checks.get("smallest_jacobian", {}).get("worst", math.nan)
    row.penetration = checks.get("penetration_over_wall", {}).get("worst", math.nan)
    row.seconds = round(summary["seconds"]["processor"], 1)
    for name in COMPARED:
        setattr(row, name, float(history[-1][name]) if history else math.nan)
    found = summary["expected"]
    row.error = max((abs(entry["deviation"]) for entry in found), default=math.nan)
    missed = [f"{entry['quantity']} {entry['deviation']:+.1e}" for entry in found if not entry["passed"]]
    passed = checks and not summary["failed_steps"]
    if summary["accepted_steps"] != len(history):
        row.cause = "accepted steps are not on disk"
    elif code == 0 and passed and not missed:
        is_number = all(math.isfinite(float(step[name])) for step in history for name in COMPARED)
        row.outcome, row.cause = (CERTIFIED, "") if is_number else (WRONG, "not a number")
    elif "not as the case expects" in summary["outcome"]:
        row.cause = f"balanced, but {', '.join(missed)}"
    else:
        failed = sorted({name for names in summary["failed_steps"].values() for name in names})
        row.outcome, row.cause = NAMED, ", ".join(failed) or summary["outcome"].partition(";")[0]


def difference(one: Row, other: Row, units: tuple[float, float] = (1.0, 1.0)) -> float:
    """Return the largest relative difference of the compared numbers, `one` in other units of length and stress."""
    length, stress = units
    return max(
        abs(getattr(one, name) / (length**lengths * stress**stresses) - getattr(other, name))
        / max(abs(getattr(other, name)), 1e-3)
        for name, (lengths, stresses) in COMPARED.items()
    )


def compare(point: Point, rows: dict[str, Row]) -> None:
    """Note how far a point is from the one that it must agree with."""
    row, other = rows[point.label], rows.get(f"{point.group}: {point.same_as}")
    if not point.same_as or row.outcome != CERTIFIED or other is None or other is row:
        return
    row.error = difference(row, other, point.units)
    if not row.error <= AGREEMENT:
        row.outcome, row.cause = WRONG, f"differs from {point.same_as}"


def known(file: Path, code: str) -> dict[str, Row]:
    """Return the rows that these sources have made."""
    if not file.exists():
        return {}
    kinds: dict[str, Any] = {"int": int, "float": float, "bool": lambda text: text == "True"}
    by_name = {field.name: kinds.get(str(field.type), str) for field in fields(Row)}
    with file.open(newline="") as table:
        rows = [Row(**{name: by_name[name](value) for name, value in entry.items()}) for entry in csv.DictReader(table)]
    return {row.label: row for row in rows if row.code == code}


def write(file: Path, rows: Sequence[Row]) -> None:
    """Write all rows."""
    with file.open("w", newline="") as table:
        writer = csv.DictWriter(table, [field.name for field in fields(Row)], lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


@click.command(help=__doc__.split("\n")[0])
@click.option("--quick", is_flag=True, help="Some forty points, and no figure.")
@click.option("--timeout", default=120.0, show_default=True, help="Seconds on the clock for one run.")
@click.option("--only", default="", help="Points whose label has this text.")
@click.option("--report-only", is_flag=True, help="Write table and figure of the rows that are there.")
def main(quick: bool, timeout: float, only: str, report_only: bool) -> None:
    """Run the points that have no row yet, and report."""
    from tools.extreme_report import report

    code = sources()
    file = RESULTS / ("extreme-quick.csv" if quick else "extreme.csv")
    chosen = [point for point in points() if point.is_quick or not quick]
    if report_only and file.exists():
        code = file.read_text().split("\n")[1].rpartition(",")[2]
    rows = known(file, code)
    for point in sorted(chosen, key=lambda point: (not point.is_quick, bool(point.perturbed_from))):
        if report_only or point.label in rows or only not in point.label:
            continue
        rows[point.label] = row = solve(point, timeout, code)
        compare(point, rows)
        click.echo(f"{row.outcome:9}  {row.seconds:6.1f} s  {row.label}  {row.cause}", err=True)
        write(file, list(rows.values()))
    found = [rows[point.label] for point in chosen if point.label in rows]
    asked = sum(not point.perturbed_from for point in chosen)
    report(found, asked, file.with_suffix(".md"), None if quick else ROOT / "docs" / "extreme.png")


if __name__ == "__main__":
    main()
