"""The map of extreme scenes: what came of every point, why, and how far stiff answers move when perturbed."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Iterable
from datetime import date
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from tools import tables
from tools.extreme.causes import CAUSES
from tools.extreme.outcomes import Row, difference

COLOURS = {"certified": "#bfe3c0", "named": "#ffe2a8", "WRONG": "#f2a6a0"}
PER_LINE = 8
#: How stiff points are perturbed, in the order of the columns.
PERTURBATIONS = ("mesh", "steps", "penalty", "tolerance")


def report(rows: list[Row], asked: int, text: Path, figure: Path | None) -> None:
    """Write the map as Markdown, and as a figure if there is a place for it."""
    if not rows:
        return
    points = [row for row in rows if not row.perturbed]
    groups: dict[str, list[Row]] = {}
    for row in points:
        groups.setdefault(row.group, []).append(row)
    parts = [_head(rows), _sentences(points, asked), _causes(points), _spread(rows), "## The map\n"]
    parts += [_table(group, mine) for group, mine in groups.items()]
    text.write_text("\n".join(parts))
    if figure is not None:
        draw(groups, figure)


def _head(rows: list[Row]) -> str:
    codes = ", ".join(sorted({row.code for row in rows}))
    return (
        f"# Stiff and extreme scenes\n\n{date.today()}, {platform.machine()}, {os.cpu_count()} cores, sources {codes}. "
        "`python -m tools.extreme map` makes this; what\nthe groups are is told in `tools/extreme/mechanics.py` and "
        "`tools/extreme/numerics.py`. Seconds are those of the processor, imports included.\n"
    )


def _sentences(points: list[Row], asked: int) -> str:
    solvable = [row for row in points if row.has_solution]
    certified = [row for row in solvable if row.outcome == "certified"]
    without = [row for row in points if not row.has_solution]
    wrong = [row for row in points if row.outcome == "WRONG"]
    exact = [row.error for row in certified if math.isfinite(row.error)]
    lines = [
        f"- {len(certified)} of {len(solvable)} points that have a solution are certified, "
        f"{len(certified) / len(solvable):.1%}.",
    ]
    if len(points) < asked:
        lines.insert(0, f"- {len(points)} of {asked} points were run, quick ones first; the rest may be worse.")
    if without:
        named = sum(row.outcome == "named" for row in without)
        lines.append(f"- {named} of {len(without)} points that have none end as a named outcome.")
    lines.append(f"- {len(wrong)} points end wrong.")
    if exact:
        lines.append(
            f"- {len(exact)} certified points have an exact answer or one that they must repeat; the largest error is "
            f"{max(exact):.1e}."
        )
    return "\n".join(["## What came of them\n", *lines, ""])


def _causes(points: list[Row]) -> str:
    failed = [row for row in points if row.has_solution and row.outcome != "certified"]
    if not failed:
        return ""
    lines = [(row.label, f"{row.outcome}: {row.cause}", _why(row)) for row in failed]
    return f"## Why points are not certified\n\n{tables.markdown(('point', 'outcome', 'cause'), lines)}\n"


def _why(row: Row) -> str:
    return next((why for start, why in CAUSES.items() if row.label.startswith(start)), "not looked into")


def _spread(rows: list[Row]) -> str:
    labels = dict.fromkeys(row.perturbed for row in rows if row.perturbed)
    if not labels:
        return ""
    head = (
        "## How stable stiff answers are\n\n"
        "Largest relative change of energy, plate force, contact force, mean and largest gap (of numbers below a\n"
        "thousandth, the change in thousandths) when elements are three quarters as long, with three times the steps,\n"
        "with a penalty three times as stiff, and when equilibria end at a decrement 10⁴ times larger. The last\n"
        "column is the spread of the energy.\n\n"
    )
    columns = ("point", *PERTURBATIONS, "energy")
    return f"{head}{tables.markdown(columns, [_moved(label, rows) for label in labels])}\n"


def _moved(label: str, rows: list[Row]) -> tuple[str, ...]:
    """Return how far the answer of a point moves under each perturbation."""
    base = [row for row in rows if row.label == label]
    mine = [row for row in rows if row.perturbed == label]
    if not base or base[0].outcome != "certified":
        return label, "not certified", *[""] * len(PERTURBATIONS)
    found = {
        row.label.rpartition("; ")[2]: _number(difference(row, base[0])) if row.outcome == "certified" else row.outcome
        for row in mine
    }
    energies = [row.energy for row in [*base, *mine] if row.outcome == "certified"]
    spread = (max(energies) - min(energies)) / max(map(abs, energies))
    return label, *(found.get(name, "") for name in PERTURBATIONS), f"{spread:.0e}"


def _table(group: str, rows: Iterable[Row]) -> str:
    columns = ("setting", "outcome", "iterations", "refused", "cut-backs", "smallest J", "condition", "overlap / wall",
               "error", "s")  # fmt: skip
    return f"### {group}\n\n{tables.markdown(columns, map(_line, rows))}\n"


def _line(row: Row) -> tuple[str, ...]:
    outcome = row.outcome + (f": {row.cause}" if row.cause else "") + ("" if row.has_solution else " (has no solution)")
    numbers = (row.smallest_jacobian, row.condition, row.penetration, row.error, row.seconds)
    return row.setting, outcome, str(row.iterations), str(row.refused), str(row.cut_backs), *map(_number, numbers)


def _number(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.2g}"


def draw(groups: dict[str, list[Row]], path: Path) -> None:
    """Draw a tile a point: green is certified, yellow named, red wrong; with the setting, iterations and cut-backs."""
    lines = [(group, mine[n : n + PER_LINE]) for group, mine in groups.items() for n in range(0, len(mine), PER_LINE)]
    figure = Figure(figsize=(13.5, 0.36 * len(lines) + 0.5), dpi=110)
    axes = figure.add_axes((0.105, 0.0, 0.89, 0.97))
    before = ""
    for line, (group, mine) in enumerate(lines):
        if group != before:
            axes.text(-0.05, line + 0.5, group, ha="right", va="center", fontsize=8.5, weight="bold")
        before = group
        for place, row in enumerate(mine):
            axes.add_patch(Rectangle((place, line), 0.97, 0.92, color=COLOURS[row.outcome]))
            cost = f"{row.iterations} it" + (f", {row.cut_backs} cut" if row.cut_backs else "")
            name = row.setting if row.has_solution else f"{row.setting} (no solution)"
            axes.text(place + 0.485, line + 0.46, f"{name}\n{cost}", ha="center", va="center", fontsize=5.8)
    axes.set(xlim=(0, PER_LINE), ylim=(len(lines), -0.1))
    axes.axis("off")
    legend = [Patch(color=colour, label=name) for name, colour in COLOURS.items()]
    figure.legend(handles=legend, loc="upper right", ncols=3, frameon=False, fontsize=8.5)
    figure.savefig(path)
