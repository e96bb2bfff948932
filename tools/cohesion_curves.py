"""How cohesion delays debonding: gaps, parted pairs and plate force of the sheared 5x7 tissue at three strengths.

    python tools/cohesion_curves.py [--strategy single-step] [--strategy sddp] [--draw]

Strength 0 is unilateral contact. A row an accepted step goes to `tools/results/cohesion-curves.csv` when a run has
ended; runs that are there are not repeated, and those of `tools/certify.py` are taken over. The figure is
`docs/cohesion.png`.
"""

from __future__ import annotations

import csv
from pathlib import Path

import click
from certify import STRENGTHS, bonded, run_behind
from runs import Run

ROOT = Path(__file__).resolve().parent.parent
TABLE, FIGURE = ROOT / "tools" / "results" / "cohesion-curves.csv", ROOT / "docs" / "cohesion.png"
MEASURED = (
    "plate_displacement", "plate_force_x", "mean_gap", "largest_gap", "parted_pairs", "energy", "separation_energy",
    "dissipation", "bonded_share", "iterations", "certified",
)  # fmt: skip
COLUMNS = ("strategy", "strength", *MEASURED)
COLOURS = ("#8a8f98", "#4a7a3a", "#1f5f8b", "#b3361e")


def walked(strategy: str, strength: float) -> list[dict[str, object]]:
    """Run once, and return the rows of its released steps."""
    if strength:
        run = run_behind("shear-cohesive", bonded(strength), strategy)
    else:
        run = Run("shear-empty", ("mesh.size=0.34", f"strategy.kind={strategy}"))
    outcome = run.solve(timeout=7200)
    click.echo(f"{strategy}, strength {strength:g}: {outcome}")
    key = {"strategy": strategy, "strength": strength}
    return [key | {name: row.get(name, "") for name in MEASURED} for row in run.levels()]


def read_rows() -> list[dict[str, str]]:
    """Return the rows that are there."""
    return list(csv.DictReader(TABLE.open())) if TABLE.exists() else []


def draw() -> None:
    """Draw plate force, mean gap and parted pairs over the displacement, a colour a strength; markers are SDDP."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 3.6), layout="constrained")
    rows = read_rows()
    for axes, column, name in zip(
        figure.subplots(1, 3),
        ("plate_force_x", "mean_gap", "parted_pairs"),
        ("plate force", "mean gap", "parted wall pairs"),
        strict=True,
    ):
        for strength, colour in zip((0.0, *STRENGTHS), COLOURS, strict=True):
            for strategy, style in (("single-step", "-"), ("sddp", "o")):
                mine = [r for r in rows if float(r["strength"]) == strength and r["strategy"] == strategy]
                x = [0.0, *(float(row["plate_displacement"]) for row in mine)]
                y = [0.0, *(float(row[column]) for row in mine)]
                label = (f"strength {strength:g}" if strength else "no cohesion") if style == "-" else None
                axes.plot(x, y, style, color=colour, label=label, markersize=4, fillstyle="none", linewidth=1.6)
        axes.set(xlabel="plate displacement", title=name)
    figure.axes[0].legend(fontsize=8, frameon=False)
    figure.savefig(FIGURE, dpi=130)


@click.command(help=__doc__)
@click.option("--strategy", "strategies", multiple=True, default=("single-step", "sddp"), show_default=True)
@click.option("--draw", "only_draw", is_flag=True, help="Draw what is there, and run nothing.")
def main(strategies: tuple[str, ...], only_draw: bool) -> None:
    """Run what is missing, and draw."""
    TABLE.parent.mkdir(exist_ok=True)
    for strategy, strength in () if only_draw else [(s, g) for s in strategies for g in (0.0, *STRENGTHS)]:
        if any(r["strategy"] == strategy and float(r["strength"]) == strength for r in read_rows()):
            continue
        rows, is_new = walked(strategy, strength), not TABLE.exists()
        with TABLE.open("a", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            if is_new:
                writer.writeheader()
            writer.writerows(rows)
    draw()


if __name__ == "__main__":
    main()
