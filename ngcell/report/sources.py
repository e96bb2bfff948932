"""What a folder that is reported holds: one run, members of a case, or a sweep over many cases."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from ngcell.errors import OutputError
from ngcell.export.ensemble import member_folder
from ngcell.export.summary import MEMBERS, SUMMARY, read_summary
from ngcell.report.run_folder import RunFolder, read_run
from ngcell.results.spread import REFUSED

#: Rows of a table, by the names of its columns.
Rows = Sequence[Mapping[str, str]]
#: The table of a sweep, one row for each run and level.
SWEEP_TABLE = "sweep.csv"


#: Outcomes of a run in the table of a sweep: certified at all of its levels, and so but for an expected number.
_CERTIFIED, _NOT_AS_EXPECTED = "certified", "not-as-expected"


@dataclass(eq=False)
class Source:
    """A folder that is reported.

    Attributes
    ----------
    kind : {"run", "members", "sweep"}
        What it holds.
    path : Path
        The folder.
    title : str
        Its heading.
    certified : bool
        Whether everything in it is certified.
    runs : list of RunFolder
        The run, or those of the members or the sweep that can be read.
    summary : mapping of str to Any
        What `summary.json` holds; empty where there is none.
    rows : sequence of mapping of str to str
        Rows of the table of a sweep, or of `spread.csv` of members.
    unread : list of str
        One line for each run that cannot be read.
    """

    kind: Literal["run", "members", "sweep"]
    path: Path
    title: str
    certified: bool
    runs: list[RunFolder] = field(default_factory=list)
    summary: Mapping[str, Any] = field(default_factory=dict)
    rows: Rows = ()
    unread: list[str] = field(default_factory=list)


def read_source(path: Path) -> Source:
    """Read a folder that is reported.

    Raises
    ------
    OutputError
        If it is no result.
    """
    if (path / SWEEP_TABLE).is_file():
        return _sweep(path)
    if not (path / SUMMARY).is_file():
        raise OutputError(f"{path} holds neither {SUMMARY} nor {SWEEP_TABLE}: it is not the result of a run or a sweep")
    summary = read_summary(path)
    if MEMBERS in summary:
        return _members(path, summary)
    run = read_run(path)
    return Source("run", path, run.title, run.certified, [run], run.summary)


def _members(path: Path, summary: Mapping[str, Any]) -> Source:
    source = Source("members", path, str(summary.get("title") or path.resolve().name), bool(summary.get("certified")))
    source.summary = summary
    source.rows = _table(path / "spread.csv", source.unread)
    folders = sorted(path.glob("member_*"))
    if (path / "members.csv").is_file():  # another folder may hold what an earlier run has left
        rows = _table(path / "members.csv", source.unread)
        ran = {int(row["member"]) for row in rows if not row["outcome"].startswith(REFUSED)}
        folders = [member_folder(path, number) for number in sorted(ran)]
    for folder in folders:
        _add_run(source, folder)
    return source


def _sweep(path: Path) -> Source:
    source = Source("sweep", path, f"Sweep {path.resolve().name}", certified=False)
    if (path / SUMMARY).is_file():
        source.summary = read_summary(path)
        source.title = str(source.summary.get("title") or source.title)
    source.rows = _table(path / SWEEP_TABLE, source.unread)
    ended = source.summary.get("status", "finished") == "finished"
    said = bool(source.summary.get("certified", True))  # a sweep that has not ended has not said it
    source.certified = ended and said and bool(source.rows) and all(map(run_is_certified, source.rows))
    return source


def level_is_certified(row: Mapping[str, str]) -> bool:
    """Return whether the level of a row of a sweep's table is certified, and as its case expects."""
    return row.get("certified") == "True" and row.get("outcome") != _NOT_AS_EXPECTED


def run_is_certified(row: Mapping[str, str]) -> bool:
    """Return whether the level of a row is certified, and all others of its run."""
    return row.get("certified") == "True" and row.get("outcome", _CERTIFIED) == _CERTIFIED


def _add_run(source: Source, folder: Path) -> None:
    try:
        source.runs.append(read_run(folder))
    except OutputError as error:
        source.unread.append(str(error))


def _table(path: Path, unread: list[str]) -> list[dict[str, str]]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        unread.append(f"cannot read {path}: {error}")
        return []
