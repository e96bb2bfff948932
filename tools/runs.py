"""Runs of shipped cases by `ngcell solve`, a process each; their folders, `out/runs/`, are kept and not repeated."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ROOT / "out" / "runs"


@dataclass(frozen=True)
class Run:
    """A run.

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
    def summary(self) -> dict:
        """What its summary says; empty while there is none."""
        file = self.folder / "summary.json"
        return json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}

    def solve(self, timeout: float) -> str:
        """Run it unless it has ended, going on where it stopped, and return the outcome."""
        if self.summary.get("status") == "finished":
            return self.summary["outcome"]
        command = [sys.executable, "-m", "ngcell", "solve", "--quiet", "--threads", "1"]
        if self.summary:
            command += ["--resume", str(self.folder)]
        else:
            command += [self.case, "--out", str(self.folder)]
            command += [word for entry in self.settings for word in ("--set", entry)]
        try:
            done = subprocess.run(command, cwd=ROOT, timeout=timeout, capture_output=True, text=True, check=False)
        except subprocess.TimeoutExpired:
            return f"stopped after {timeout:.0f} s"
        return self.summary.get("outcome") or (done.stderr.strip().splitlines() or ["no words"])[-1]

    def rows(self, table: str) -> list[dict[str, str]]:
        """Return the rows of one of its tables, such as `history.csv`."""
        file = self.folder / table
        with file.open(encoding="utf-8", newline="") as lines:
            return list(csv.DictReader(lines))

    def levels(self) -> Iterator[dict[str, str]]:
        """Yield the rows of its released steps."""
        return (row for row in self.rows("history.csv") if row["phase"] == "contact")
