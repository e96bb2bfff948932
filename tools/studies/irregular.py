"""How far force and parted walls of irregular tissues scatter, and where the honeycomb lies among them.

    python -m tools.studies irregular [--seeds 20] [--show]     docs/irregular.png

Tissues of 60 Voronoi cells, one a seed, and a honeycomb of as many cells of the same mean area are sheared by a tenth
of their height; bonds between walls hold them together, and are followed by load stepping. Observed are the plate force
over the width of the tissue, and the share of pairs of walls that have parted; errors of the mesh are not estimated. A
row a level goes to `tools/results/irregular.csv`; tissues that have rows are not repeated. The figure has the levels up
to where runs are certified; `--show` draws what is in the table, and runs nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile
from time import process_time
from typing import Any

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import ngcell
from tools import tables
from tools.commands import described
from tools.places import DOCS, RESULTS
from tools.runs import sources

TABLE, FIGURE = RESULTS / "irregular.csv", DOCS / "irregular.png"
COLUMNS = (
    "tissue", "shear", "force_over_width", "parted_share", "energy", "bonded_share", "certified", "outcome", "seconds",
    "code",
)  # fmt: skip
HONEYCOMB = "honeycomb"
ROWS, COLS, WALL = 6, 10, 0.1
#: Area of a hexagon of side 1, and height of the rows of them.
AREA, HEIGHT = 1.5 * np.sqrt(3.0), 1.5 * ROWS + 0.5
SHEAR, LEVELS = 0.1, 10
#: What is drawn, and its words.
PANELS = {"force_over_width": "plate force / width", "parted_share": "parted pairs of walls, share"}
Array = NDArray[np.float64]


def tissue(name: str) -> tuple[dict[str, Any], float]:
    """Return the entries of a tissue, and its width [length]."""
    if name == HONEYCOMB:
        return {"kind": HONEYCOMB, "rows": ROWS, "cols": COLS, "wall": WALL}, np.sqrt(3.0) * COLS
    width = ROWS * COLS * AREA / HEIGHT
    extent = [float(width), float(HEIGHT)]
    shape = {"kind": "voronoi", "cells": ROWS * COLS, "extent": extent, "seed": int(name), "relaxation": 3}
    return {**shape, "wall": WALL}, float(width)


def measured(name: str) -> list[dict[str, object]]:
    """Run once, and return a row a level."""
    started, outcome = process_time(), "reached the last level"
    shape, width = tissue(name)
    scene = ngcell.Case.model_validate(
        {
            "tissue": shape,
            "material": {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0},
            "load": {"kind": "plates", "displacement": [SHEAR * HEIGHT, 0.0], "levels": LEVELS},
            "cohesion": {"strength": 0.0125, "energy": 0.000375},
            "strategy": {"kind": "load-stepping"},
            "mesh": {"size": 0.34, "grading": 1},
        }
    )
    try:
        steps: Sequence[ngcell.Step] = ngcell.simulate(scene)
    except ngcell.NotConverged as failure:
        steps, outcome = failure.steps, str(failure)
    told = {"tissue": name, "outcome": outcome, "seconds": f"{process_time() - started:.0f}", "code": sources()}
    return [
        told
        | {
            "shear": f"{SHEAR * step.record.load_factor:.5g}",
            "force_over_width": f"{step.record.plate_force_x / width:.6g}",
            "parted_share": f"{step.record.parted_pairs / len(step.walls):.5g}",
            "energy": f"{step.record.energy:.6g}",
            "bonded_share": f"{step.record.bonded_share:.5g}",
            "certified": step.record.certified,
        }
        for step in steps
        if step.walls
    ] or [told | {"certified": False}]


def curves(rows: Sequence[dict[str, str]], column: str) -> dict[str, tuple[Array, Array]]:
    """Return shears and values of each tissue, from rest up to the level before the first that is not certified."""
    found = {}
    for name in dict.fromkeys(row["tissue"] for row in rows):
        mine = takewhile(lambda row: row["certified"] == "True", (row for row in rows if row["tissue"] == name))
        places = [(0.0, 0.0), *((float(row["shear"]), float(row[column])) for row in mine)]
        found[name] = np.array([x for x, _ in places]), np.array([y for _, y in places])
    return found


def spread(found: Sequence[tuple[Array, Array]]) -> tuple[Array, Array, Array, Array]:
    """Return shears, means, standard deviations and counts of the irregular tissues that are certified until there."""
    at = np.unique(np.concatenate([x.round(9) for x, _ in found]))
    values = np.array([np.interp(at, x, y, right=np.nan) for x, y in found])
    count = np.isfinite(values).sum(0)
    kept = count > 1
    values = values[:, kept]
    return at[kept], np.nanmean(values, 0), np.nanstd(values, 0, ddof=1), count[kept]


def draw(rows: Sequence[dict[str, str]]) -> list[str]:
    """Draw a panel each for force and parted walls, and return what they say at the largest shear."""
    figure, said = Figure(figsize=(10, 4), layout="constrained"), []
    for axes, (column, words) in zip(figure.subplots(1, 2), PANELS.items(), strict=True):
        found = curves(rows, column)
        regular = found.pop(HONEYCOMB, None)
        said += [f"{words}: {line}" for line in _panel(axes, list(found.values()), regular)]
        axes.set(xlabel="shear", ylabel=words, xlim=(0, SHEAR), ylim=(0, None))
        axes.spines[["top", "right"]].set_visible(False)
    figure.axes[0].legend(frameon=False, fontsize=8)
    figure.savefig(FIGURE, dpi=130)
    return said


def _panel(axes: Axes, irregular: list[tuple[Array, Array]], regular: tuple[Array, Array] | None) -> list[str]:
    said = []
    for x, y in irregular:
        axes.plot(x, y, color="#1f5f8b", linewidth=0.6, alpha=0.5)
    if len(irregular) > 1:
        at, mean, deviation, count = spread(irregular)
        some = f"{count.max()}" if count.min() == count.max() else f"{count.min()} to {count.max()}"
        label = f"Voronoi cells: mean and standard deviation of {some} seeds"
        axes.plot(at, mean, color="#1f5f8b", linewidth=2, label=label)
        axes.fill_between(at, mean - deviation, mean + deviation, color="#1f5f8b", alpha=0.2, linewidth=0)
        said.append(f"{mean[-1]:.4g} ± {deviation[-1]:.2g} at shear {at[-1]:g} ({count[-1]} seeds)")
    if regular is not None:
        axes.plot(*regular, ".-", color="black", linewidth=1.4, label=HONEYCOMB)
        said.append(f"{regular[1][-1]:.4g} at shear {regular[0][-1]:g} (honeycomb)")
    return said


@described(__doc__)
@click.option("--seeds", default=20, show_default=True, type=click.IntRange(min=1))
@click.option("--show", is_flag=True, help="Draw what is in the table, and run nothing.")
def command(seeds: int, show: bool) -> None:
    """Run what is missing, draw, and tell mean and spread at the largest shear."""
    done = {row["tissue"] for row in tables.read(TABLE)}
    for name in () if show else (HONEYCOMB, *map(str, range(seeds))):
        if name not in done:
            rows = measured(name)
            tables.append(TABLE, COLUMNS, rows)
            click.echo(", ".join(f"{key} {value}" for key, value in rows[-1].items()))
    for line in (*draw(tables.read(TABLE)), str(FIGURE)):
        click.echo(line)
