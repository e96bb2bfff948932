"""Runs that are killed at random moments and resumed: does a number change, is a folder lost?

    python -m tools.extreme soak [--kills 200] [--minutes 60] [--seed 1]

Each run of a small scene is ended by a signal at a moment drawn from the time that the whole run takes, start-up
included, and resumed, up to eight times; then it is left alone to end. Half of them replace an earlier result, which
has to be whole as long as the new run has accepted no step. At the end all tables, but for the seconds, and all fields
have to be those of a run that nobody stopped, byte by byte. The table goes to `tools/results/soak.csv`.
"""

from __future__ import annotations

import csv
import os
import random
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic
from typing import Any

import click

from tools import tables
from tools.commands import described
from tools.places import RESULTS, ROOT
from tools.runs import summary_in

_SMALL = ("tissue.rows=1", "tissue.cols=2", "mesh.order=1", "load.levels=4", "accuracy=inf")
_BONDED = ("cohesion.strength=0.01", "cohesion.energy=0.0001", 'strategy.kind="load-stepping"')
#: Words of the small scenes, by name.
SCENES = {
    "SDDP": ("shear-empty-3x3", *_SMALL),
    "single step, mortar": ("shear-empty-3x3", *_SMALL, 'strategy.kind="single-step"', 'contact.kind="mortar"'),
    "load stepping, bonds": ("shear-empty-3x3", *_SMALL, *_BONDED),
    "own bodies": ("parting-rings", "levels=4", "steps=4", "mesh.order=1", "accuracy=inf"),
}
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
COLUMNS = ("scene", "signal", "kills", "before_first_step", "ended_anyway", "runs", "files_changed", "folders_lost")
_MOST_KILLS_OF_A_RUN = 8


@dataclass(frozen=True)
class Whole:
    """A run that nobody stopped: its folder, and how long it took [s]."""

    folder: Path
    seconds: float


def words_of(scene: str, folder: Path, *, force: bool = False) -> list[str]:
    """Return the words that solve a scene into a folder."""
    case, *settings = SCENES[scene]
    sets = [word for setting in settings for word in ("--set", setting)]
    return ["solve", case, *sets, "--out", str(folder), "--quiet", *(["--force"] if force else [])]


def started(*words: str) -> subprocess.Popen[str]:
    """Start ngcell in a process of its own."""
    here = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "ngcell", *words]
    return subprocess.Popen(command, cwd=ROOT, env=here, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def whole_run(scene: str, folder: Path) -> Whole:
    """Run a scene to its end.

    Raises
    ------
    RuntimeError
        If it is not certified.
    """
    begun = monotonic()
    process = started(*words_of(scene, folder))
    _, told = process.communicate()
    if process.returncode:
        raise RuntimeError(f"{scene}: {told}")
    return Whole(folder, monotonic() - begun)


def contents(folder: Path) -> dict[str, object]:
    """Return what must not change: tables without their seconds, and the bytes of fields."""
    found: dict[str, object] = {path.name: path.read_bytes() for path in folder.glob("*.vt?")}
    found |= {path.name: path.read_bytes() for path in folder.glob("*.pvd")}
    for table in folder.glob("*.csv"):
        with table.open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        found[table.name] = [{key: value for key, value in row.items() if key != "seconds"} for row in rows]
    return found


def bytes_of(folder: Path) -> dict[str, bytes]:
    """Return all files of a folder that belong to its result."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.startswith(".")}


def next_words(scene: str, folder: Path, earlier: dict[str, bytes] | None) -> list[str]:
    """Return the words that go on with a run that was stopped; it starts anew where nothing of it was written."""
    if not summary_in(folder) or (earlier is not None and bytes_of(folder) == earlier):
        return words_of(scene, folder, force=earlier is not None)
    return ["solve", "--resume", str(folder), "--quiet"]


def soaked(
    scene: str, whole: Whole, earlier: Whole | None, folder: Path, chance: random.Random
) -> Iterator[Counter[str]]:
    """Yield what came of each kill of a run, and of the run."""
    before = None
    if earlier is not None:
        shutil.copytree(earlier.folder, folder)
        before = bytes_of(folder)
    for _ in range(chance.randint(1, _MOST_KILLS_OF_A_RUN)):
        process = started(*next_words(scene, folder, before))
        name, moment = chance.choice(SIGNALS), chance.uniform(0.0, whole.seconds)
        try:
            process.communicate(timeout=moment)
            yield Counter({"signal": name, "ended_anyway": 1, "folders_lost": _is_lost(process.returncode)})
            break
        except subprocess.TimeoutExpired:
            process.send_signal(name)
            process.communicate()
        is_early = not summary_in(folder).get("accepted_steps") or (before is not None and bytes_of(folder) == before)
        yield Counter({"signal": name, "kills": 1, "before_first_step": int(is_early)})
    lost, changed = 0, 0
    if summary_in(folder).get("status") != "finished" or (before is not None and bytes_of(folder) == before):
        process = started(*next_words(scene, folder, before))
        _, told = process.communicate()
        lost = _is_lost(process.returncode)
        if lost:
            click.echo(f"{scene}: {told.strip()}", err=True)
    if not lost:
        mine, meant = contents(folder), contents(whole.folder)
        changed = sum(mine.get(name) != meant.get(name) for name in mine.keys() | meant.keys())
    yield Counter({"signal": name, "runs": 1, "folders_lost": lost, "files_changed": changed})


def _is_lost(exit_code: int) -> int:
    return int(exit_code != 0)


@described(__doc__)
@click.option("--kills", default=200, help="How many kills.")
@click.option("--minutes", default=60.0, help="Time after which no further run is started.")
@click.option("--seed", default=1, help="Of the random moments.")
def command(kills: int, minutes: float, seed: int) -> None:
    """Kill and resume."""
    chance, end = random.Random(seed), monotonic() + 60 * minutes
    found: dict[tuple[str, str], Counter[str]] = {}
    with TemporaryDirectory() as place:
        room = Path(place)
        wholes = {scene: whole_run(scene, room / f"whole{number}") for number, scene in enumerate(SCENES)}
        done, number = 0, 0
        while done < kills and monotonic() < end:
            scene = list(SCENES)[number % len(SCENES)]
            others = [whole for name, whole in wholes.items() if name != scene]
            earlier, folder = (chance.choice(others) if number // len(SCENES) % 2 else None), room / "out"
            for counted in soaked(scene, wholes[scene], earlier, folder, chance):
                name = signal.Signals(counted.pop("signal")).name
                found.setdefault((scene, name), Counter()).update(counted)
                done += counted["kills"]
            shutil.rmtree(folder, ignore_errors=True)
            number += 1
    rows: list[dict[str, Any]] = [
        {"scene": scene, "signal": name, **counted} for (scene, name), counted in sorted(found.items())
    ]
    sums = {column: sum(row.get(column, 0) for row in rows) for column in COLUMNS[2:]}
    rows.append({"scene": "all", "signal": "", **sums})
    tables.write(RESULTS / "soak.csv", COLUMNS, ({column: row.get(column, 0) for column in COLUMNS} for row in rows))
    click.echo(f"{sums['kills']} kills, {sums['files_changed']} files changed, {sums['folders_lost']} folders lost")
    sys.exit(bool(sums["files_changed"] or sums["folders_lost"]))
