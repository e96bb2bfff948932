"""How cohesion delays debonding: the sheared 5x7 tissue at three strengths.

    python -m tools.studies cohesion-curves

Curves are gaps, parted pairs and plate force; strength 0 is unilateral contact. A row an accepted step goes to
`tools/results/cohesion-curves.csv` when a run has ended; runs that are there are not repeated, and those of `python
-m tools.references certify` are taken over. The figure is `docs/cohesion.png`.
"""

from __future__ import annotations

import click
from matplotlib.figure import Figure

from tools import tables
from tools.commands import described
from tools.places import DOCS, RESULTS
from tools.runs import Run
from tools.sheared import BONDED, STRENGTHS, bonded, large_run

TABLE, FIGURE = RESULTS / "cohesion-curves.csv", DOCS / "cohesion.png"
MEASURED = (
    "plate_displacement", "plate_force_x", "mean_gap", "largest_gap", "parted_pairs", "energy", "separation_energy",
    "dissipation", "bonded_share", "iterations", "certified",
)  # fmt: skip
COLUMNS = ("strategy", "strength", *MEASURED)
RUNS = [("sddp", 0.0), *((strategy, strength) for strategy in BONDED for strength in STRENGTHS)]
COLOURS = ("#8a8f98", "#4a7a3a", "#1f5f8b", "#b3361e")


def followed(strategy: str, strength: float) -> list[dict[str, object]]:
    """Run once, and return the rows of its released steps."""
    if strength:
        run = large_run("shear-cohesive", bonded(strength), strategy)
    else:
        run = Run("shear-empty", ("mesh.size=0.34", f"strategy.kind={strategy}", "load.levels=4"))
    outcome = run.solve(timeout=7200)
    click.echo(f"{strategy}, strength {strength:g}: {outcome}")
    key = {"strategy": strategy, "strength": strength}
    return [key | {name: row.get(name, "") for name in MEASURED} for row in run.levels()]


def draw() -> None:
    """Draw plate force, mean gap and parted pairs over the displacement, a colour a strength; markers are SDDP."""
    figure, rows = Figure(figsize=(10, 3.6), layout="constrained"), tables.read(TABLE)
    names = {"plate_force_x": "plate force", "mean_gap": "mean gap", "parted_pairs": "parted wall pairs"}
    for axes, (column, name) in zip(figure.subplots(1, 3), names.items(), strict=True):
        for strategy, strength in RUNS:
            mine = [row for row in rows if (row["strategy"], float(row["strength"])) == (strategy, strength)]
            x = [0.0, *(float(row["plate_displacement"]) for row in mine)]
            y = [0.0, *(float(row[column]) for row in mine)]
            style = {"load-stepping": "-", "sddp": "o"}[strategy] if strength else "o:"
            label = None if style == "o" else f"strength {strength:g}" if strength else "no cohesion"
            colour = COLOURS[[0.0, *STRENGTHS].index(strength)]
            axes.plot(x, y, style, color=colour, label=label, markersize=4, fillstyle="none", linewidth=1.6)
        axes.set(xlabel="plate displacement", title=name, ylim=(0, None))
        axes.spines[["top", "right"]].set_visible(False)
    figure.axes[0].legend(fontsize=8, frameon=False)
    figure.savefig(FIGURE, dpi=130)


@described(__doc__)
def command() -> None:
    """Run what is missing, and draw."""
    for strategy, strength in RUNS:
        if any((row["strategy"], float(row["strength"])) == (strategy, strength) for row in tables.read(TABLE)):
            continue
        tables.append(TABLE, COLUMNS, followed(strategy, strength))
    draw()
