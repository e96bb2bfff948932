"""The folder of a run: who owns it, what is in it, and that what was accepted stays in it.

`summary.json` is the mark of ownership: it is the first file written, naming the program, and says `running`
until the run ends, so that a killed run is recognised and its folder may be used again. A step is on disk
when `accept` returns; a step that cannot be written in full is taken back. Until the run ends, `restart.npz` holds
what it can be resumed from.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from numpy.typing import NDArray

from ngcell.errors import OutputError
from ngcell.export.atomic import output_errors, replace_file
from ngcell.export.curves import draw_curves
from ngcell.export.debonding import PairOnset, draw_debonding
from ngcell.export.picture import draw_tissue
from ngcell.export.restart import RESTART, Restart, cannot_resume, write_restart
from ngcell.export.series import SnapshotSeries, read_last_snapshot
from ngcell.export.summary import SUMMARY, read_summary, write_summary
from ngcell.export.tables import RecordTable
from ngcell.results.record import CellRecord, StepRecord, WallRecord
from ngcell.results.report import StepReport
from ngcell.results.snapshot import Snapshot

_PROGRAM = "ngcell"
_TABLES: dict[str, type[Any]] = {"history.csv": StepRecord, "walls.csv": WallRecord, "cells.csv": CellRecord}
_DRAFT = re.compile(r"\..+\.tmp")
_OWNED = re.compile(
    r"case\.toml|(history|walls|cells)\.csv|restart\.npz|tissue\.pvd|(tissue|walls)_\d{4,}\.vtu|"
    r"(tissue|gap|debonding)\.png|\..+\.tmp"
)


class ResultFolder:
    """The folder of one run, open from its start to its end.

    Entering makes the folder, removes what an earlier run left there, and starts the tables; other files are
    not touched. Leaving without `finish` notes in the summary that the run was stopped, and why.

    Parameters
    ----------
    path : Path
        A folder that does not exist, is empty, or holds an earlier result.
    case_text : str, optional
        The resolved case, written as `case.toml`.
    restart : Restart, optional
        Where the run that stopped in this folder stood; what it wrote until then is kept, and the run goes on.

    Raises
    ------
    OutputError
        On entering: the folder cannot be made, or holds something else. Later: a file cannot be written.

    Examples
    --------
    >>> with ResultFolder(Path("out"), case_text=text) as folder:  # doctest: +SKIP
    ...     folder.accept(record, walls, snapshot)
    ...     folder.finish({"certified": True})
    """

    def __init__(self, path: Path, *, case_text: str | None = None, restart: Restart | None = None) -> None:
        self.path = Path(path)
        self._case_text = case_text
        self._restart = restart
        self._reports = list(restart.reports) if restart else []
        self._history = [report.record for report in self._reports]
        self._last: Snapshot | None = None
        self._pairs: Sequence[PairOnset] = ()
        self._drawn = self._finished = False

    def __enter__(self) -> Self:
        self._make()
        if self._restart is not None:
            self._go_on(self._restart)
            return self
        self._note("running")
        self._clear()
        if self._case_text is not None:
            replace_file(self.path / "case.toml", self._case_text.encode())
        self._steps, self._walls, self._cells = (RecordTable(self.path / name, kind) for name, kind in _TABLES.items())
        self._series = SnapshotSeries(self.path)
        return self

    def _go_on(self, restart: Restart) -> None:
        self._series = SnapshotSeries(self.path, snapshots=restart.snapshots)
        if self._series.missing:
            raise cannot_resume(self.path, f"{self._series.missing[0]} is missing")
        for name in restart.table_sizes:
            if not (self.path / name).is_file():
                raise cannot_resume(self.path, f"{name} is missing")
        try:
            self._steps, self._walls, self._cells = (
                RecordTable(self.path / name, kind, size=restart.table_sizes[name]) for name, kind in _TABLES.items()
            )
            self._pairs = _last_pairs(self.path / "walls.csv")
        except (OutputError, KeyError) as error:
            raise cannot_resume(self.path, str(error)) from error
        self._note("running")

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._steps.close()
        self._walls.close()
        self._cells.close()
        if not self._finished:
            reason = str(error) or type(error).__name__ if error is not None else "not finished"
            with suppress(OutputError):  # the error that ends the run matters more than the note of it
                self._note("stopped", reason=reason)

    def accept(
        self,
        record: StepRecord,
        walls: Sequence[WallRecord] = (),
        snapshot: Snapshot | None = None,
        cells: Sequence[CellRecord] = (),
        *,
        report: StepReport | None = None,
        checkpoint: Mapping[str, NDArray[Any]] | None = None,
    ) -> None:
        """Put an accepted step on disk: its rows of walls and cells, its history row and, if given, its snapshot.

        With `report`, what the summary will tell of it, and `checkpoint`, what the next step depends on, the run can be
        resumed after this step.

        Raises
        ------
        OutputError
            If a part cannot be written; the steps before it are kept, and the message says where.
        """
        tables = self._walls, self._cells, self._steps
        sizes = [table.size for table in tables]
        try:
            self._walls.append(*walls)
            self._cells.append(*cells)
            self._steps.append(record)
            if snapshot is not None:
                self._series.append(snapshot, certified=record.certified)
        except OutputError as error:
            with suppress(OutputError):
                for table, size in zip(tables, sizes, strict=True):
                    table.rewind(size)
            raise OutputError(f"{error}; {self._kept()}") from error
        self._history.append(record)
        self._last = snapshot or self._last
        self._pairs = [(row.cell_a, row.cell_b, row.onset) for row in walls] or self._pairs
        if report is not None and checkpoint is not None:
            self._reports.append(report)
            self._remember(checkpoint)
        self._note("running")

    def _remember(self, checkpoint: Mapping[str, NDArray[Any]]) -> None:
        sizes = dict(zip(_TABLES, (self._steps.size, self._walls.size, self._cells.size), strict=True))
        restart = Restart(self._case_text or "", checkpoint, tuple(self._reports), sizes, self._series.snapshots)
        try:
            write_restart(self.path, restart)
        except OutputError as error:
            raise OutputError(f"{error}; {self._kept()}") from error

    def draw(self, *, title: str = "", certified: bool, onset: float | None = None) -> None:
        """Draw `tissue.png` of the last snapshot, and `gap.png` and `debonding.png`, as far as there is what they show.

        Raises
        ------
        OutputError
            If a picture cannot be written.
        """
        self._drawn = True
        if self._last is None and self._series.snapshots:
            self._last, _ = read_last_snapshot(self.path)
        if self._last is not None:
            draw_tissue(self._last, self.path / "tissue.png", title=title, certified=certified)
        if self._history:
            draw_curves(self._history, self.path / "gap.png", certified=certified, onset=onset)
        if self._pairs and self._last is not None:
            place = self.path / "debonding.png"
            draw_debonding(self._history, self._pairs, self._last.bulk, place, certified=certified)

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Write the summary of the ended run, after the pictures if `draw` was not called.

        Parameters
        ----------
        summary : mapping
            Written as JSON with `status` "finished". For the pictures `certified` (bool), `title` (str) and
            `onset` (float or None) are read from it.

        Raises
        ------
        OutputError
            If a file cannot be written; the accepted steps are kept, and the message says where.
        """
        try:
            if not self._drawn:
                self.draw(
                    title=summary.get("title") or "",
                    certified=bool(summary.get("certified")),
                    onset=summary.get("onset"),
                )
            write_summary(self.path, {"program": _PROGRAM, "status": "finished", **summary})
            with output_errors(self.path):
                (self.path / RESTART).unlink(missing_ok=True)
        except OutputError as error:
            raise OutputError(f"{error}; {self._kept()}") from error
        self._finished = True

    def _make(self) -> None:
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            names = [entry.name for entry in self.path.iterdir()]
        except OSError as error:
            raise OutputError(
                f"cannot use {self.path} as the result folder: {error.strerror}; choose another folder"
            ) from error
        if not _is_ours(self.path, names):
            raise OutputError(
                f"{self.path} is not empty and holds no {_PROGRAM} result; choose another folder or empty it"
            )

    def _clear(self) -> None:
        with output_errors(self.path):
            for entry in self.path.iterdir():
                if _OWNED.fullmatch(entry.name):
                    entry.unlink()

    def _note(self, status: str, **more: Any) -> None:
        last = self._history[-1] if self._history else None
        progress = {
            "program": _PROGRAM,
            "status": status,
            "accepted_steps": len(self._history),
            "load_factor": last and last.load_factor,
            "plate_displacement": last and last.plate_displacement,
        }
        write_summary(self.path, progress | more)

    def _kept(self) -> str:
        if not self._history:
            return "no step had been accepted"
        count, load = len(self._history), self._history[-1].load_factor
        subject, verb = ("step", "is") if count == 1 else ("steps", "are")
        return f"{count} accepted {subject} up to load factor {load:.6g} {verb} kept in {self.path}"


def _is_ours(path: Path, names: Sequence[str]) -> bool:
    if SUMMARY in names:
        with suppress(OutputError):
            return read_summary(path).get("program") == _PROGRAM
        return False
    return all(_DRAFT.fullmatch(name) for name in names)


def _last_pairs(path: Path) -> list[PairOnset]:
    """Return the wall pairs of the last level in a table."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    last = [row for row in rows if row["step"] == rows[-1]["step"]]
    return [(int(row["cell_a"]), int(row["cell_b"]), float(row["onset"])) for row in last]
