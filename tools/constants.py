"""What results depend on: the solver's own numbers, each halved and doubled or more, beside what they do to four scenes.

    python -m tools.constants [--only TEXT]

Each number is put in place of the package's, a 3x3 tissue is run again, and what changes is told relative to the run
with all numbers as they are: energy and plate force, and the ratio of iterations. Tables are kept in
`tools/results/constants.csv` and `.md`.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import date
from functools import partial
from importlib import import_module
from pathlib import Path

import click
import ngsolve

import ngcell
from ngcell import simulation
from ngcell.errors import NgcellError
from ngcell.solve.step import StepFailed

RESULTS = Path(__file__).resolve().parent / "results"

SCENES = {
    "empty": ["load.levels=1"],
    "pressurised": ["load.levels=1", 'lumen.kind="pressure"', "lumen.pressure=0.0025"],
    "filled": ["load.levels=1", "load.displacement=[0.4, 0.0]", 'lumen.kind="inclusion"',
               'lumen.material.kind="mooney-rivlin"', "lumen.material.c1=0.01", "lumen.material.c2=0.01",
               "lumen.material.bulk_modulus=1.0"],
    "mortar": ["load.levels=1", "load.displacement=[0.4, 0.0]", 'contact.kind="mortar"'],
}  # fmt: skip
#: Module, name, and the values in place of the package's.
CHANGES: tuple[tuple[str, str, tuple[float, ...]], ...] = (
    ("solve.selection", "FIRST", (1e2, 1e4)),
    ("solve.selection", "LAST", (1e-8, 1e-10)),
    ("solve.selection", "ENOUGH", (1e-6, 1e-8)),
    ("solve.selection", "NARROWEST", (0.25, 1.0)),
    ("solve.selection", "WIDEST", (0.5, 2.0)),
    ("solve.selection", "LAST_DIGIT", (1e-7, 1e-5)),
    ("solve.selection", "STIFFEN_AT", (1e-6, 1e-4)),
    ("solve.selection", "ON_THE_WAY", (1e-3, 0.1)),
    ("solve.selection", "AT_THE_END", (1e-12, 1e-8)),
    ("solve.selection", "UPDATE", (0.05, 0.2)),
    ("solve.selection", "CHATTER", (100, 400)),
    ("solve.selection", "SLOW", (0.1, 0.5)),
    ("solve.penalty terms", "MOST_ROUNDS", (4, 16)),
    ("solve.penalty terms", "WORTHWHILE_GAIN", (0.01, 0.04)),
    ("solve.penalty terms", "LOST", (1e4, 1e8)),
    ("solve.minimise", "POOR", (1e-5, 1e-3)),
    ("solve.minimise", "FAIR", (0.1, 0.5)),
    ("solve.minimise", "RAISE", (4.0, 16.0)),
    ("solve.minimise", "LOWER", (0.05, 0.2)),
    ("solve.minimise", "FELT", (0.05, 0.2)),
    ("solve.minimise", "UNFELT", (1e-5, 1e-3)),
    ("solve.minimise", "STALLED", (1e-13, 1e-11)),
    ("solve.minimise", "IDLE", (3, 10)),
    ("contact.choice", "PATH_MULTIPLE", (0.5, 2.0)),
    ("contact.choice", "LADDER", (5.0, 20.0)),
    ("contact.choice", "HANDOVER_MULTIPLE", (2.0, 5.0)),
    ("contact.choice", "MORTAR_MULTIPLE", (1.0, 10.0)),
    ("contact.penalty", "BETWEEN", (1.5, 4.0)),
    ("contact.mortar", "ALLOWED", (1.25e-4, 5e-4)),
    ("contact.segments", "FACING", (-0.9, -0.7)),
)
#: Fields of `Release` that take their defaults from these names when the class is made.
_FIELDS = {"LAST": "last", "NARROWEST": "narrowest"}


@contextmanager
def changed(module: str, name: str, value: float) -> Iterator[None]:
    """Put a value in place of a number of the package."""
    places = [place for place in (import_module(f"ngcell.{module}"), simulation) if hasattr(place, name)]
    before, path = getattr(places[0], name), simulation.Continuation
    for place in places:
        setattr(place, name, value)
    if name in _FIELDS:
        simulation.Continuation = partial(path, **{_FIELDS[name]: value})
    try:
        yield
    finally:
        simulation.Continuation = path
        for place in places:
            setattr(place, name, before)


def run(scene: str) -> dict[str, float]:
    """Return energy, plate force and iterations of a scene; nothing if it found no equilibrium."""
    try:
        *_, step = simulation.Simulation(ngcell.read_case("shear-empty-3x3", SCENES[scene])).accepted_steps()
    except (NgcellError, StepFailed):
        return {}
    record = step.record
    return {
        "energy": record.energy,
        "force": record.plate_force_x,
        "iterations": record.iterations,
        "certified": float(record.certified),
    }


def table(rows: Sequence[dict[str, str | float]]) -> str:
    """Return the rows as Markdown."""
    lines = ["| " + " | ".join(rows[0]) + " |", "|" + "---|" * len(rows[0])]
    lines += ["| " + " | ".join(_shown(value) for value in row.values()) + " |" for row in rows]
    return "\n".join(lines)


def _shown(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.2g}"


@click.command(help=__doc__.split("\n")[0])
@click.option("--only", default="", help="Numbers whose name has this text.")
def main(only: str) -> None:
    """Run all changes in all scenes."""
    ngsolve.SetNumThreads(1)
    as_it_is = {scene: run(scene) for scene in SCENES}
    rows: list[dict[str, str | float]] = []
    for module, name, values in CHANGES:
        usual = getattr(import_module(f"ngcell.{module}"), name)
        for value in values if only in name else ():
            row: dict[str, str | float] = {"number": f"{module}.{name}", "usual": f"{usual:g}", "here": f"{value:g}"}
            for scene, base in as_it_is.items():
                with changed(module, name, value):
                    found = run(scene)
                for what in ("energy", "force"):
                    row[f"{scene}: {what}"] = found[what] / base[what] - 1 if found else "failed"
                row[f"{scene}: iterations"] = found["iterations"] / base["iterations"] if found else "failed"
                row[f"{scene}: certified"] = "yes" if found and found["certified"] else "no"
            rows.append(row)
            click.echo(" ".join(_shown(cell) for cell in row.values()), err=True)
    if only:
        return
    with (RESULTS / "constants.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    heads = "; ".join(f"{scene} {found['energy']:.6e}" for scene, found in as_it_is.items())
    (RESULTS / "constants.md").write_text(
        f"# What results depend on\n\n{date.today()}, {os.cpu_count()} cores. `python -m tools.constants` makes this: "
        "3x3 tissues, each number of the solver changed by itself.\nEnergies and plate forces are relative changes, "
        f"iterations a ratio. Energies as it is: {heads}.\n\n{table(rows)}\n"
    )


if __name__ == "__main__":
    main()
