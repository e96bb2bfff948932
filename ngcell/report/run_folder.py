"""What a report reads of a result folder: whatever is there, and one line for each thing that is not."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from ngcell.errors import OutputError
from ngcell.export import count_snapshots, read_records, read_snapshot, read_summary
from ngcell.results.record import CellRecord, StepRecord, WallRecord
from ngcell.results.snapshot import Snapshot

Record = TypeVar("Record")


@dataclass(eq=False)
class RunFolder:
    """A run as its folder tells it.

    Attributes
    ----------
    path : Path
        The folder.
    name : str
        What the report calls the run.
    summary : mapping of str to Any
        What `summary.json` holds.
    history, walls, cells : list
        Rows of the three tables; empty where a table cannot be read.
    case_text : str
        The resolved case; empty where it is missing.
    missing : list of str
        One line for each thing that cannot be read.
    """

    path: Path
    name: str
    summary: Mapping[str, Any]
    history: list[StepRecord] = field(default_factory=list)
    walls: list[WallRecord] = field(default_factory=list)
    cells: list[CellRecord] = field(default_factory=list)
    case_text: str = ""
    missing: list[str] = field(default_factory=list)

    @property
    def certified(self) -> bool:
        """Whether the run ended, passed every check and met every expected number."""
        return bool(self.summary.get("certified"))

    @property
    def title(self) -> str:
        """Heading of the run."""
        said = self.summary.get("title") or case_table(self.case_text).get("title")
        return str(said or self.path.resolve().name)

    @property
    def snapshot_count(self) -> int:
        """Number of snapshots that the folder lists."""
        return count_snapshots(self.path)

    def snapshots(self) -> Iterator[tuple[Snapshot, bool]]:
        """Yield each snapshot that can be read, and whether its step is certified; note those that cannot."""
        for number in range(self.snapshot_count):
            try:
                yield read_snapshot(self.path, number)
            except OutputError as error:
                self.missing.append(str(error))


def read_run(path: Path, name: str = "") -> RunFolder:
    """Read the folder of a run.

    Parameters
    ----------
    path : Path
        The folder.
    name : str
        What the report calls the run; by default the name of the folder.

    Raises
    ------
    OutputError
        If it has no summary: it is not the result of a run.
    """
    run = RunFolder(path, name or path.resolve().name, read_summary(path))
    run.history = _rows(run, "history.csv", StepRecord)
    run.walls = _rows(run, "walls.csv", WallRecord)
    run.cells = _rows(run, "cells.csv", CellRecord)
    try:
        run.case_text = (path / "case.toml").read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        run.case_text = str(run.summary.get("case") or "")
        if not run.case_text:
            run.missing.append("case.toml cannot be read: the case is not shown")
    if not run.snapshot_count:
        run.missing.append("tissue.pvd is missing or lists no snapshot: the deformed tissue is not shown")
    if run.history and not run.summary.get("last_step"):
        run.summary = {**run.summary, "last_step": asdict(run.history[-1])}
    return run


def case_table(case_text: str) -> Mapping[str, Any]:
    """Return what a case says; nothing where its text is that of a scene of a script, which does not read back."""
    try:
        return tomllib.loads(case_text)
    except tomllib.TOMLDecodeError:
        return {}


def _rows(run: RunFolder, name: str, record_type: type[Record]) -> list[Record]:
    file = run.path / name
    if not file.exists() or not file.stat().st_size:
        run.missing.append(f"{name} is missing or empty: its numbers are not shown")
        return []
    try:
        return read_records(file, record_type)
    except OutputError as error:
        run.missing.append(str(error))
        return []
