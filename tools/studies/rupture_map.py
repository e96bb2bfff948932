"""Separated or burst: which comes first, by the strengths of cohesion and walls.

    python -m tools.studies rupture-map [--tissue 3x3] [--seeds 3] [--show]

Tissues are sheared with bonds between their walls, by load stepping. The strength of walls does not act on a state, so
one run tells all of them: with S the largest mean stress of any wall until the first pair of walls separates, walls
weaker than S burst first, and stronger ones separate. A row a run goes to `tools/results/rupture-map.csv`; runs that
are there are not repeated. The figure is `docs/rupture-map.png`; `--show` draws it from the table and runs nothing.
Arrows mark what did not separate up to the last level, and open circles what pressure alone separates. Lines, bands and
colours are of runs that are certified until then, and crosses are the others; `all_certified` tells of all steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from itertools import product
from time import process_time
from typing import Any

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import ngcell
from ngcell.build.reported import Step
from tools import tables
from tools.commands import described
from tools.places import DOCS, RESULTS
from tools.runs import sources

TABLE, FIGURE = RESULTS / "rupture-map.csv", DOCS / "rupture-map.png"
#: Traction that bonds bear [stress], each with an energy of 0.03 times that; pressures in the cells [stress].
COHESION, PRESSURES = (0.0125, 0.025, 0.05, 0.1), (0.0, 0.01, 0.02)
#: Tissues, their settings, and the colour of their boundary; Voronoi cells of as many seeds as are asked for. At free
#: sides pressure turns their corners into each other, with the usual stiffness of contact by more than 2 % of the wall.
TISSUES = {
    "3x3": ("shear-empty-3x3", ("tissue.rows=3", "tissue.cols=3"), "#1b1b1b"),
    "3x3, coarser mesh": ("shear-empty-3x3", ("mesh.grading=0",), "#8a8f98"),
    "voronoi": ("shear-empty-3x3", ("contact.stiffness=30",), "#1f5f8b"),
    "5x7": ("shear-empty", ("load.displacement=[1.6, 0.0]",), "#b3361e"),
}
#: As large as 3x3 hexagons of side 1.
VORONOI = "tissue={{kind='voronoi', cells=9, extent=[5.2, 5.0], wall=0.1, relaxation=2, seed={seed}}}"
COMMON = (
    "accuracy=inf", "mesh.size=0.34", "mesh.grading=1", "strategy.kind=load-stepping", "load.levels=10",
    "material.strength=1.0",
)  # fmt: skip
#: Pressure acts in full before the plates move: the first level is that of pressure alone.
WITH_PRESSURE = "load.levels=[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]"
KEYS = ("tissue", "seed", "cohesion", "pressure")
COLUMNS = (
    *KEYS, "boundary", "separated_at", "largest_stress", "at_load", "cells", "unknowns", "steps", "certified",
    "all_certified", "outcome", "seconds", "code",
)  # fmt: skip


def settings(tissue: str, seed: int, cohesion: float, pressure: float) -> tuple[str, list[str]]:
    """Return the shipped case of a run, and what is set in it."""
    case, sets, _ = TISSUES[tissue]
    own = [*sets, *([VORONOI.format(seed=seed)] if tissue == "voronoi" else [])]
    own += [f"cohesion.strength={cohesion}", f"cohesion.energy={0.03 * cohesion}", "expected=[]"]
    if pressure:
        own += ["lumen.kind=pressure", f"lumen.pressure={pressure}", "lumen.ramp=first", WITH_PRESSURE]
    return case, [*COMMON, *own]


def measured(tissue: str, seed: int, cohesion: float, pressure: float) -> dict[str, object]:
    """Run once, and return the row."""
    started, outcome = process_time(), "reached the last level"
    try:
        steps: Sequence[Step] = ngcell.simulate(ngcell.read_case(*settings(tissue, seed, cohesion, pressure)))
    except ngcell.NotConverged as failure:
        steps, outcome = failure.steps, str(failure)
    row: dict[str, object] = {"tissue": tissue, "seed": seed, "cohesion": cohesion, "pressure": pressure}
    row |= {"outcome": outcome, "seconds": f"{process_time() - started:.1f}", "code": sources(), "steps": len(steps)}
    if not steps:
        return row | {"certified": False, "all_certified": False}
    load = np.array([step.record.load_factor for step in steps])
    stress = np.array([step.record.more["utilisation"] for step in steps])
    ends = steps[-1].checkpoint.ends
    assert ends is not None
    loads = ends.loads[1]
    first = float(np.nanmin(loads)) if np.isfinite(loads).any() else None
    until = float(load[-1]) if first is None else first
    # The boundary rests on the steps until separation, and on the one behind it.
    relied_on = [step.record.certified for step in steps[: int(np.searchsorted(load, until)) + 1]]
    is_whole = outcome.startswith("reached")
    at_rest = [] if pressure else [0.0]
    there = float(np.interp(until, [*at_rest, *load], [*at_rest, *stress]))
    boundary = max(stress[load <= until].max(initial=0.0), there)
    return row | {
        "boundary": f"{boundary:.5g}",
        "separated_at": "" if first is None else f"{first:.4f}",
        "largest_stress": f"{stress.max():.5g}",
        "at_load": f"{load[-1]:.4g}",
        "cells": len(loads),
        "unknowns": steps[-1].mesh.unknowns,
        "certified": (first is not None or is_whole) and all(relied_on),
        "all_certified": is_whole and all(step.record.certified for step in steps),
    }


def draw(rows: list[dict[str, str]]) -> None:
    """Draw a panel a pressure: the boundary of each tissue, with its spread over seeds."""
    figure = Figure(figsize=(11, 4.7), layout="constrained")
    panels = np.ravel(figure.subplots(1, len(PRESSURES), sharex=True, sharey=True))
    known = [row for row in rows if row["boundary"]]
    values = [float(row["boundary"]) for row in known]
    low, high = (min(values) / 1.8, max(values) * 1.8) if values else (0.1, 1.0)
    for axes, pressure in zip(panels, PRESSURES, strict=True):
        mine = [row for row in known if float(row["pressure"]) == pressure]
        axes.set(xscale="log", yscale="log", xlabel="strength of cohesion", title=f"pressure {pressure:g}")
        axes.set(ylim=(low, high), xlim=(COHESION[0] / 1.2, COHESION[-1] * 1.2))
        axes.set_xticks(COHESION, [f"{one:g}" for one in COHESION])
        axes.minorticks_off()
        axes.spines[["top", "right"]].set_visible(False)
        for tissue, (_, _, colour) in TISSUES.items():
            of_it = [row for row in mine if row["tissue"] == tissue]
            sure = [row for row in of_it if row["certified"] == "True"]
            _boundary(axes, tissue, sure, high if tissue == "3x3" else None)
            for row in of_it:
                if row["certified"] != "True":
                    axes.plot(float(row["cohesion"]), float(row["boundary"]), "x", color=colour, markersize=7)
        axes.text(0.05, 0.94, "separated first", transform=axes.transAxes, fontsize=10, color="#1f5f8b")
        axes.text(0.95, 0.04, "burst first", transform=axes.transAxes, fontsize=10, color="#b3361e", ha="right")
    panels[0].set_ylabel("strength of walls")
    signs = {r"$\uparrow$": "nothing separates", "o": "pressure alone separates", "x": "not certified"}
    if all(row["certified"] == "True" for row in known):
        del signs["x"]
    plain = Line2D([], [], color="#555a63", linestyle="none", fillstyle="none")
    marks = [copy(plain) for _ in signs]
    for mark, (sign, words) in zip(marks, signs.items(), strict=True):
        mark.set(marker=sign, label=words)
    handles = {line.get_label(): line for axes in panels for line in axes.lines if line.get_label()[0] != "_"}
    figure.legend(handles=[*handles.values(), *marks], fontsize=8, frameon=False, loc="outside lower center", ncols=4)
    figure.savefig(FIGURE, dpi=130)


def _boundary(axes: Axes, tissue: str, rows: list[dict[str, str]], shade_up_to: float | None) -> None:
    """Draw the boundary of a tissue: its mean over seeds, and from the smallest to the largest."""
    if not rows:
        return
    x = sorted({float(row["cohesion"]) for row in rows})
    found = [[float(row["boundary"]) for row in rows if float(row["cohesion"]) == one] for one in x]
    mean, colour = [float(np.mean(each)) for each in found], TISSUES[tissue][2]
    seeds = max(map(len, found))
    counts = {len(each) for each in found}
    some = f"{min(counts)} to {seeds}" if len(counts) > 1 else f"{seeds}"
    label = f"{tissue}, mean and range of {some} seeds" if seeds > 1 else tissue
    if shade_up_to is not None:
        axes.fill_between(x, 1e-9, mean, color="#b3361e", alpha=0.10, linewidth=0)
        axes.fill_between(x, mean, shade_up_to, color="#1f5f8b", alpha=0.10, linewidth=0)
    axes.plot(x, mean, "o-", color=colour, label=label, linewidth=1.6, markersize=4)
    if seeds > 1:
        axes.fill_between(x, list(map(min, found)), list(map(max, found)), color=colour, alpha=0.25, linewidth=0)
    for row in rows:
        place = float(row["cohesion"]), float(row["boundary"])
        if not row["separated_at"]:  # nothing separated up to the last level: walls stronger than this stay whole
            axes.annotate("", (place[0], place[1] * 1.25), place, arrowprops={"arrowstyle": "->", "color": colour})
        elif float(row["separated_at"]) == 0:  # pressure alone separates walls
            axes.plot(*place, "o", color=colour, markersize=8, fillstyle="none")


@described(__doc__)
@click.option("--tissue", "tissues", multiple=True, type=click.Choice([*TISSUES]), help="Only these.")
@click.option("--seeds", default=3, show_default=True, help="Number of Voronoi tissues.")
@click.option("--cohesion", "strengths", multiple=True, type=float, help="Only these strengths of cohesion.")
@click.option("--show", is_flag=True, help="Draw what is in the table, and run nothing.")
def command(tissues: Sequence[str], seeds: int, strengths: Sequence[float], show: bool) -> None:
    """Run what is missing, and draw."""
    chosen = [(tissue, seed) for tissue in tissues or TISSUES for seed in range(seeds if tissue == "voronoi" else 1)]
    done = {tuple(row[key] for key in KEYS) for row in tables.read(TABLE)}
    for (tissue, seed), pressure, cohesion in product(chosen, PRESSURES, strengths or COHESION):
        key: tuple[Any, ...] = (tissue, seed, cohesion, pressure)
        if show or tuple(map(str, key)) in done:
            continue
        row = measured(*key)
        tables.append(TABLE, COLUMNS, [row])
        click.echo(", ".join(f"{name} {value}" for name, value in row.items()))
    draw(tables.read(TABLE))
    click.echo(f"{FIGURE}")
