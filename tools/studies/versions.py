"""This version beside an earlier one: what each takes for the error that it has.

    python -m tools.studies versions [--before COMMIT]

The earlier one is the last before an accuracy could be asked for. It has one mesh for a scene, the default one or that
of an order and a size which are given: what it takes at the error of the present version is more than its finest mesh
takes while that errs by more. Each of its runs is followed by one of the present version at an accuracy of 0.01, on one
thread, each in a process of its own. Errors are relative to the finest mesh of `tools/results/accuracy.csv`. Rows go to
`tools/results/versions.csv`, the table to `versions.md` beside it.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import tarfile
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS, ROOT
from tools.runs import sources
from tools.studies import accuracy

TABLE, REPORT = RESULTS / "versions.csv", RESULTS / "versions.md"
BEFORE, PRESENT = "0a193bb", "present"
COLUMNS = ("scene", "version", "code", "settings", *accuracy.NUMBERS, "certified", "seconds")
_ACCURACY = "accuracy=0.01"
#: What the earlier version is run with, the scene's own entries apart.
_FEWER = ("", "mesh.order=4 mesh.size=0.25", "mesh.order=4 mesh.size=0.125")
SETTINGS: Mapping[str, tuple[str, ...]] = {
    "3x3 to 0.4": (*_FEWER, "mesh.order=4 mesh.size=0.0625"),
    "3x3 to 1.0": _FEWER,
    "5x7 to 1.6": _FEWER,
}
#: Both versions answer to this; seconds are of the processor, the package's own import left out.
_PROGRAM = """
import json, sys
from math import hypot
from time import process_time

import ngsolve

ngsolve.SetNumThreads(1)
import ngcell

name, *entries = sys.argv[1:]
case, started = ngcell.read_case(name, entries), process_time()
*_, step = ngcell.simulate(case)
seconds, last = process_time() - started, step.record
found = {"energy": last.energy, "plate_force": hypot(last.plate_force_x, last.plate_force_y), "mean_gap": last.mean_gap}
print(json.dumps(found | {"certified": last.certified, "seconds": round(seconds, 2)}))
"""


def measured(folder: Path, scene: str, settings: str) -> dict[str, Any]:
    """Run a scene by the version in a folder, and return what it found and took."""
    case, entries = accuracy.SCENES[scene]
    words = [sys.executable, "-c", _PROGRAM, case, *entries, *settings.split()]
    alone = {**os.environ, "PYTHONPATH": str(folder), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    run = subprocess.run(words, cwd=folder, env=alone, capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(run.stdout.splitlines()[-1])
    return found


def unpacked(commit: str, folder: Path) -> None:
    """Write the package and the cases of a commit into a folder."""
    packed = subprocess.run(["git", "archive", commit, "ngcell", "cases"], cwd=ROOT, capture_output=True, check=True)
    with tarfile.open(fileobj=io.BytesIO(packed.stdout)) as archive:
        archive.extractall(folder, filter="data")


def report() -> str:
    """Return the table: errors and seconds of both, run by run."""
    rows, references = tables.read(TABLE), tables.read(accuracy.TABLE)
    lines = []
    for before, present in zip(rows[::2], rows[1::2], strict=True):
        reference = accuracy.reference_of(references, before["scene"])
        errors = [_errors(row, reference) for row in (before, present)]
        ratio = float(present["seconds"]) / float(before["seconds"])
        taken = before["settings"] or "as the case has it"
        seconds = before["seconds"], present["seconds"]
        lines.append([before["scene"], taken, errors[0], seconds[0], errors[1], seconds[1], f"{ratio:.2g}"])
    columns = ["scene", "mesh before", "errors before", "s before", "errors at present", "s at present", "ratio"]
    text = "\n".join((__doc__ or "").strip().splitlines()[4:])
    codes = f"Before: {rows[0]['code']}. At present: {', '.join(sorted({row['code'] for row in rows[1::2]}))}."
    told = f"{codes} Errors of energy, plate force and mean gap in percent; the ratio is that of seconds."
    return f"# This version beside an earlier one\n\n{text}\n\n{told}\n\n{tables.markdown(columns, lines)}\n"


def _errors(row: Mapping[str, str], reference: Mapping[str, str]) -> str:
    shares = (abs(float(row[name]) / float(reference[name]) - 1) for name in accuracy.NUMBERS)
    return ", ".join(f"{100 * share:.2g}" for share in shares)


@described(__doc__)
@click.option("--before", default=BEFORE, show_default=True, help="The earlier commit.")
@click.option("--report-only", is_flag=True, help="Write the table of the rows that are there.")
def command(before: str, report_only: bool) -> None:
    """Run both versions in turns, and write the table."""
    if not report_only:
        rows = []
        with TemporaryDirectory() as folder:
            unpacked(before, Path(folder))
            for scene, several in SETTINGS.items():
                for settings in several:
                    turns = {before: (Path(folder), settings), PRESENT: (ROOT, _ACCURACY)}
                    for version, (where, given) in turns.items():
                        code = before if version == before else sources()
                        found = measured(where, scene, given)
                        rows.append({"scene": scene, "version": version, "code": code, "settings": given, **found})
                        click.echo(f"{scene}, {version}, {given}: {found['seconds']} s")
        tables.write(TABLE, COLUMNS, rows)
    REPORT.write_text(report(), encoding="utf-8")
