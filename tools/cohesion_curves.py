"""How cohesion delays debonding: gaps, parted pairs and plate force of the sheared 5x7 tissue at three strengths.

    python tools/cohesion_curves.py [--strategy single-step] [--strategy sddp] [--draw]

Strength 0 is unilateral contact. A row an accepted step goes to `tools/results/cohesion-curves.csv` when a run has
ended; runs that are there are not repeated. The figure is `docs/cohesion.png`.
"""

from __future__ import annotations

import csv
from pathlib import Path
from time import process_time

import click
import ngsolve
from threadpoolctl import threadpool_limits

import ngcell
from ngcell.simulation import Simulation

ROOT = Path(__file__).resolve().parent.parent
TABLE, FIGURE = ROOT / "tools" / "results" / "cohesion-curves.csv", ROOT / "docs" / "cohesion.png"
STRENGTHS, ENERGY_OVER_STRENGTH = (0.0, 0.0125, 0.025, 0.05), 0.03
MEASURED = (
    "plate_displacement", "plate_force_x", "mean_gap", "largest_gap", "parted_pairs", "energy", "separation_energy",
    "dissipation", "bonded_share", "iterations", "certified",
)  # fmt: skip
COLUMNS = ("strategy", "strength", *MEASURED, "energy_balance", "penetration_over_wall")
COLOURS = ("#8a8f98", "#4a7a3a", "#1f5f8b", "#b3361e")


def walked(strategy: str, strength: float) -> list[dict[str, object]]:
    """Run once, and return the rows of its released steps."""
    sets = [f"strategy.kind={strategy}"]
    if strength:
        sets += [f"cohesion.strength={strength}", f"cohesion.energy={strength * ENERGY_OVER_STRENGTH}"]
    else:
        sets += ["mesh.size=0.34"]
    rows = []
    for step in Simulation(ngcell.read_case("shear-cohesive" if strength else "shear-empty", sets)).walk():
        checks = {check.name: check.value for check in step.measurement.certificate.checks}
        if step.record.phase == "contact":
            rows.append(
                {
                    "strategy": strategy,
                    "strength": strength,
                    **{name: getattr(step.record, name) for name in MEASURED},
                    "energy_balance": checks.get("energy_balance", 0.0),
                    "penetration_over_wall": checks["penetration_over_wall"],
                }
            )
    return rows


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
        for strength, colour in zip(STRENGTHS, COLOURS, strict=True):
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
    ngsolve.SetNumThreads(1)
    TABLE.parent.mkdir(exist_ok=True)
    for strategy, strength in () if only_draw else [(s, g) for s in strategies for g in STRENGTHS]:
        if any(r["strategy"] == strategy and float(r["strength"]) == strength for r in read_rows()):
            continue
        started = process_time()
        with threadpool_limits(1, user_api="blas"):
            rows = walked(strategy, strength)
        is_new = not TABLE.exists()
        with TABLE.open("a", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            if is_new:
                writer.writeheader()
            writer.writerows(rows)
        click.echo(f"{strategy}, strength {strength:g}: {len(rows)} steps, {process_time() - started:.0f} s")
    draw()


if __name__ == "__main__":
    main()
