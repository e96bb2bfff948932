"""What came of a point: a row of the map.

A point ends as one of three:

certified
    The run passed its certificate and, where an exact answer exists, comes within 2 % of it.
named
    The run says that it did not reach an answer that it stands for, and why, or the time it was given ran out;
    everything accepted is on disk.
WRONG
    Anything else: an answer that looks right and is not, a number that is none, a traceback.
"""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import tomli_w

from tools import tables
from tools.extreme.point import Point
from tools.runs import ended, summary_in

#: Folders of one process: two that run at the same time do not share them.
FOLDERS = Path(tempfile.gettempdir()) / f"ngcell-extreme-{os.getpid()}"

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
    """Run a point in a process of its own and return its row."""
    folder = FOLDERS / "".join(letter if letter.isalnum() or letter in "+-" else "_" for letter in point.label)
    folder.parent.mkdir(exist_ok=True)
    case = folder.parent / f"{folder.name}.toml"
    case.write_text(tomli_w.dumps(point.case))
    row = Row(point.label, point.group, point.setting, point.has_solution, point.perturbed_from, WRONG, code=code)
    words = ("one", str(case), str(folder), "--tolerance", f"{point.tolerance:g}")
    run = ended("tools.extreme", *words, timeout=timeout)
    if run.timed_out:
        row.outcome, row.cause = NAMED, f"not at an end after {timeout:g} s"
        return row
    if "Traceback" in run.err or run.exit_code not in (0, 4):
        row.cause = f"exit {run.exit_code}: {run.last_words('')}"
        return row
    row.condition = float(run.out.split()[-1])
    fill(row, summary_in(folder), tables.read(folder / "history.csv"), run.exit_code)
    if row.outcome == CERTIFIED and not point.has_solution:
        row.outcome, row.cause = WRONG, "certified where there is no equilibrium"
    return row


def fill(row: Row, summary: dict[str, Any], history: Sequence[dict[str, str]], code: int) -> None:
    """Note what a result folder says, and which outcome that counts as."""
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
        abs(float(getattr(one, name)) / (length**lengths * stress**stresses) - float(getattr(other, name)))
        / max(abs(float(getattr(other, name))), 1e-3)
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


def known(file: Path, code: str | None) -> dict[str, Row]:
    """Return the rows that these sources have made; all of them if none are named."""
    kinds: dict[str, Any] = {"int": int, "float": float, "bool": lambda text: text == "True"}
    by_name = {field.name: kinds.get(str(field.type), str) for field in fields(Row)}
    rows = [Row(**{name: by_name[name](value) for name, value in entry.items()}) for entry in tables.read(file)]
    return {row.label: row for row in rows if code in (None, row.code)}


def write(file: Path, rows: Sequence[Row]) -> None:
    """Write all rows."""
    tables.write(file, [field.name for field in fields(Row)], map(asdict, rows))
