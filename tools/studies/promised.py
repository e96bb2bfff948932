"""Errors promised and found in the runs of the study of error against run time, each with its own mesh.

    python -m tools.studies promised [--only TEXT]

`work-precision` compares meshes and methods without an accuracy, so that nothing is promised. Here each of its
settings is run once more at an accuracy of 0.1, with the order and the size of its mesh kept: one order more tells its
error, and what errs by more than a tenth is not certified. What is found is relative to a mesh of order 6 with the
mortar method, and for tissues to the same scene at an accuracy of 0.003, whose own errors are added to those promised.
Where a tissue's mesh has led walls to another equilibrium, that counts as found.

Rows go to `tools/results/promised.csv`; runs that have a row of the present sources are not repeated.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache
from math import inf
from typing import Any

import click

import ngcell
from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.runs import sources
from tools.solutions import solved
from tools.studies.work_precision.grid import Setting, grid
from tools.studies.work_precision.solve import scene_of

TABLE, REPORT = RESULTS / "promised.csv", RESULTS / "promised.md"
ACCURACY, _FINE, _HIGHEST = 0.1, 0.003, 6
NUMBERS = ("energy", "plate_force", "contact_force", "mean_gap")
COLUMNS = (
    "run", "kind", "problem", "order", "certified", *(part for name in NUMBERS for part in (name, f"{name}_error")),
    *(f"true_{name}" for name in NUMBERS), *(f"true_{name}_error" for name in NUMBERS), "code",
)  # fmt: skip
#: Numbers below this are none, in scenes of size and modulus one.
_NOTHING = 1e-9


def told(scene: Any) -> dict[str, float]:
    """Return numbers and errors of the last step of a scene, and whether all are certified."""
    solution = solved(scene)
    record = solution.last.record
    force = (record.plate_force_x**2 + record.plate_force_y**2) ** 0.5
    values = {name: force if name == "plate_force" else getattr(record, name) for name in NUMBERS}
    errors = {f"{name}_error": getattr(record, f"{name}_error") for name in NUMBERS}
    return {**values, **errors, "certified": solution.certified}


@cache
def truth(setting: Setting) -> dict[str, float]:
    """Return what the numbers of a setting's scene are on a fine mesh."""
    if setting.kind != "tissue":
        fine = replace(setting, order=_HIGHEST, method="mortar")
        return told(scene_of(fine, inf))
    sets = [f"accuracy={_FINE}", f"strategy.kind={setting.strategy}", f"load.levels={setting.steps}"]
    return told(ngcell.read_case(setting.case, [*sets, *setting.overrides]))


def compared(setting: Setting) -> dict[str, Any]:
    """Return the row of a setting."""
    coarsest = 1.0 if setting.kind == "case" else 0.125  # truths are not made anew for each mesh
    fine = truth(replace(setting, order=_HIGHEST, method="", size=coarsest))
    row = {"run": setting.label, "kind": setting.kind, "problem": setting.problem, "order": setting.order}
    row |= told(scene_of(setting, ACCURACY)) | {"code": sources()}
    return row | {f"true_{name}": value for name, value in fine.items() if name != "certified"}


def off(row: Mapping[str, str], name: str) -> float:
    """Return the error that is found over that which is promised."""
    fine = float(row[f"true_{name}_error"] or "nan")
    allowed = float(row[f"{name}_error"]) + (0.0 if fine != fine else fine)
    found = abs(float(row[name]) - float(row[f"true_{name}"]))
    return found / max(allowed, _NOTHING)


def report(rows: Iterable[Mapping[str, str]]) -> str:
    """Return the table: how many are certified, and how many of them are further off than they say."""
    rows = list(rows)
    lines: list[list[Any]] = []
    for kind in dict.fromkeys(row["kind"] for row in rows):
        for order in sorted({row["order"] for row in rows if row["kind"] == kind}):
            mine = [row for row in rows if (row["kind"], row["order"]) == (kind, order)]
            certified = [row for row in mine if row["certified"] == "True"]
            counts = [sum(off(row, name) > 1 for row in certified) for name in NUMBERS]
            lines.append([kind, order, len(mine), len(certified), *counts])
    columns = ["kind", "order", "runs", "certified", *(name.replace("_", " ") for name in NUMBERS)]
    text = "\n".join((__doc__ or "").strip().splitlines()[4:])
    further = [
        [row["run"], name.replace("_", " "), *_shares(row, name)]
        for row in rows
        for name in NUMBERS
        if row["certified"] == "True" and off(row, name) > 1
    ]
    codes = f"Sources {', '.join(sorted({row['code'] for row in rows}))}."
    codes += " Columns of numbers count certified runs that err by more than they say."
    beyond = tables.markdown(["run", "number", "promised", "found"], further)
    table = tables.markdown(columns, lines)
    return f"# Errors promised and found, mesh by mesh\n\n{text}\n\n{codes}\n\n{table}\n\n{beyond}\n"


def _shares(row: Mapping[str, str], name: str) -> list[str]:
    scale = abs(float(row[f"true_{name}"])) or 1.0
    found = abs(float(row[name]) - float(row[f"true_{name}"]))
    return [f"{100 * value / scale:.2g} %" for value in (float(row[f"{name}_error"]), found)]


@described(__doc__)
@click.option("--only", default="", help="Take the runs whose key contains this text.")
def command(only: str) -> None:
    """Run what is missing, and write the table."""
    known = {row["run"] for row in tables.read(TABLE) if row["code"] == sources()}
    for setting in grid(quick=False):
        if setting.label in known or only not in setting.label:
            continue
        try:
            row = compared(setting)
        except ngcell.NotConverged as error:
            click.echo(f"{setting.label}: {error}")
            continue
        kept = [old for old in tables.read(TABLE) if old["run"] != setting.label]
        tables.write(TABLE, COLUMNS, [*kept, row])
        click.echo(f"{setting.label}: certified {row['certified']}")
    REPORT.write_text(report(tables.read(TABLE)), encoding="utf-8")
