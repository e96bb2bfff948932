"""Tissues by each kind of contact: the same mesh, the same path, what they end with and what it takes.

    python -m tools.studies contact-kinds

One level of each scene on the mesh of its load path, with processor seconds on one thread. The error of each energy is
told against the mortar method on that mesh, whose result knows no stiffness.
"""

from __future__ import annotations

from time import process_time
from typing import Any

import click

import ngcell
from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.solutions import solved

PRESSED = ('lumen.kind="pressure"', "lumen.pressure=0.01")
SCENES: dict[str, tuple[str, tuple[str, ...]]] = {
    "3x3 to 1.0": ("shear-empty-3x3", ()),
    "3x3 to 1.0 under pressure": ("shear-empty-3x3", PRESSED),
    "5x7 to 1.6": ("shear-empty", ()),
}
#: Kind and multiple of its stiffness; the reference first.
METHODS = (("mortar", None), ("penalty", 1.0), ("penalty", 10.0), ("ngsolve", 1.0), ("ngsolve", 10.0))
COLUMNS = (
    "scene", "contact", "stiffness", "energy", "off the mortar's", "plate force x", "mean gap", "certified",
    "iterations", "factorisations", "seconds",
)  # fmt: skip


def row(scene: str, kind: str, stiffness: float | None) -> dict[str, Any]:
    """Solve a scene by a kind of contact."""
    name, sets = SCENES[scene]
    own = [] if stiffness is None else [f"contact.stiffness={stiffness}"]
    case = ngcell.read_case(name, ["load.levels=1", "accuracy=inf", f"contact.kind={kind}", *sets, *own])
    started = process_time()
    solution = solved(case)
    seconds, record = process_time() - started, solution.last.record
    numbers = (record.energy, 0.0, record.plate_force_x, record.mean_gap, solution.certified)
    effort = (solution.iterations, solution.factorisations, round(seconds, 1))
    return dict(zip(COLUMNS, (scene, kind, stiffness or "", *numbers, *effort), strict=True))


@described(__doc__)
@click.option("--scene", "only", default="", help="Only scenes whose names hold this.")
def command(only: str) -> None:
    """Solve all scenes by all kinds and write the tables."""
    table = RESULTS / "contact-kinds.csv"
    rows: list[dict[str, Any]] = [line for line in tables.read(table) if only and only not in line["scene"]]
    for scene in SCENES:
        found = [row(scene, *method) for method in METHODS] if only in scene else []
        for line in found:
            line["off the mortar's"] = f"{line['energy'] / found[0]['energy'] - 1:+.1e}"
            click.echo(", ".join(map(str, line.values())), err=True)
        rows += found
    tables.write(table, COLUMNS, rows)
    shown = [[_shown(line[name]) for name in COLUMNS] for line in rows]
    text = f"# Kinds of contact on tissues\n\n{(__doc__ or '').splitlines()[0]}\n\n{tables.markdown(COLUMNS, shown)}\n"
    (RESULTS / "contact-kinds.md").write_text(text, encoding="utf-8")


def _shown(value: Any) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)
