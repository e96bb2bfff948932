"""What holds cells together: gaps of the sheared tissue over the displacement of its plates.

    python -m tools.studies figures pressure [--tissue 5x7]     docs/gap-pressure-3x3.png
    python -m tools.studies figures inclusion                   docs/gap-inclusion-3x3.png
    python -m tools.studies figures models                      docs/gap-models-3x3.png
    python -m tools.studies figures fibres                      docs/gap-fibres-3x3.png
    python -m tools.studies figures free                        docs/pressure-free.png

A curve is a pressure, an inclusion or a model of a filled cell, with a band of its estimated errors at the accuracy of
the shipped cases; crosses are levels that are not certified. Rows go to `tools/results/figures.csv`; runs that have
rows are not repeated, unless `--again` is given and other sources made them. The onset of a curve in the mean gap is
the plate displacement at which that reaches 5 % of the wall, as everywhere; in the largest gap that at which it reaches
the wall's thickness; in parted pairs that at which half of all pairs have parted. Curves are straight between levels.
"""

from __future__ import annotations

import math
import shutil
from statistics import fmean
from typing import Any

import click
import numpy as np
from matplotlib.figure import Figure

import ngcell
from ngcell.export import draw_tissue
from tools import tables
from tools.commands import described
from tools.places import DOCS, RESULTS
from tools.runs import sources
from tools.sheared import TISSUES, fibres, inclusions, pressures, run_of

TABLE = RESULTS / "figures.csv"
COLUMNS = (
    "tissue", "case", "setting", "strategy", "pairs", "displacement", "largest_gap", "mean_gap", "parted_pairs",
    "opened_share", "components", "largest_component", "mean_pressure", "plate_force", "contact_force", "energy",
    "largest_gap_error", "mean_gap_error", "plate_force_error", "energy_error", "certified", "failures", "seconds",
    "code",
)  # fmt: skip
WALL = 0.1
#: What counts as onset: a gap, or a share of all pairs.
ONSET = {"mean_gap": 0.05 * WALL, "largest_gap": WALL, "parted_pairs": 0.5}
EMPTY = ("shear-empty", "", "empty")
MODELS = [
    ("shear-pressurised", "lumen.pressure=0.005", "pressure 0.005"),
    ("shear-filled", "lumen.material.c1=0.001; lumen.material.bulk_modulus=1", "solid of modulus 0.001"),
    ("shear-fluid", "", "incompressible fluid"),
]
CURVES = {
    "pressure": [EMPTY, *pressures()],
    "inclusion": [EMPTY, *inclusions()],
    "models": [EMPTY, *MODELS],
    "fibres": [EMPTY, *fibres()],
}


def rows_of(tissue: str, case: str, setting: str, strategy: str) -> list[dict[str, object]]:
    """Run a case and return a row for each level."""
    run = run_of(tissue, case, setting, strategy)
    outcome = run.solve(timeout=7200)
    pressure: dict[str, list[float]] = {}
    for cell in tables.read(run.folder / "cells.csv"):
        pressure.setdefault(cell["step"], []).append(float(cell["pressure"]))
    key = {"tissue": tissue, "case": case, "setting": setting, "strategy": strategy, "code": sources()}
    failures = run.summary["failed_steps"]
    click.echo(f"{tissue} {case} {setting} {strategy}: {outcome}", err=True)
    return [
        key
        | level_row(row)
        | {
            "pairs": run.summary["facing_pairs"],
            "mean_pressure": fmean(pressure[row["step"]]),
            "failures": " ".join(failures.get(row["step"], ())),
        }
        for row in run.levels()
    ]


def level_row(row: dict[str, str]) -> dict[str, str]:
    """Return the numbers of a level."""
    same = (
        "largest_gap", "mean_gap", "parted_pairs", "opened_share", "components", "largest_component", "contact_force",
        "energy", "largest_gap_error", "mean_gap_error", "plate_force_error", "energy_error", "certified", "seconds",
    )  # fmt: skip
    named = {"displacement": "plate_displacement", "plate_force": "plate_force_x"}
    return {name: row[name] for name in same} | {name: row[old] for name, old in named.items()}


def compute(name: str, tissue: str, strategy: str, *, again: bool) -> None:
    """Run what has no rows yet, and what other sources have made if it is to be made again."""
    for case, setting, _ in CURVES[name]:
        key = {"tissue": tissue, "case": case, "setting": setting, "strategy": strategy}
        rows: list[dict[str, Any]] = [*tables.read(TABLE)]
        known = [row for row in rows if key.items() <= row.items()]
        if not known or (again and any(row.get("code") != sources() for row in known)):
            shutil.rmtree(run_of(tissue, case, setting, strategy).folder, ignore_errors=True)  # a run is kept
            others = [row for row in rows if row not in known]
            tables.write(TABLE, COLUMNS, [*others, *rows_of(tissue, case, setting, strategy)])


def onset(rows: list[dict[str, str]], measure: str) -> float:
    """Return the plate displacement at which a measure reaches its mark; NaN if it never does."""
    mark = ONSET[measure] * (int(rows[0]["pairs"]) if measure == "parted_pairs" else 1)
    x = np.array([0.0, *(float(row["displacement"]) for row in rows)])
    y = np.array([0.0, *(float(row[measure]) for row in rows)])
    above = np.flatnonzero(y >= mark)
    if not len(above):
        return math.nan
    end = above[0]
    return float(x[end - 1] + (mark - y[end - 1]) / (y[end] - y[end - 1]) * (x[end] - x[end - 1]))


def draw(name: str, tissue: str) -> None:
    """Draw the curves, with their onsets marked, and print the table of onsets."""
    measures = {"largest_gap": "largest gap", "mean_gap": "mean gap", "parted_pairs": "parted wall pairs"}
    figure = Figure(figsize=(12, 4), layout="constrained")
    panels = dict(zip(measures, figure.subplots(1, 3), strict=True))
    click.echo(f"{'onset in':26}" + "".join(f"{words:>20}" for words in measures.values()))
    for number, (case, setting, label) in enumerate(CURVES[name]):
        key = {"tissue": tissue, "case": case, "setting": setting, "strategy": "sddp"}
        rows = [row for row in tables.read(TABLE) if key.items() <= row.items()]
        x = [0.0, *(float(row["displacement"]) for row in rows)]
        onsets = {measure: onset(rows, measure) for measure in measures}
        refused = sum(row["certified"] != "True" for row in rows)
        note = f"   {refused} levels not certified" if refused else ""
        click.echo(f"{label:26}" + "".join(f"{onsets[measure]:20.4f}" for measure in measures) + note)
        for measure, axes in panels.items():
            y = [0.0, *(float(row[measure]) for row in rows)]
            colour = "black" if case == EMPTY[0] else f"C{number - 1}"
            axes.plot(x, y, ".-", color=colour, label=label, linewidth=1.5)
            refusals = [number for number, row in enumerate(rows, start=1) if row["certified"] != "True"]
            axes.plot(np.take(x, refusals), np.take(y, refusals), "x", color=colour, markersize=9)
            errors = [0.0, *(float(row.get(f"{measure}_error") or 0.0) for row in rows)]
            low, high = np.subtract(y, errors), np.add(y, errors)
            axes.fill_between(x, low, high, color=colour, alpha=0.2, linewidth=0)
            axes.plot(onsets[measure], np.interp(onsets[measure], x, y), "o", color=colour, markersize=8, mfc="none")
    for measure, axes in panels.items():
        axes.set(xlabel="plate displacement", ylabel=measures[measure], ylim=(0, None))
        axes.spines[["top", "right"]].set_visible(False)
    panels["largest_gap"].legend(frameon=False, fontsize=9)
    figure.savefig(DOCS / f"gap-{name}-{tissue}.png", dpi=130)


def draw_free() -> None:
    """Show what pressure does where the sides are free and no plate moves."""
    sets = ["lumen.pressure=0.02", "load.displacement=[0.0, 0.0]", "load.levels=1", "strategy.kind=single-step"]
    *_, step = ngcell.simulate(ngcell.read_case("shear-pressurised", [*sets, "accuracy=inf"]))
    names = ("largest_gap", "mean_gap", "parted_pairs", "certified")
    click.echo(", ".join(f"{name} {getattr(step.record, name)}" for name in names))
    title = "Pressure 0.02, free sides, no shear"
    assert step.snapshot is not None  # the last step is at a level
    draw_tissue(step.snapshot, DOCS / "pressure-free.png", title=title, certified=step.record.certified)


@described(__doc__)
@click.argument("name", type=click.Choice([*CURVES, "free"]))
@click.option("--tissue", default="3x3", show_default=True, type=click.Choice(list(TISSUES)))
@click.option("--again", is_flag=True, help="Make rows of other sources again.")
@click.option("--strategy", default="sddp", show_default=True, type=click.Choice(["sddp", "single-step"]))
def command(name: str, tissue: str, again: bool, strategy: str) -> None:
    """Draw one of the figures; the curves are those of sddp, single-step runs go to the table only."""
    if name == "free":
        draw_free()
        return
    compute(name, tissue, strategy, again=again)
    if strategy == "sddp":
        draw(name, tissue)
