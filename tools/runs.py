"""Runs in processes of their own, of this working copy: what they took, how they ended, and by which sources.

Kept runs of shipped cases, `Run`, have their result folders in `out/runs/`; they are not repeated, and go on where they
were stopped.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryFile
from time import perf_counter
from typing import Any

from tools import tables
from tools.places import ROOT

FOLDERS = ROOT / "out" / "runs"


@dataclass(frozen=True)
class Ended:
    """How a process ended.

    Attributes
    ----------
    exit_code : int
        Its exit code; negative if a signal ended it.
    processor, clock : float
        Its processor seconds, and seconds on the clock.
    peak_mb : float
        Its largest resident memory [MB].
    timed_out : bool
        Whether time ran out.
    out, err : str
        What it wrote.
    """

    exit_code: int
    processor: float
    clock: float
    peak_mb: float
    timed_out: bool
    out: str
    err: str

    def last_words(self, otherwise: str) -> str:
        """Return the last line that it wrote about itself."""
        return (self.err.strip().splitlines() or [otherwise])[-1]

    @property
    def is_late(self) -> bool:
        """Whether time ran out, that of the process or that of ``--max-minutes``."""
        return self.timed_out or "--max-minutes" in self.last_words("").partition(";")[0]


def ended(*words: str, timeout: float = float("inf")) -> Ended:
    """Run ``python -m WORDS`` on this working copy, with one thread for dense blocks, and return how it ended."""
    here = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    with TemporaryFile("w+") as out, TemporaryFile("w+") as err:
        started = perf_counter()
        process = subprocess.Popen([sys.executable, "-m", *words], cwd=ROOT, env=here, stdout=out, stderr=err)
        timer = threading.Timer(min(timeout, threading.TIMEOUT_MAX), process.kill)
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        timed_out = not timer.is_alive()
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        return Ended(
            exit_code=process.returncode,
            processor=usage.ru_utime + usage.ru_stime,
            clock=perf_counter() - started,
            peak_mb=usage.ru_maxrss / 1024,
            timed_out=timed_out,
            out=out.read(),
            err=err.read(),
        )


def found_by(*words: str) -> Any:
    """Run ``python -m WORDS`` and return the JSON of its last line.

    Raises
    ------
    RuntimeError
        If it fails; with its last words.
    """
    run = ended(*words)
    if run.exit_code:
        raise RuntimeError(f"{' '.join(words)}: {run.last_words('no log')}")
    return json.loads(run.out.splitlines()[-1])


def solve_words(case: str, folder: Path, overrides: tuple[str, ...] = ()) -> list[str]:
    """Return the words with which a case is solved into a folder by one thread."""
    settings = [word for entry in overrides for word in ("--set", entry)]
    return ["ngcell", "solve", case, *settings, "--out", str(folder), "--threads", "1", "--force"]


def alternating(measured: Mapping[str, Callable[[], Any]], times: int) -> dict[str, list[Any]]:
    """Measure each of several things so many times, in turns, so that a slow minute of the machine is everyone's."""
    found: dict[str, list[Any]] = {name: [] for name in measured}
    for _ in range(times):
        for name, measure in measured.items():
            found[name].append(measure())
    return found


def sources() -> str:
    """Return a digest of the sources of the package."""
    digest = sha256()
    for path in sorted((ROOT / "ngcell").rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:8]


def commit() -> str:
    """Return the commit that is checked out, with a mark where files differ from it."""
    called = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return called.stdout.strip()


def summary_in(folder: Path) -> dict[str, Any]:
    """Return the summary of a result folder; empty while there is none."""
    file = folder / "summary.json"
    return dict(json.loads(file.read_text(encoding="utf-8"))) if file.exists() else {}


def released_rows(folder: Path) -> list[dict[str, str]]:
    """Return the rows of the history of a result folder whose walls are in contact, those of stopped runs included."""
    return [row for row in tables.read(folder / "history.csv") if row["phase"] == "released"]


@dataclass(frozen=True)
class Run:
    """A kept run of a shipped case.

    Attributes
    ----------
    case : str
        Name of a shipped case.
    settings : tuple of str
        Entries for `--set`.
    """

    case: str
    settings: tuple[str, ...] = ()

    @property
    def folder(self) -> Path:
        """Where its results are."""
        return FOLDERS / "_".join([self.case, *(re.sub(r"[^\w.=-]+", "-", entry) for entry in self.settings)])

    @property
    def summary(self) -> dict[str, Any]:
        """What its summary says; empty while there is none."""
        return summary_in(self.folder)

    def solve(self, timeout: float) -> str:
        """Run it unless it has ended, going on where it stopped, and return the outcome."""
        if self.summary.get("status") == "finished":
            return str(self.summary["outcome"])
        if self.summary:
            words = ["ngcell", "solve", "--resume", str(self.folder), "--threads", "1"]
        else:
            words = solve_words(self.case, self.folder, self.settings)
        run = ended(*words, "--quiet", timeout=timeout)
        if run.timed_out:
            return f"stopped after {timeout:.0f} s"
        return self.summary.get("outcome") or run.last_words("no words")

    def levels(self) -> Iterator[dict[str, str]]:
        """Yield the rows of its released steps."""
        return iter(released_rows(self.folder))
