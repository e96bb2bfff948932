"""How much of a plate force is known: members of sheared tissues.

    python -m tools.studies members [--scene 3x3] [--spread 0.001] [--quick]

Each scene is run with members whose geometries differ by a share, of seeds 0, 1, ..., as by `ngcell solve CASE
--members N --spread SHARE`. Mean, spread and estimated error of each number go to `tools/results/members.csv`, those of
force, energy and gaps to `members.md`. Runs are kept in `out/members/`, and members of the present sources are not run
again.
"""

from __future__ import annotations

from dataclasses import asdict, fields
from math import hypot
from pathlib import Path
from time import process_time
from typing import Any

import click

import ngcell
from ngcell.ensemble import Ensemble
from ngcell.recording import RecordingOptions
from ngcell.results.spread import Spread
from ngcell.results.verdict import with_error
from ngcell.scene import MemberChoice
from tools import tables
from tools.commands import described
from tools.places import RESULTS, ROOT
from tools.runs import sources
from tools.studies import accuracy

TABLE, REPORT = RESULTS / "members.csv", RESULTS / "members.md"
FOLDERS = ROOT / "out" / "members"
#: Case, settings, and number of members.
SCENES: dict[str, tuple[str, tuple[str, ...], int]] = {
    "3x3": ("shear-empty-3x3", (), 10),
    "5x7": ("shear-empty", ("load.levels=4",), 6),
    "3x3 under 0.01": (*accuracy.SCENES["3x3 under 0.01"], 10),
    "3x3 filled": ("shear-filled", (*accuracy.SCENES["3x3 filled"][1], "accuracy=0.01"), 10),
}
#: The rows of the study of accuracy, which tells what their members scatter by.
SCENES |= {
    accuracy.members_of(scene, f"accuracy={share}"): (case, (*sets, f"accuracy={share}"), 6)
    for scene, (case, sets) in accuracy.SCENES.items()
    for share in accuracy.ACCURACIES
}
QUICK = ("tissue.rows=2", "tissue.cols=2", "load.displacement=[0.3, 0.0]", "load.levels=1", "accuracy=0.1")
SHOWN = ("plate_force", "energy", "mean_gap", "largest_gap", "parted_pairs")
COLUMNS = (
    "scene", "share", "settings", "run", "code", "displacement", *(column.name for column in fields(Spread)),
)  # fmt: skip


def measured(case: str, sets: tuple[str, ...], count: int, share: float, out: Path) -> list[dict[str, Any]]:
    """Run the members of a case, and return a row for each level and number."""
    whole = ngcell.read_case(case, sets)
    assert isinstance(whole, ngcell.Case)
    ensemble = Ensemble(whole, out, MemberChoice(count, 0, share), RecordingOptions(threads=1), resumed=True)
    started = process_time()
    for number, record in ensemble:
        click.echo(f"member {number}: {record.phase} at {record.load_factor:g}, energy {record.energy:.6g}", err=True)
    click.echo(f"{process_time() - started:.0f} processor seconds")
    moved = hypot(*(float(part) for part in whole.load.displacement))
    told = {"share": share, "settings": " ".join(sets), "run": count, "code": sources()}
    return [{**told, "displacement": moved * row.load_factor, **asdict(row)} for row in ensemble.spreads]


def report(rows: list[dict[str, str]]) -> str:
    """Return the table of how much is known."""
    lines = [
        "# How much of a number is known",
        "",
        "`python -m tools.studies members` makes this, from `members.csv`: each number as mean ± estimated error of",
        "the mesh, spread (standard deviation over the members that count) in percent, and from the smallest to the",
        "largest. Corners of members are displaced by at most the share of the side, and walls deviate by at most the",
        "share of their thickness.",
        "",
    ]
    columns = ("scene", "share", "displacement", "members", "number", "mean ± mesh", "spread", "range", "remark")
    shown = [row for row in rows if row["number"] in SHOWN]
    return "\n".join([*lines, tables.markdown(columns, map(_line, shown))]) + "\n"


def _line(row: dict[str, str]) -> list[str]:
    mean, deviation, error = (float(row[name]) for name in ("mean", "deviation", "error"))
    size = abs(mean) or 1.0
    settings = row["settings"] if row["scene"] in ("3x3", "5x7") else ""
    scene, counted = f"{row['scene']} {settings}".strip(), f"{row['members']} of {row['run']}"
    reach = f"{float(row['smallest']):.4g} to {float(row['largest']):.4g}"
    spread = f"{100 * deviation / size:.2g} %"
    place = [scene, row["share"], f"{float(row['displacement']):.4g}", counted, row["number"].replace("_", " ")]
    return [*place, with_error(mean, error), spread, reach, row["remark"]]


@described(__doc__)
@click.option("--scene", "scenes", multiple=True, type=click.Choice([*SCENES]), help="Only these.")
@click.option("--spread", "share", default=1e-3, show_default=True, help="Share by which geometries differ.")
@click.option("--quick", is_flag=True, help="Two members of four cells, without writing anything to tools/results.")
def command(scenes: tuple[str, ...], share: float, quick: bool) -> None:
    """Run what is missing, and write the tables."""
    code = sources()
    if quick:
        rows = measured("shear-empty-3x3", QUICK, 2, share, FOLDERS / f"quick-{share:g}-{code}")
        click.echo(report([{name: str(value) for name, value in {"scene": "2x2", **row}.items()} for row in rows]))
        return
    for scene in scenes or SCENES:
        case, sets, count = SCENES[scene]
        rows = measured(case, sets, count, share, FOLDERS / f"{scene}-{share:g}-{code}")
        kept = [old for old in tables.read(TABLE) if (old["scene"], old["share"]) != (scene, str(share))]
        tables.write(TABLE, COLUMNS, [*kept, *({"scene": scene, **row} for row in rows)])
        REPORT.write_text(report(tables.read(TABLE)), encoding="utf-8")
