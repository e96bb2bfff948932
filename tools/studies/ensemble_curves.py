"""Gaps over shear with their scatter over irregular 3x3 tissues.

    python -m tools.studies ensemble-curves pressure [--seeds 5] [--show]     docs/ensemble-pressure.png
    python -m tools.studies ensemble-curves inclusion                         docs/ensemble-inclusion.png

Corners of the honeycomb are displaced at random by up to 0.03 of the side, a tissue a seed; each curve is run on every
one. What is observed is the mean gap of held walls, with its estimated error, and the share of parted pairs of walls.
Onset is the plate displacement at which the mean gap reaches 5 % of the wall, or half of all pairs have parted. A row
a level goes to `tools/results/ensemble-curves.csv`; runs that have rows are not repeated. What holds of the trends goes
to `tools/results/ensemble-curves.md`; `--show` draws what is in the table, and runs nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile
from time import process_time

import click
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import ngcell
from tools import tables
from tools.commands import described
from tools.places import DOCS, RESULTS
from tools.runs import sources
from tools.sheared import LEVELS

TABLE, REPORT = RESULTS / "ensemble-curves.csv", RESULTS / "ensemble-curves.md"
KEYS = ("figure", "value", "seed")
COLUMNS = (
    *KEYS, "displacement", "mean_gap", "mean_gap_error", "parted_share", "largest_gap", "certified", "outcome",
    "seconds", "code",
)  # fmt: skip
#: Pressures in the cells, and moduli c1 of what fills them with a bulk modulus a thousand times that [stress].
VALUES = {"pressure": (0.0, 0.00125, 0.0025, 0.005, 0.01), "inclusion": (0.0, 0.01, 0.02, 0.05, 0.1)}
REACHED = "reached the last level"
#: Marks of onset, and their words.
MARKS = {"mean_gap": (0.005, "mean gap"), "parted_share": (0.5, "parted wall pairs, share")}
Array = NDArray[np.float64]


def settings(figure: str, value: float, seed: int) -> list[str]:
    """Return what is set in the shipped 3x3 tissue."""
    sets = ["tissue.kind=perturbed", "tissue.spread=0.03", f"tissue.seed={seed}", "expected=[]", "accuracy=0.1"]
    sets += [f"load.levels={LEVELS}"]
    if figure == "pressure" and value:
        sets += ["lumen.kind=pressure", f"lumen.pressure={value}"]
    if figure == "inclusion" and value:
        law = f"kind='mooney-rivlin', c1={value}, c2=0.0, bulk_modulus={1000 * value:g}"
        sets += [f"lumen={{kind='inclusion', material={{{law}}}}}"]
    return sets


def measured(figure: str, value: float, seed: int) -> list[dict[str, object]]:
    """Run once, and return a row a level."""
    started, outcome = process_time(), REACHED
    try:
        steps = ngcell.simulate(ngcell.read_case("shear-empty-3x3", settings(figure, value, seed)))
    except ngcell.NotConverged as failure:
        steps, outcome = list(failure.steps), str(failure)
    told = {"figure": figure, "value": value, "seed": seed, "outcome": outcome, "code": sources()}
    told["seconds"] = f"{process_time() - started:.1f}"
    return [
        told
        | {
            "displacement": f"{step.record.plate_displacement:g}",
            "mean_gap": f"{step.record.mean_gap:.6g}",
            "mean_gap_error": f"{step.record.mean_gap_error:.2g}",
            "parted_share": f"{step.record.parted_pairs / len(step.walls):.5g}",
            "largest_gap": f"{step.record.largest_gap:.6g}",
            "certified": step.record.certified,
        }
        for step in steps
        if step.walls
    ]


def curve(rows: Sequence[dict[str, str]], name: str) -> tuple[Array, Array]:
    """Return displacements and values of one run, from rest on."""
    x = np.array([0.0, *(float(row["displacement"]) for row in rows)])
    return x, np.array([0.0, *(float(row[name]) for row in rows)])


def onset(rows: Sequence[dict[str, str]], name: str) -> tuple[float, float]:
    """Return where a run reaches the mark of a number, and what the estimated error of the number makes of it."""
    (x, y), mark = curve(rows, name), MARKS[name][0]
    above = np.flatnonzero(y >= mark)
    if not len(above):
        return np.nan, np.nan
    end = int(above[0])
    slope = (y[end] - y[end - 1]) / (x[end] - x[end - 1])
    error = float(rows[end - 1]["mean_gap_error"]) / slope if name == "mean_gap" else np.nan
    return float(x[end - 1] + (mark - y[end - 1]) / slope), error


def runs_of(figure: str, value: float) -> list[list[dict[str, str]]]:
    """Return the rows of each run of a curve, up to the level before the first that is not certified."""
    mine = [row for row in tables.read(TABLE) if row["figure"] == figure and float(row["value"]) == value]
    found = []
    for seed in sorted({row["seed"] for row in mine}):
        rows = [row for row in mine if row["seed"] == seed]
        found.append(list(takewhile(lambda row: row["certified"] == "True", rows)))
    return [rows for rows in found if rows]


def draw(figure: str) -> None:
    """Draw mean and band, from the smallest to the largest, up to where all runs are certified; the legend tells it."""
    picture = Figure(figsize=(10, 4), layout="constrained")
    farthest = max(float(row["displacement"]) for row in tables.read(TABLE) if row["figure"] == figure)
    for axes, (name, (mark, words)) in zip(picture.subplots(1, 2), MARKS.items(), strict=True):
        for number, value in enumerate(VALUES[figure]):
            runs = runs_of(figure, value)
            if not runs:
                continue
            end = min(map(len, runs))
            x, values = curve(runs[0][:end], name)[0], np.array([curve(rows[:end], name)[1] for rows in runs])
            label = f"{value:g}" if value else "empty"
            label += f" (certified up to {x[-1]:g})" if x[-1] < farthest else ""
            colour = "black" if not value else f"C{number - 1}"
            axes.plot(x, values.mean(0), ".-", color=colour, label=label, linewidth=1.5)
            axes.fill_between(x, values.min(0), values.max(0), color=colour, alpha=0.18, linewidth=0)
        axes.axhline(mark, color="#8a8f98", linewidth=0.8, linestyle=":")
        axes.set(xlabel="plate displacement", ylabel=words, ylim=(0, None))
        axes.spines[["top", "right"]].set_visible(False)
    picture.axes[0].legend(frameon=False, fontsize=8, title={"pressure": "pressure", "inclusion": "modulus"}[figure])
    picture.savefig(DOCS / f"ensemble-{figure}.png", dpi=130)


def report() -> str:
    """Return the table of onsets, and in how many members each is later than that of the curve before."""
    lines = [
        "# Onsets over ensembles", "",
        "`python -m tools.studies ensemble-curves` makes this: mean ± standard deviation over members, each as far as",
        "it is certified, ± largest estimated error of the mesh, where estimated. Members: with an onset, of all.",
        "Later: in how many members onset is later than with the value before, of those in which both have one.", "",
    ]  # fmt: skip
    rows = []
    for figure, values in VALUES.items():
        for name, (_, words) in MARKS.items():
            before: dict[str, float] = {}
            for value in values:
                found = {run[0]["seed"]: onset(run, name) for run in runs_of(figure, value)}
                if found:
                    rows.append([figure, f"{value:g}", words.split(",")[0], *_onsets(found, before)])
                before = {seed: place for seed, (place, _) in found.items() if np.isfinite(place)}
    head = ("curves", "value", "onset in", "onset", "members", "later")
    return "\n".join([*lines, tables.markdown(head, rows)]) + "\n"


def _onsets(found: dict[str, tuple[float, float]], before: dict[str, float]) -> list[str]:
    """Return onset, members and how many are later, in words."""
    known = {seed: place for seed, (place, _) in found.items() if np.isfinite(place)}
    both = [seed for seed in known if seed in before]
    later = f"{sum(known[seed] > before[seed] for seed in both)} of {len(both)}" if both else ""
    members = f"{len(known)} of {len(found)}"
    if not known:
        return ["none", members, later]
    places, errors = np.array(list(known.values())), [found[seed][1] for seed in known]
    told = f"{places.mean():.4f}" + (f" ± {places.std(ddof=1):.4f}" if len(places) > 1 else "")
    told += f" ± {max(errors):.4f}" if np.isfinite(errors).all() else ""
    return [told, members, later]


@described(__doc__)
@click.argument("figure", type=click.Choice([*VALUES]))
@click.option("--seeds", default=5, show_default=True, help="Number of tissues.")
@click.option("--show", is_flag=True, help="Draw what is in the table, and run nothing.")
def command(figure: str, seeds: int, show: bool) -> None:
    """Run what is missing, draw, and write the table of onsets."""
    for seed in () if show else range(seeds):
        for value in VALUES[figure]:
            done = {tuple(row[key] for key in KEYS) for row in tables.read(TABLE)}
            if (figure, str(value), str(seed)) in done:
                continue
            rows = measured(figure, value, seed)
            tables.append(TABLE, COLUMNS, rows)
            click.echo(f"{figure} {value:g}, seed {seed}: {rows[-1]['outcome']}, {rows[-1]['seconds']} s", err=True)
    draw(figure)
    REPORT.write_text(report(), encoding="utf-8")
