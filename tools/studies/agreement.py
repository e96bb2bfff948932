"""Penalty and mortar on the sheared tissue: one value as the penalty grows and the mesh is refined.

    python -m tools.studies agreement [--case shear-empty] [--displacement 0.4]

Each run is one released level. Rows go to `tools/results/agreement.csv`; runs that have a row are not repeated. The
figure is `docs/agreement.png`.
"""

from __future__ import annotations

import math
from time import process_time

import click
from matplotlib.figure import Figure

import ngcell
from tools import tables
from tools.commands import described
from tools.places import DOCS, RESULTS

TABLE, FIGURE = RESULTS / "agreement.csv", DOCS / "agreement.png"
COLUMNS = (
    "case", "displacement", "size", "method", "stiffness", "energy", "plate_force", "mean_gap", "parted_pairs",
    "penetration_over_wall", "iterations", "factorisations", "seconds", "certified",
)  # fmt: skip
SIZES = (0.5, 0.25)
STIFFNESSES = (0.1, 1.0, 10.0, 100.0)


def measured(case: str, displacement: float, size: float, method: str, stiffness: float) -> dict[str, object]:
    """Run one level, and return its row."""
    sets = [f"load.displacement=[{displacement}, 0.0]", "load.levels=1", "strategy.kind=single-step"]
    sets += [f"mesh.size={size}", f"contact.kind={method}"]
    sets += [f"contact.stiffness={stiffness}"] if method == "penalty" else []
    started = process_time()
    *_, step = ngcell.simulate(ngcell.read_case(case, [*sets, "accuracy=inf"]))
    seconds = process_time() - started
    record = step.record
    checks = {check.name: check.value for check in step.measurement.certificate.checks}
    return {
        "case": case,
        "displacement": displacement,
        "size": size,
        "method": method,
        "stiffness": stiffness,
        "energy": record.energy,
        "plate_force": math.hypot(record.plate_force_x, record.plate_force_y),
        "mean_gap": record.mean_gap,
        "parted_pairs": record.parted_pairs,
        "penetration_over_wall": checks["penetration_over_wall"],
        "iterations": record.iterations,
        "factorisations": record.factorisations,
        "seconds": round(seconds, 2),
        "certified": record.certified,
    }


def draw(case: str, displacement: float) -> None:
    """Draw energy and plate force over the stiffness, a line a mesh, the mortar's value as a level."""
    rows = [row for row in tables.read(TABLE) if row["case"] == case and float(row["displacement"]) == displacement]
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    for axes, column, name in zip(
        figure.subplots(1, 3),
        ("energy", "plate_force", "penetration_over_wall"),
        ("stored energy", "plate force", "deepest overlap / wall"),
        strict=True,
    ):
        for size, colour in zip(SIZES, ("tab:blue", "tab:orange"), strict=True):
            here = [row for row in rows if float(row["size"]) == size]
            penalty = sorted((float(r["stiffness"]), float(r[column])) for r in here if r["method"] == "penalty")
            axes.semilogx(*zip(*penalty, strict=True), "o-", color=colour, label=f"penalty, h = {size:g}")
            for row in here:
                if row["method"] == "mortar":
                    axes.axhline(float(row[column]), color=colour, linestyle="--", label=f"mortar, h = {size:g}")
        if column == "penetration_over_wall":
            axes.set_yscale("log")
        axes.set(xlabel="penalty stiffness / default", title=name)
    axes.legend(fontsize=7)
    figure.suptitle(f"{case}, plate displacement {displacement:g}", fontsize=10)
    figure.savefig(FIGURE, dpi=130)


@described(__doc__)
@click.option("--case", default="shear-empty", show_default=True)
@click.option("--displacement", default=0.4, show_default=True)
def command(case: str, displacement: float) -> None:
    """Run what is missing, and draw."""
    wanted = [(size, "mortar", 1.0) for size in SIZES]
    wanted += [(size, "penalty", stiffness) for size in SIZES for stiffness in STIFFNESSES]
    done = {
        (r["case"], float(r["displacement"]), float(r["size"]), r["method"], float(r["stiffness"]))
        for r in tables.read(TABLE)
    }
    for size, method, stiffness in wanted:
        if (case, displacement, size, method, stiffness) in done:
            continue
        row = measured(case, displacement, size, method, stiffness)
        tables.append(TABLE, COLUMNS, [row])
        click.echo(", ".join(f"{name} {value}" for name, value in row.items()))
    draw(case, displacement)
