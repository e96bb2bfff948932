"""What the mortar and the penalty method take for the same error.

    python -m tools.studies equal-error [--scene NAME] [--show]

Sheared tissues are run through all their load levels at several accuracies, on one thread, each run in a process of its
own. Errors are found against a run at a smaller accuracy: the root of the mean square of relative errors over all
levels, in percent, of the energy, the plate force and the mean gap of held walls; the largest of the three is that of
the run. Of both methods, runs that took longer than another one of theirs with a smaller error do not count: that one
is the price of either error. At the error of each mortar run that counts, the seconds of the penalty follow from its
own: by a line through the logarithms of error and seconds, beyond its largest error those of its cheapest run, and
beyond its smallest at least those that it took there. Only runs of the same sources are compared.
Rows go to `tools/results/equal-error.csv`; those of the present sources are not repeated.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import click
import numpy as np

from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.runs import Run, sources

TABLE, REPORT = RESULTS / "equal-error.csv", RESULTS / "equal-error.md"
KINDS = ("penalty", "mortar")
#: Case, what is set, and kind of contact and accuracy of the run that errors are found against.
SCENES: dict[str, tuple[str, tuple[str, ...], tuple[str, float]]] = {
    "3x3, hollow": ("shear-empty-3x3", (), ("mortar", 0.003)),
    "3x3, under 0.01": ("shear-empty-3x3", ('lumen.kind="pressure"', "lumen.pressure=0.01"), ("mortar", 0.01)),
    "5x7, hollow": ("shear-empty", (), ("penalty", 0.01)),
    "5x7, under 0.005": ("shear-pressurised", (), ("penalty", 0.01)),
}
ACCURACIES = {"penalty": (0.1, 0.05, 0.03), "mortar": (0.1, 0.05)}
NUMBERS = ("energy", "plate_force", "mean_gap")
COLUMNS = (
    "scene", "contact", "accuracy", "certified", "levels", "iterations", "factorisations", "seconds", *NUMBERS, "code",
)  # fmt: skip
#: Most seconds of a run.
_MOST = 2400.0
Row = dict[str, Any]


def run_of(scene: str, kind: str, accuracy: float) -> Run:
    """Return a run of a scene; that of other sources has a folder of its own."""
    case, sets, _ = SCENES[scene]
    return Run(case, (*sets, f"accuracy={accuracy:g}", f'contact.kind="{kind}"', f'title="{sources()}"'))


def numbers_of(run: Run) -> np.ndarray:
    """Return energy, plate force and mean gap of each released level, shape (levels, 3)."""
    names = "energy", "plate_force_x", "plate_force_y", "mean_gap"
    rows = [[float(row[name]) for name in names] for row in run.levels()]
    energy, *force, gap = np.reshape(rows, (-1, len(names))).T
    return np.column_stack([energy, np.hypot(*force), gap])


def errors(found: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Return the root of the mean square of relative errors over levels, shape (3,)."""
    return np.asarray(np.sqrt(((found / exact - 1) ** 2).mean(axis=0)))


def measured(scene: str, kind: str, accuracy: float) -> Row:
    """Return the row of a run; one without errors where it did not come to its end."""
    reference, run = run_of(scene, *SCENES[scene][2]), run_of(scene, kind, accuracy)
    row: Row = {"scene": scene, "contact": kind, "accuracy": f"{accuracy:g}", "code": sources()}
    for each in (reference, run):
        each.solve(_MOST)
    exact, found, summary = numbers_of(reference), numbers_of(run), run.summary
    row |= {name: summary.get(name, "") for name in ("iterations", "factorisations")}
    row["seconds"] = round(float(summary.get("seconds", {}).get("processor", "nan")), 1)
    row |= {"certified": sum(level["certified"] == "True" for level in run.levels()), "levels": len(found)}
    if len(found) == len(exact):
        row |= {name: f"{100 * error:.2g}" for name, error in zip(NUMBERS, errors(found, exact), strict=True)}
    return row


def largest_error(row: Row) -> float:
    """Return the error of a run [%]."""
    return max(float(row[name] or "nan") for name in NUMBERS)


def front(runs: Iterable[Row]) -> list[tuple[float, float]]:
    """Return errors and seconds of the runs of a method that no other one of it beats in both, the most exact first."""
    found = list[tuple[float, float]]()
    for point in sorted((largest_error(row), float(row["seconds"])) for row in runs):
        if not found or point[1] < found[-1][1]:
            found.append(point)
    return found


def seconds_at(error: float, runs: Iterable[Row]) -> tuple[float, bool]:
    """Return the seconds of runs at an error, and whether they are only a lower bound."""
    points = front(runs)
    logs = np.log(np.array(points))
    return float(np.exp(np.interp(np.log(error), logs[:, 0], logs[:, 1]))), error < points[0][0]


def report(rows: Sequence[Row]) -> str:
    """Return the tables."""
    head = ("scene", "contact", "accuracy", "certified", "iterations", "factorisations", "s", *NUMBERS, "code")
    lines = [
        (row["scene"], row["contact"], row["accuracy"], f"{row['certified']} of {row['levels']}", row["iterations"],
         row["factorisations"], row["seconds"], *(row[name] for name in NUMBERS), row["code"])
        for row in rows
    ]  # fmt: skip
    ratios = []
    for row in rows:
        same = [one for one in rows if one["scene"] == row["scene"] and one["code"] == row["code"] and one["energy"]]
        penalty, mine = ([one for one in same if one["contact"] == kind] for kind in KINDS)
        if row["contact"] == "penalty" or not penalty or not row["energy"]:
            continue
        if (largest_error(row), float(row["seconds"])) not in front(mine):
            no = f"{largest_error(row):.2g}", row["seconds"], "", "a cheaper run errs less"
            ratios.append((row["scene"], row["accuracy"], *no))
            continue
        seconds, is_bound = seconds_at(largest_error(row), penalty)
        sign = ("at least ", "at most ") if is_bound else ("", "")
        ratio = f"{sign[1]}{float(row['seconds']) / seconds:.2f}"
        shown = row["seconds"], f"{sign[0]}{seconds:.0f}", ratio
        ratios.append((row["scene"], row["accuracy"], f"{largest_error(row):.2g}", *shown))
    words = (__doc__ or "").partition("\n\n")
    said = words[2].partition("\n\n")[2].strip()
    ratio_head = ("scene", "accuracy", "error [%]", "s of the mortar", "s of the penalty at this error", "ratio")
    tables_of = tables.markdown(ratio_head, ratios), tables.markdown(head, lines)
    return "\n\n".join(["# The same error by penalty and mortar", f"{words[0]} {said}", *tables_of]) + "\n"


def _runs(only: str) -> Iterable[tuple[str, str, float]]:
    for scene in SCENES:
        if only in scene:
            yield from ((scene, kind, accuracy) for accuracy in (0.1, 0.05, 0.03) for kind in KINDS
                        if accuracy in ACCURACIES[kind])  # fmt: skip


@described(__doc__)
@click.option("--scene", "only", default="", help="Only scenes whose names hold this.")
@click.option("--show", is_flag=True, help="Write the report of the rows that are there, and run nothing.")
def command(only: str, show: bool) -> None:
    """Run what is missing, and report."""
    order = list(_runs(""))
    for scene, kind, accuracy in () if show else _runs(only):
        rows, key = tables.read(TABLE), (scene, kind, f"{accuracy:g}")
        if any((row["scene"], row["contact"], row["accuracy"], row["code"]) == (*key, sources()) for row in rows):
            continue
        row = measured(scene, kind, accuracy)
        click.echo(" ".join(f"{name}={value}" for name, value in row.items()), err=True)
        rows = tables.read(TABLE)
        kept = [old for old in rows if (old["scene"], old["contact"], old["accuracy"]) != key]
        kept.append({name: str(row.get(name, "")) for name in COLUMNS})
        kept.sort(key=lambda one: order.index((one["scene"], one["contact"], float(one["accuracy"]))))
        tables.write(TABLE, COLUMNS, kept)
    REPORT.write_text(report(tables.read(TABLE)), encoding="utf-8")
