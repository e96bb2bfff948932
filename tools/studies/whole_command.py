"""What the whole command takes, this version beside an earlier one.

    python -m tools.studies whole-command [--before COMMIT] [--turns N]

`ngcell solve` is run with imports, files and pictures: by the version before an accuracy could be asked for, with the
mesh that was its default, and by the present one at an accuracy of 0.01. Both run in turns, on one thread, each in a
process of its own, after one run each that is not counted; seconds are of the processor, the mean with the standard
deviation of runs. The table is written to `tools/results/whole-command.md`.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path
from statistics import mean, stdev
from tempfile import TemporaryDirectory

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS, ROOT
from tools.runs import sources
from tools.studies import accuracy
from tools.studies.versions import BEFORE, unpacked

REPORT = RESULTS / "whole-command.md"
SCENES = ("3x3 to 0.4", "3x3 to 1.0", "3x3 under 0.01")
_PROGRAM = "from ngcell.cli import ngcell; ngcell()"


def taken(folder: Path, scene: str, *more: str) -> float:
    """Return the processor seconds of the whole command, by the version in a folder."""
    case, entries = accuracy.SCENES[scene]
    sets = [word for entry in (*entries, *more) for word in ("--set", entry)]
    alone = {**os.environ, "PYTHONPATH": str(folder), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    alone.pop("PYTHONDONTWRITEBYTECODE", None)  # as users have it
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with TemporaryDirectory() as out:
        words = [sys.executable, "-c", _PROGRAM, "solve", case, *sets, "--out", f"{out}/run", "--threads", "1"]
        subprocess.run(words, cwd=folder, env=alone, capture_output=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def compared(scene: str, folder: Path, turns: int) -> list[str]:
    """Return the row of a scene: seconds of the version in a folder, of the present one, and their ratio."""
    seconds = [(taken(folder, scene), taken(ROOT, scene, "accuracy=0.01")) for _ in range(1 + turns)][1:]
    before, present = zip(*seconds, strict=True)
    shown = [f"{mean(times):.2f} ± {stdev(times):.2f}" for times in (before, present)]
    return [scene, *shown, f"{mean(present) / mean(before):.2f}"]


@described(__doc__)
@click.option("--before", default=BEFORE, show_default=True, help="The earlier commit.")
@click.option("--turns", default=6, show_default=True, type=click.IntRange(min=2), help="Runs of each version.")
def command(before: str, turns: int) -> None:
    """Run both versions in turns, and write the table."""
    with TemporaryDirectory() as folder:
        unpacked(before, Path(folder))
        rows = [compared(scene, Path(folder), turns) for scene in SCENES]
    text = "\n".join((__doc__ or "").strip().splitlines()[4:])
    table = tables.markdown(["scene", "before [s]", "at present [s]", "ratio"], rows)
    codes = f"Before: {before}. At present: {sources()}. {turns} runs each."
    REPORT.write_text(f"# The whole command, before and at present\n\n{text}\n\n{codes}\n\n{table}\n", encoding="utf-8")
    click.echo(table)
