"""Counts of a tissue whose plate displacements differ by round-off only.

    python -m tools.studies last-digits [--case shear-empty-3x3] [--runs 20]

Each run is one released level; run k moves the plate by (1 + k eps) times the displacement of the case. Parted wall
pairs, connected components and the energy of all runs go to `tools/results/last-digits.csv`.
"""

from __future__ import annotations

import click
import numpy as np

import ngcell
from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.runs import sources

TABLE = RESULTS / "last-digits.csv"
COLUMNS = ("case", "run", "code", "displacement", "energy", "mean_gap", "parted_pairs", "components", "certified")


def measured(case: str, run: int) -> dict[str, object]:
    """Run one level, and return its row."""
    whole = ngcell.read_case(case)
    assert isinstance(whole, ngcell.Case)
    x, y = (float(part) for part in whole.load.displacement)
    moved = x * (1 + run * float(np.finfo(float).eps))
    *_, step = ngcell.simulate(ngcell.read_case(case, [f"load.displacement=[{moved!r}, {y!r}]", "load.levels=1"]))
    record = step.record
    return {
        "case": case,
        "run": run,
        "code": sources(),
        "displacement": repr(moved),
        **{name: getattr(record, name) for name in COLUMNS[4:]},
    }


@described(__doc__)
@click.option("--case", default="shear-empty-3x3", show_default=True)
@click.option("--runs", default=20, show_default=True, type=click.IntRange(min=1))
def command(case: str, runs: int) -> None:
    """Run, and tell how many different counts there were."""
    rows = [measured(case, run) for run in range(runs)]
    kept = [row for row in tables.read(TABLE) if row["case"] != case]
    tables.write(TABLE, COLUMNS, [*kept, *rows])
    for name in ("parted_pairs", "components"):
        click.echo(f"{name}: {sorted({str(row[name]) for row in rows})}")
    energies = np.array([row["energy"] for row in rows], dtype=float)
    click.echo(f"spread of the energy: {np.ptp(energies) / np.abs(energies).max():.1e}")
