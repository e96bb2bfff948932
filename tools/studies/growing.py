"""What tissues of 35 to 1024 cells take when they are sheared, and whether they are certified.

    python -m tools.studies growing [--only TEXT] [--accuracy NUMBER] [--minutes NUMBER] [--show]

Each tissue of hexagonal cells is sheared by a tenth or by a fifth of its height, hollow, under a pressure of 0.005 or
filled, in one level, on one thread; each run is a process of its own. Errors are those that the run estimates, in
percent; `slid` is the share of itself by which the mean gap changed as walls were followed to rest, in percent. The
tail is the share of factorisations that come after the energy is within 3e-4 of that with which walls end on the same
mesh. A run that takes more minutes than are given is stopped, and its row says so.
Rows go to `tools/results/growing.csv`; those of the present sources are not repeated.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.runs import ended, released_rows, solve_words, sources, summary_in
from tools.tail import tail_of

TABLE, REPORT = RESULTS / "growing.csv", RESULTS / "growing.md"
#: Rows and columns of cells.
SIZES = ((5, 7), (10, 10), (20, 25), (32, 32))
SHARES = (0.1, 0.2)
CASES = {"hollow": "shear-empty", "pressure": "shear-pressurised", "filled": "shear-filled"}
#: What a run that took more time than it was given ends as.
_LATE = "out of time"
_NUMBERS = ("energy", "plate_force", "mean_gap")
_WORK = (
    "meshes", "iterations", "factorisations", "tail", "refused", "seconds", "factorisation", "assembly", "GiB", "code",
)  # fmt: skip
COLUMNS = (
    "tissue", "accuracy", "outcome", *(f"{number}{end}" for number in _NUMBERS for end in ("", "_error")), "slid",
    *_WORK,
)  # fmt: skip
Row = dict[str, Any]


def scenes() -> dict[str, tuple[str, tuple[str, ...]]]:
    """Return case and settings of each tissue, by its name, small ones first."""
    found: dict[str, tuple[str, tuple[str, ...]]] = {}
    for rows, columns in SIZES:
        for share in SHARES:
            displacement = share * (1.5 * rows + 0.5)  # the height of such a tissue, in sides of a cell
            sets = (f"tissue.rows={rows}", f"tissue.cols={columns}", f"load.displacement=[{displacement:.6g}, 0.0]")
            for lumen, case in CASES.items():
                found[f"{rows}x{columns}, {lumen}, {share:g}"] = case, sets
    return found


def measured(case: str, sets: Iterable[str], accuracy: float, minutes: float) -> Row:
    """Run a case in one level, and return numbers, errors in percent, and what it took."""
    row: Row = {"accuracy": f"{accuracy:g}", "code": sources()}  # sources may change while it runs
    with TemporaryDirectory() as place:
        folder = Path(place) / "out"
        settings = (*sets, "load.levels=1", f"accuracy={accuracy:g}")
        words = [*solve_words(case, folder, settings), "-v", "--max-minutes", f"{minutes:g}"]
        run = ended(*words, timeout=60 * minutes + 120)
        summary, released = summary_in(folder), released_rows(folder)
    row |= {"GiB": f"{run.peak_mb / 1024:.2f}", "seconds": f"{run.processor:.0f}"}
    said = run.last_words("no words").partition(";")[0]
    row |= {"outcome": summary.get("outcome") or (_LATE if run.is_late else said)}
    row |= {column: summary.get(column, "") for column in ("iterations", "factorisations", "refused")}
    row["tail"] = tail_of(run.err) if released else ""
    row["meshes"] = len(summary.get("meshes", ())) or ""
    phases = summary.get("seconds", {}).get("processor_by_phase", {})
    row |= {phase: f"{phases[phase]:.0f}" for phase in ("factorisation", "assembly") if phase in phases}
    return row | (numbers_of(released[-1]) if released else {})


def numbers_of(step: Mapping[str, str]) -> Row:
    """Return what a step of the history says of each number, with errors in percent."""
    force = float(step["plate_force_x"]) ** 2 + float(step["plate_force_y"]) ** 2 + float(step["plate_force_z"]) ** 2
    values = {"energy": float(step["energy"]), "plate_force": force**0.5, "mean_gap": float(step["mean_gap"])}
    gap = abs(values["mean_gap"])
    row: Row = {"slid": f"{100 * float(step['mean_gap_slid'] or 0) / gap:.2g}" if gap else ""}
    for number, value in values.items():
        error = float(step[f"{number}_error"] or "nan")
        row |= {number: f"{value:.5g}", f"{number}_error": f"{100 * error / abs(value):.2g}" if value else ""}
    return row


def report(rows: Iterable[Row]) -> str:
    """Return the table."""
    head = ("tissue", "accuracy", "outcome", *(number.replace("_", " ") for number in _NUMBERS), "slid", *_WORK)
    lines = []
    for row in rows:
        pairs = [f"{row[number]} ± {row[f'{number}_error']} %" if row[number] else "" for number in _NUMBERS]
        beside = [row.get(name, "") for name in ("slid", *_WORK)]
        lines.append((row["tissue"], row["accuracy"], row["outcome"], *pairs, *beside))
    words = (__doc__ or "").partition("\n\n")
    said = words[2].partition("\n\n")[2].strip()
    return f"# Growing tissues\n\n{words[0]} {said}\n\n{tables.markdown(head, lines)}\n"


@described(__doc__)
@click.option("--only", default="", metavar="TEXT", help="Tissues whose name begins with this text.")
@click.option("--accuracy", default=0.1, show_default=True, type=click.FloatRange(0, min_open=True))
@click.option("--minutes", default=60.0, show_default=True, help="Most minutes of a run.")
@click.option("--show", is_flag=True, help="Write the report of the rows that are there, and run nothing.")
def command(only: str, accuracy: float, minutes: float, show: bool) -> None:
    """Run what is missing, and report."""
    for name, (case, sets) in scenes().items():
        rows = tables.read(TABLE)
        known = {(row["tissue"], row["accuracy"]) for row in rows if row["code"] == sources()}
        if not show and name.startswith(only) and (name, f"{accuracy:g}") not in known:
            row = {"tissue": name} | measured(case, sets, accuracy, minutes)
            click.echo(" ".join(f"{key}={value}" for key, value in row.items()), err=True)
            rows = tables.read(TABLE)  # others may have come in meanwhile
            older = [old for old in rows if (old["tissue"], old["accuracy"]) != (name, f"{accuracy:g}")]
            tables.write(TABLE, COLUMNS, [*older, row])
    REPORT.write_text(report(tables.read(TABLE)), encoding="utf-8")
