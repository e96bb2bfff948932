"""Errors promised and found: tissues at several accuracies against an overkill mesh.

    python -m tools.studies accuracy [--scene NAME] [--quick]

Each row is the last released level of a scene at one accuracy. What is found is what its numbers become as the state
goes on from there to the finest mesh, as by `ngcell solve --verify-mesh`: those of the same branch. The overkill mesh
of a scene is reached by an accuracy that no mesh meets, and may be on another branch.
Scenes of user-defined bodies, of bonds and of prisms are run at given orders, of which the highest is the overkill;
errors of the latter two are those that `ngcell solve --verify-mesh` tells. Effectivity is the error promised over the
error found; `tools.tail` tells what the tail is. Rows go to `tools/results/accuracy.csv`; runs that have a row of the
present sources are not repeated.
"""

from __future__ import annotations

from math import hypot, isfinite, nan
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import click

import ngcell
from ngcell.build.additions import Additions
from ngcell.build.verification import finest_result
from tools import tables
from tools.commands import described
from tools.places import RESULTS
from tools.runs import sources
from tools.tail import listened, tail_of

TABLE, REPORT, MEMBERS = RESULTS / "accuracy.csv", RESULTS / "accuracy.md", RESULTS / "members.csv"
ACCURACIES = (0.1, 0.03, 0.01, 0.003)
OVERKILL = 1e-4
#: Forces and gaps below this are none, in scenes of size and modulus one.
_NOTHING = 1e-9
NUMBERS = ("energy", "plate_force", "mean_gap")
_FINEST = tuple(f"finest_{name}" for name in NUMBERS)
MESH = ("order", "grading", "halvings", "unknowns")
COLUMNS = (
    "scene", "accuracy", "code", *(part for name in NUMBERS for part in (name, f"{name}_error")),
    *_FINEST, *MESH, "certified", "tail", "seconds",
)  # fmt: skip
SCENES: dict[str, tuple[str, tuple[str, ...]]] = {
    "3x3 to 0.4": ("shear-empty-3x3", ("load.displacement=[0.4, 0.0]", "load.levels=1")),
    "3x3 to 1.0": ("shear-empty-3x3", ("load.levels=1",)),
    "3x3 under 0.01": (
        "shear-empty-3x3",
        ("load.displacement=[0.4, 0.0]", "load.levels=1", 'lumen.kind="pressure"', "lumen.pressure=0.01"),
    ),
    "3x3 filled": ("shear-filled", ("tissue.rows=3", "tissue.cols=3", "load.displacement=[0.4, 0.0]", "load.levels=1")),
    "5x7 to 1.6": ("shear-empty", ("load.levels=1",)),
}
#: Scenes whose cases give an order, which is kept: each order is one row, and the highest the overkill.
GIVEN: dict[str, tuple[str, tuple[str, ...]]] = {
    "ring on hub": ("press-fit", ()),
    "closing rings": ("closing-rings", ()),
    "Hertz": ("hertz-cylinders", ("levels=1",)),
}
ORDERS = (1, 2, 3, 4, 6)
#: Scenes whose errors are not estimated: each order is verified by the next one.
VERIFIED: dict[str, tuple[str, tuple[str, ...]]] = {
    "2x2 bonded": (
        "shear-cohesive", ("tissue.rows=2", "tissue.cols=2", "load.displacement=[0.4, 0.0]", "load.levels=4")
    ),
    "3x3 bonded": (
        "shear-cohesive", ("tissue.rows=3", "tissue.cols=3", "load.displacement=[0.6, 0.0]", "load.levels=4")
    ),
    "2x2 prisms": ("shear-empty-3d", ("tissue.rows=2", "tissue.cols=2", "load.displacement=[0.3, 0.0]")),
}  # fmt: skip
#: Their orders.
_VERIFIED_ORDERS = {"2x2 bonded": (2, 3, 4, 6), "3x3 bonded": (2, 3, 4, 6), "2x2 prisms": (1, 2, 3, 4)}


def measured(scene: str, setting: str) -> dict[str, Any]:
    """Run a scene with an accuracy or an order, and return its row."""
    case, sets = (SCENES | GIVEN | VERIFIED)[scene]
    started, entries = process_time(), ngcell.read_case(case, [*sets, setting])
    if scene in VERIFIED:
        found = verified(entries, setting != settings(scene)[-1])
    else:
        with listened() as log:
            *_, step = ngcell.simulate(entries)
        errors = {f"{name}_error": getattr(step.record, f"{name}_error") for name in NUMBERS}
        mesh = {name: getattr(step.mesh, name) for name in MESH}
        found = numbers(step.record) | errors | mesh | {"tail": tail_of(log.getvalue())}
    row = {"scene": scene, "accuracy": setting, "code": sources(), **found}
    row["seconds"] = round(process_time() - started, 2)
    return row | (taken_on(entries) if scene in SCENES and setting != settings(scene)[-1] else {})


def taken_on(case: ngcell.AnyCase) -> dict[str, float]:
    """Return what the numbers of a case become on the finest mesh; nothing where that has no equilibrium beside."""
    try:
        finest = finest_result(case, Additions())
    except ngcell.NotConverged:
        return {}
    return {f"finest_{name}": finest[name]["finer"] for name in NUMBERS if name in finest}


def verified(case: ngcell.AnyCase, is_verified: bool) -> dict[str, Any]:
    """Run a case whose errors are not estimated, and return what its row has of it."""
    with TemporaryDirectory() as folder:
        recording = ngcell.record(case, Path(folder), threads=1, pictures=False, verify_mesh=is_verified)
        *_, last = recording
    finer, (mesh,) = recording.summary.get("finer_mesh", {}), recording.summary["meshes"]
    errors = {f"{name}_error": finer[name]["error"] if finer else nan for name in NUMBERS}
    return {**numbers(last), **errors, **{name: mesh[name] for name in MESH}}


def numbers(record: ngcell.StepRecord) -> dict[str, Any]:
    """Return the numbers of a step that are compared, and whether it is certified."""
    force = hypot(record.plate_force_x, record.plate_force_y)
    found = {name: force if name == "plate_force" else getattr(record, name) for name in NUMBERS}
    return found | {"certified": record.certified}


def members_of(scene: str, setting: str) -> str:
    """Return the name that the study of members has for a row."""
    return f"{scene} at {setting.partition('=')[2]}"


def within(row: dict[str, str], members: list[dict[str, str]]) -> list[tuple[str, bool, bool | None]]:
    """Return for each number whether the error found is within that promised, and whether the finest mesh's number is
    between those of members, widened by the error promised; None where no members are known."""
    told = []
    for name in NUMBERS:
        truth, error = float(row[f"finest_{name}"]), float(row[f"{name}_error"])
        mine = [one for one in members if one["scene"] == members_of(row["scene"], row["accuracy"])]
        reach = [(float(one["smallest"]), float(one["largest"])) for one in mine if one["number"] == name]
        scattered = None if not reach else reach[0][0] - error <= truth <= reach[0][1] + error
        told.append((name, abs(float(row[name]) - truth) <= error, scattered))
    return told


def _verdict(rows: list[dict[str, str]]) -> list[str]:
    """Return lines that count what is within its error, and name the rest."""
    members, lines = tables.read(MEMBERS), list[str]()
    taken = [row for row in rows if row.get("finest_energy") and row["certified"] == "True"]
    found = [(row, *one) for row in taken for one in within(row, members)]
    for name in NUMBERS:
        mine = [one for one in found if one[1] == name]
        kept = sum(one[2] for one in mine)
        what = name.replace("_", " ")
        lines.append(f"- {what}: {kept} of {len(mine)} certified rows err by no more than is promised.")
        for row, _, is_kept, scattered in mine:
            if not is_kept:
                words = {True: "within", False: "beyond", None: "not compared with"}[scattered]
                lines.append(f"  {row['scene']}, {row['accuracy']}: not, but {words} what its members scatter by.")
    return lines


def report() -> str:
    """Return the table of promised and found errors."""
    scenes = [*SCENES, *GIVEN, *VERIFIED]
    place = {(scene, setting): (at, n) for at, scene in enumerate(scenes) for n, setting in enumerate(settings(scene))}
    rows = sorted(tables.read(TABLE), key=lambda row: place[row["scene"], row["accuracy"]])
    lines = [
        "# Error asked for, promised and found",
        "",
        "`python -m tools.studies accuracy` makes this. Errors are relative, in percent: promised / found on the",
        "finest mesh, taken on from where a row ends; of tissues that are not taken on, beside the finest mesh that",
        "their scene has a run on, which may be on another branch (in brackets). Effectivity is promised over found,",
        "for the energy. The tail is the share of factorisations that come after the energy is within 3e-4 of that",
        "with which walls end on the same mesh. Seconds are of the processor, for the row itself. Members, six of",
        "each row, have corners and walls that differ by a thousandth (`python -m tools.studies members`).",
        "",
        *_verdict(rows),
        "",
        "| scene | accuracy | energy | plate force | mean gap | effectivity | order, grading, halvings | unknowns "
        "| certified | tail | s | code |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        reference = reference_of(rows, row["scene"])
        pairs, effectivity, is_own = [], "", bool(row.get("finest_energy"))
        if (row is reference and not is_own) or not isfinite(float(row["energy_error"])):
            continue  # where no finer mesh has found an equilibrium, nothing is promised
        for name in NUMBERS:
            truth = float(row[f"finest_{name}"] if is_own else reference[name])
            if abs(truth) < _NOTHING:
                pairs.append("0")
                continue
            promised = float(row[f"{name}_error"]) / max(abs(truth), 1e-300)
            found = abs(float(row[name]) - truth) / max(abs(truth), 1e-300)
            shown = f"{100 * found:.2g}"
            pairs.append(f"{100 * promised:.2g} / {shown if is_own or row['scene'] not in SCENES else f'({shown})'}")
            if name == "energy":
                effectivity = f"{promised / max(found, 1e-300):.2g}"
        mesh = ", ".join(row[name] for name in MESH[:-1])
        cells = [row["scene"], row["accuracy"], *pairs, effectivity, mesh, row["unknowns"], row["certified"]]
        lines.append("| " + " | ".join([*cells, row.get("tail", ""), row["seconds"], row["code"]]) + " |")
    return "\n".join(lines) + "\n"


def reference_of(rows: list[dict[str, str]], scene: str) -> dict[str, str]:
    """Return the row of the finest mesh, the last of the settings that have come to it."""
    order = settings(scene)
    mine = [row for row in rows if row["scene"] == scene]
    return max(mine, key=lambda row: (int(row["unknowns"]), order.index(row["accuracy"])))


def settings(scene: str) -> list[str]:
    """Return what a scene is run with, the overkill last."""
    if scene in GIVEN or scene in VERIFIED:
        return [f"mesh.order={order}" for order in _VERIFIED_ORDERS.get(scene, ORDERS)]
    return [f"accuracy={accuracy}" for accuracy in (*ACCURACIES, OVERKILL)]


@described(__doc__)
@click.option("--scene", "scenes", multiple=True, type=click.Choice([*SCENES, *GIVEN, *VERIFIED]), help="Only these.")
@click.option("--quick", is_flag=True, help="The two coarsest accuracies of the first scene, without writing anything.")
def command(scenes: tuple[str, ...], quick: bool) -> None:
    """Run what is missing, and write the table."""
    if quick:
        for setting in settings("3x3 to 0.4")[:2]:
            click.echo(measured("3x3 to 0.4", setting))
        return
    known = {(row["scene"], row["accuracy"], row["code"]) for row in tables.read(TABLE)}
    for scene in scenes or (*SCENES, *GIVEN, *VERIFIED):
        for setting in settings(scene):
            if (scene, setting, sources()) in known:
                continue
            row = measured(scene, setting)
            kept = [old for old in tables.read(TABLE) if (old["scene"], old["accuracy"]) != (scene, setting)]
            tables.write(TABLE, COLUMNS, [*kept, row])
            click.echo(f"{scene}, {setting}: energy {row['energy']:.6g}, {row['seconds']} s")
    REPORT.write_text(report(), encoding="utf-8")
