"""A hundred and fifty unseen small scenes, judged by an oracle that shares nothing with the certificate.

    python -m tools.extreme hostile                    those that have no row yet, by these sources
    python -m tools.extreme hostile --first 60         the first of them only, which are of all kinds
    python -m tools.extreme hostile --failing          those again that were wrong, broken or over budget
    python -m tools.extreme hostile --only "fluid 03"  those whose label has this text, whatever is known of them

Each scene runs through the command line or from Python in a process of its own, with a minute of processor time. The
oracle reads the written files: it integrates the energy of the fields, samples J densely, intersects outlines with
themselves and each other, measures lumens, bounds energies by tied ones, compares their slope with forces, and the
whole with the mirrored, scaled or otherwise equal scene. Rows are kept in `tools/results/hostile.csv`, and
`hostile.md` beside it tells what came of all. The exit code is 1 if a row is wrong, broken or over budget.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
from collections import Counter
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import click
import tomli_w

from tools import tables
from tools.commands import described
from tools.extreme.hostile_judge import compare, examine
from tools.extreme.hostile_scenes import SEED, Run, Scene, scenes
from tools.places import RESULTS
from tools.runs import Ended, ended, sources, summary_in

#: Folders of one process: two that run at the same time do not share them.
FOLDERS = Path(tempfile.gettempdir()) / f"ngcell-hostile-{os.getpid()}"
#: Processor seconds of one run, and how much longer it may take on the clock of a busy machine.
BUDGET, PATIENCE = 60.0, 4.0
CERTIFIED, NAMED, WRONG, BROKEN, OVER = "certified", "named", "WRONG", "TRACEBACK", "OVER BUDGET"
FAILED = (WRONG, BROKEN, OVER)


@dataclass
class Row:
    """What came of a scene."""

    label: str
    what: str
    relation: str
    outcome: str
    is_certified: bool
    findings: str = ""
    integration: str = ""
    smallest_jacobian: str = ""
    overlap: str = ""
    self_overlap: str = ""
    seconds: str = ""
    code: str = ""


@described(__doc__)
@click.option("--seed", default=SEED, show_default=True, help="What scenes are drawn from.")
@click.option("--first", default=150, show_default=True, help="How many of them.")
@click.option("--only", default="", help="Scenes whose label has this text, again.")
@click.option("--failing", is_flag=True, help="Scenes again whose row says that something is wrong.")
@click.option("--out", type=click.Path(path_type=Path), default=RESULTS / "hostile.csv", help="Table of the rows.")
def command(seed: int, first: int, only: str, failing: bool, out: Path) -> None:
    """Run and report."""
    drawn, code, rows = scenes(seed), sources(), known(out)
    for scene in drawn[:first]:
        row = rows.get(scene.label)
        is_due = row is None or row.code != code
        if only or failing:
            is_due = (bool(only) and only in scene.label) or (failing and row is not None and row.outcome in FAILED)
        if not is_due:
            continue
        rows[scene.label] = row = solve(scene, code)
        click.echo(f"{row.outcome:11}  {row.seconds:>6} s  {row.label}  {row.findings}", err=True)
        kept = [rows[scene.label] for scene in drawn if scene.label in rows]
        tables.write(out, [column.name for column in fields(Row)], map(asdict, kept))
        out.with_suffix(".md").write_text(report(kept, len(drawn)), encoding="utf-8")
    shutil.rmtree(FOLDERS, ignore_errors=True)
    sys.exit(any(row.outcome in FAILED for row in rows.values()))


def known(file: Path) -> dict[str, Row]:
    """Return the rows that there are."""
    rows: list[dict[str, Any]] = [{**row, "is_certified": row["is_certified"] == "True"} for row in tables.read(file)]
    return {row["label"]: Row(**row) for row in rows}


def solve(scene: Scene, code: str) -> Row:
    """Run a scene, and the one that it is compared with, and return its row."""
    row = Row(scene.label, scene.what, scene.relation, NAMED, False, code=code)
    folder = FOLDERS / scene.label.replace(" ", "-")
    run = _ended(scene.run, folder)
    row.seconds = f"{run.processor:.1f}"
    if _is_bad(row, run):
        return row
    row.is_certified = run.exit_code == 0
    summary = summary_in(folder)
    if not row.is_certified:
        failed = sorted({name for names in summary.get("failed_steps", {}).values() for name in names})
        row.findings = ", ".join(failed) or str(summary.get("outcome") or run.last_words(""))[:120]
        return row
    row.outcome, found = CERTIFIED, examine(scene, folder)
    row.integration, row.smallest_jacobian = f"{found.integration:.2g}", f"{found.jacobian:.3g}"
    row.overlap, row.self_overlap = f"{found.overlap:.2g}", f"{found.self_overlap:.1g}"
    wrong = found.wrong + (_compared(scene, folder, row) if scene.other else [])
    if wrong and row.outcome == CERTIFIED:
        row.outcome = WRONG
    row.findings = "; ".join([row.findings, *wrong] if row.findings else wrong)
    return row


def _compared(scene: Scene, folder: Path, row: Row) -> list[str]:
    assert scene.other is not None
    other = folder.with_name(f"{folder.name}-other")
    run = _ended(scene.other, other)
    row.seconds = f"{float(row.seconds) + run.processor:.1f}"
    if _is_bad(row, run):
        return []
    if run.exit_code:
        # By another path, or on another mesh, a run may know that it failed; the same scene may not.
        return [] if scene.relation in ("levels", "mirrored") else [f"{scene.relation}: not certified"]
    return compare(scene, folder, other)


def _is_bad(row: Row, run: Ended) -> bool:
    """Note a run that ended as none may."""
    if "Traceback" in run.err or not (run.timed_out or run.exit_code in (0, 3, 4)):
        row.outcome, row.findings = BROKEN, f"exit {run.exit_code}: {run.last_words('')}"
    elif run.timed_out or run.processor > BUDGET:
        row.outcome, row.findings = OVER, f"{run.processor:.0f} processor seconds"
    return row.outcome in (BROKEN, OVER)


def _ended(run: Run, folder: Path) -> Ended:
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(exist_ok=True)
    if run.is_python:
        file = folder.with_suffix(".json")
        file.write_text(json.dumps(run.case), encoding="utf-8")
        words = ["tools.extreme", "hostile-python", str(file), str(folder)]
    else:
        file = folder.with_suffix(".toml")
        file.write_text(tomli_w.dumps(run.case), encoding="utf-8")
        words = ["ngcell", "solve", str(file), "--out", str(folder), "--threads", str(run.threads), "--quiet"]
    return ended(*words, timeout=BUDGET * PATIENCE)


def report(rows: list[Row], asked: int) -> str:
    """Return the table in words."""
    counts = Counter(row.outcome for row in rows)
    certified = sum(row.is_certified for row in rows)
    head = (
        f"# Small scenes that were never seen before\n\n`python -m tools.extreme hostile` makes this: {len(rows)} of "
        f"{asked} scenes drawn at random, judged from\nthe written files by an oracle that shares nothing with the "
        "certificate. Seconds are those of the processor.\n\n"
        f"- certified: {certified}, of which wrong: {counts[WRONG]}\n"
        f"- not certified, with the reason named: {counts[NAMED]}\n- tracebacks: {counts[BROKEN]}\n"
        f"- over budget: {counts[OVER]}\n"
    )
    columns = ("scene", "what", "beside it", "outcome", "findings", "energy", "J", "overlap / wall", "over itself", "s")
    lines = [
        (row.label, row.what, row.relation, row.outcome, row.findings, row.integration, row.smallest_jacobian,
         row.overlap, row.self_overlap, row.seconds) for row in rows
    ]  # fmt: skip
    return f"{head}\n{tables.markdown(columns, lines)}\n"
