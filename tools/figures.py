"""What holds cells together: gaps of the sheared tissue, a curve a pressure, an inclusion, a model of a filled cell.

    python tools/figures.py pressure [--tissue 5x7]     docs/gap-pressure-3x3.png
    python tools/figures.py inclusion                   docs/gap-inclusion-3x3.png
    python tools/figures.py models                      docs/gap-models-3x3.png
    python tools/figures.py fibres                      docs/gap-fibres-3x3.png
    python tools/figures.py free                        docs/pressure-free.png

Rows go to `tools/results/figures.csv`; runs that have rows are not repeated. The onset of a curve in the mean gap is
the plate displacement at which that reaches 5 % of the wall, as everywhere; in the largest gap that at which it reaches
the wall's thickness; in parted pairs that at which half of all pairs have parted. Curves are straight between levels.
"""

from __future__ import annotations

import math
from pathlib import Path

import click
import ngsolve
import numpy as np
import tables
from matplotlib.figure import Figure
from runs import Run

import ngcell
from ngcell.export import draw_tissue

ROOT = Path(__file__).resolve().parent.parent
TABLE = ROOT / "tools" / "results" / "figures.csv"
COLUMNS = (
    "tissue", "case", "setting", "strategy", "pairs", "displacement", "largest_gap", "mean_gap", "parted_pairs",
    "opened_share", "components", "largest_component", "mean_pressure", "plate_force", "contact_force", "energy", "certified",
    "failures", "seconds",
)  # fmt: skip
#: Plate displacements, as shares of the last, which is a fifth of the tissue's height.
LEVELS = "[0.03125, 0.0625, 0.09375, 0.125, 0.25, 0.5, 1.0]"
#: Those of `single-step`, which ends at the same equilibria, and of large scenes that cost much or are in no figure.
FEW_LEVELS = "[0.0625, 0.125, 0.25, 1.0]"
DEAR = ("c1=0.02", "c1=0.05", "c1=0.1", "shear-fibres", "shear-uniform-pressure")
TISSUES = {"3x3": (3, 3, 1.0), "5x7": (5, 7, 1.6)}
WALL = 0.1
#: What counts as onset: a gap, or a share of all pairs.
ONSET = {"mean_gap": 0.05 * WALL, "largest_gap": WALL, "parted_pairs": 0.5}
EMPTY = ("shear-empty", "", "empty")


def pressures() -> list[tuple[str, str, str]]:
    """Return case, settings and label of each curve."""
    values = (0.00125, 0.0025, 0.005, 0.01)
    return [("shear-pressurised", f"lumen.pressure={value}", f"pressure {value}") for value in values]


def inclusions() -> list[tuple[str, str, str]]:
    """Return case, settings and label of each curve: shear moduli, with bulk moduli a thousand times them."""
    values = (0.01, 0.02, 0.05, 0.1)
    keys = "lumen.material.c1={0}; lumen.material.bulk_modulus={1:g}"
    return [("shear-filled", keys.format(value, 1000 * value), f"modulus {value}") for value in values]


def fibres() -> list[tuple[str, str, str]]:
    """Return case, settings and label of each curve."""
    pair = "material.fibres.angles=[{0}.0, -{0}.0]"
    return [("shear-fibres", pair.format(angle), f"fibres at {angle} degrees") for angle in (0, 30, 60)]


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
    pressures: dict[str, list[float]] = {}
    for cell in run.rows("cells.csv"):
        pressures.setdefault(cell["step"], []).append(float(cell["pressure"]))
    key = {"tissue": tissue, "case": case, "setting": setting, "strategy": strategy}
    failures = run.summary["failed_steps"]
    click.echo(f"{tissue} {case} {setting} {strategy}: {outcome}", err=True)
    return [
        key
        | level_row(row)
        | {
            "pairs": run.summary["facing_pairs"],
            "mean_pressure": sum(pressures[row["step"]]) / len(pressures[row["step"]]),
            "failures": " ".join(failures.get(row["step"], ())),
        }
        for row in run.levels()
    ]


def run_of(tissue: str, case: str, setting: str, strategy: str) -> Run:
    """Return the run behind a curve."""
    rows, cols, displacement = TISSUES[tissue]
    scene = [f"tissue.rows={rows}", f"tissue.cols={cols}", f"load.displacement=[{displacement}, 0.0]"]
    scene = scene if tissue == "3x3" else []  # the shipped cases are the larger tissue
    is_dear = tissue == "5x7" and any(text in f"{case} {setting}" for text in DEAR)
    levels = FEW_LEVELS if is_dear or strategy != "sddp" else LEVELS
    entries = (*setting.split("; "), *scene, f"strategy.kind={strategy}", f"load.levels={levels}")
    return Run(case, tuple(entry for entry in entries if entry))


def level_row(row: dict[str, str]) -> dict[str, str]:
    """Return the numbers of a level."""
    same = (
        "largest_gap", "mean_gap", "parted_pairs", "opened_share", "components", "largest_component", "contact_force", "energy",
        "certified", "seconds",
    )  # fmt: skip
    named = {"displacement": "plate_displacement", "plate_force": "plate_force_x"}
    return {name: row[name] for name in same} | {name: row[old] for name, old in named.items()}


def compute(name: str, tissue: str, strategy: str) -> None:
    """Run what has no rows yet."""
    for case, setting, _ in CURVES[name]:
        done = {(row["tissue"], row["case"], row["setting"], row["strategy"]) for row in tables.read(TABLE)}
        if (tissue, case, setting, strategy) not in done:
            tables.append(TABLE, COLUMNS, rows_of(tissue, case, setting, strategy))


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
            axes.plot(onsets[measure], np.interp(onsets[measure], x, y), "o", color=colour, markersize=8, mfc="none")
    for measure, axes in panels.items():
        axes.set(xlabel="plate displacement", ylabel=measures[measure], ylim=(0, None))
        axes.spines[["top", "right"]].set_visible(False)
    panels["largest_gap"].legend(frameon=False, fontsize=9)
    figure.savefig(ROOT / "docs" / f"gap-{name}-{tissue}.png", dpi=130)


def draw_free() -> None:
    """Show what pressure does where the sides are free and no plate moves."""
    sets = ["lumen.pressure=0.02", "load.displacement=[0.0, 0.0]", "load.levels=1", "strategy.kind=single-step"]
    *_, step = ngcell.simulate(ngcell.read_case("shear-pressurised", sets))
    names = ("largest_gap", "mean_gap", "parted_pairs", "certified")
    click.echo(", ".join(f"{name} {getattr(step.record, name)}" for name in names))
    title = "Pressure 0.02, free sides, no shear"
    draw_tissue(step.snapshot, ROOT / "docs" / "pressure-free.png", title=title, certified=step.record.certified)


@click.command()
@click.argument("name", type=click.Choice([*CURVES, "free"]))
@click.option("--tissue", default="3x3", show_default=True, type=click.Choice(list(TISSUES)))
@click.option("--strategy", default="sddp", show_default=True, type=click.Choice(["sddp", "single-step"]))
def main(name: str, tissue: str, strategy: str) -> None:
    """Draw one of the figures; the curves are those of sddp, single-step runs go to the table only."""
    ngsolve.SetNumThreads(1)
    if name == "free":
        draw_free()
        return
    compute(name, tissue, strategy)
    if strategy == "sddp":
        draw(name, tissue)


if __name__ == "__main__":
    main()
