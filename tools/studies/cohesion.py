"""Convergence of a cohesive tissue under refinement of load steps and mesh.

    python -m tools.studies cohesion [--case shear-empty-3x3] [--strength 0.05] [--energy 0.0015]

The tissue is loaded forward (`load-stepping`). Every row is one run: the largest plate force and where it is reached,
which is where walls snap apart, and at the end stored energy, energy of separation, loss, plate force and the share
still bonded. Rows go to `tools/results/cohesion.csv`; runs that have a row are not repeated.
"""

from __future__ import annotations

import click

import ngcell
from tools import tables
from tools.commands import described
from tools.places import RESULTS

TABLE = RESULTS / "cohesion.csv"
KEYS = ("case", "strength", "energy", "size", "steps")
COLUMNS = (
    *KEYS, "accepted", "largest_force", "at_displacement", "stored_energy", "separation_energy", "dissipation",
    "plate_force", "bonded_share", "mean_gap", "iterations", "certified",
)  # fmt: skip
#: Element size and load steps of the runs.
RUNS = [(0.5, 5), (0.5, 10), (0.5, 20), (0.5, 40), (0.5, 160), (0.25, 5), (0.125, 5)]


def measured(case: str, strength: float, energy: float, size: float, steps: int) -> dict[str, object]:
    """Run once, and return the row."""
    sets = [f"cohesion.strength={strength}", f"cohesion.energy={energy}", "strategy.kind=load-stepping"]
    sets += [f"mesh.size={size}", f"strategy.steps={steps}"]
    records = [step.record for step in ngcell.simulate(ngcell.read_case(case, [*sets, "accuracy=inf"]))]
    last, top = records[-1], max(records, key=lambda record: record.plate_force_x)
    return {
        "case": case,
        "strength": strength,
        "energy": energy,
        "size": size,
        "steps": steps,
        "accepted": len(records),
        "largest_force": f"{top.plate_force_x:.5g}",
        "at_displacement": f"{top.plate_displacement:.4f}",
        "stored_energy": f"{last.energy:.5g}",
        "separation_energy": f"{last.separation_energy:.5g}",
        "dissipation": f"{last.dissipation:.4g}",
        "plate_force": f"{last.plate_force_x:.5g}",
        "bonded_share": f"{last.bonded_share:.4f}",
        "mean_gap": f"{last.mean_gap:.4g}",
        "iterations": sum(record.iterations for record in records),
        "certified": all(record.certified for record in records),
    }


@described(__doc__)
@click.option("--case", default="shear-empty-3x3", show_default=True)
@click.option("--strength", default=0.05, show_default=True)
@click.option("--energy", default=0.0015, show_default=True)
def command(case: str, strength: float, energy: float) -> None:
    """Run what is missing."""
    done = {tuple(row[key] for key in KEYS) for row in tables.read(TABLE)}
    for size, steps in RUNS:
        if tuple(map(str, (case, strength, energy, size, steps))) in done:
            continue
        row = measured(case, strength, energy, size, steps)
        tables.append(TABLE, COLUMNS, [row])
        click.echo(", ".join(f"{name} {value}" for name, value in row.items()))
