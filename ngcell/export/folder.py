"""The folder of a run: every accepted step is in it, whatever ends the run.

A step is on disk when `accept` returns; a step that cannot be written in full is taken back. `summary.json` says
`running` until the run ends, so that a killed run is recognised and its folder may be used again, and `restart.npz`
holds until then what the run can be resumed from. One run at a time writes into a folder.

Accepted steps of an earlier run are replaced only where that is asked for, and not before the new run has accepted a
step of its own: a case that turns out to be wrong costs nobody a result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self
from zlib import crc32

from numpy.typing import NDArray

from ngcell.errors import OutputError
from ngcell.export.atomic import output_errors, replace_file
from ngcell.export.curves import draw_curves
from ngcell.export.debonding import PairOnset, draw_debonding, read_last_ends, read_last_pairs
from ngcell.export.outline import is_drawn_from_above
from ngcell.export.ownership import CASE_FILE, PROGRAM, claim_folder, clear_folder, held_already, holds_result
from ngcell.export.picture import draw_tissue
from ngcell.export.restart import RESTART, Restart, cannot_resume, read_restart, write_restart
from ngcell.export.series import SnapshotSeries, read_last_snapshot
from ngcell.export.summary import CASE_TEXT, read_summary, write_summary
from ngcell.export.tables import RecordTable
from ngcell.results.cells import end_of_cell
from ngcell.results.record import CellRecord, StepRecord, WallRecord
from ngcell.results.report import StepReport
from ngcell.results.snapshot import Snapshot

_TABLES = ("history.csv", "walls.csv", "cells.csv")


class ResultFolder:
    """The folder of one run, open from its start to its end.

    Entering makes the folder, locks it, and opens the tables. Where it holds accepted steps of an earlier run, these
    give way to the first step that is accepted; other files are not touched. Leaving without `finish` notes in the
    summary that the run was stopped, and why.

    Parameters
    ----------
    path : Path
        A folder that does not exist, is empty, or holds an earlier result.
    force : bool
        Whether accepted steps of an earlier run may be replaced.
    case_text : str, optional
        The resolved case, written as `case.toml`.
    restart : Restart, optional
        Checkpoint of the run that stopped in this folder; what it wrote up to there is kept, and the run goes on.
    pictures : bool
        Whether `draw` and `finish` draw pictures.

    Raises
    ------
    OutputError
        On entering: the folder cannot be made, is in use by another run, or holds something that must stay. Later: a
        file cannot be written.

    Examples
    --------
    >>> with ResultFolder(Path("out"), case_text=text) as folder:  # doctest: +SKIP
    ...     folder.accept(record, walls, snapshot)
    ...     folder.finish({"certified": True})
    """

    def __init__(
        self,
        path: Path,
        *,
        case_text: str | None = None,
        restart: Restart | None = None,
        force: bool = False,
        pictures: bool = True,
    ) -> None:
        self.path, self._force, self._pictures = Path(path), force, pictures
        self._case_text, self._restart = case_text, restart
        self._reports = list(restart.reports) if restart else []
        self._history = [report.record for report in self._reports]
        self._last: Snapshot | None = None
        self._pairs: Sequence[PairOnset] = ()
        self._ends: Sequence[str] = ()
        self._is_open = self._drawn = self._finished = False

    def __enter__(self) -> Self:
        self._lock = claim_folder(self.path)
        try:
            if self._restart is not None:
                self._go_on(self._restart)
            elif not holds_result(self.path):
                self._begin()
            elif not self._force:
                raise held_already(self.path)
        except BaseException:
            self._lock.release()
            raise
        return self

    def _begin(self) -> None:
        """Make the folder this run's own: whatever ends it from here on, the run can be resumed."""
        self._note("running", **({} if self._case_text is None else {CASE_TEXT: self._case_text}))
        clear_folder(self.path)
        if self._case_text is not None:
            replace_file(self.path / CASE_FILE, self._case_text.encode())
        self._note("running")
        self._open_tables({})
        self._series = SnapshotSeries(self.path)
        self._is_open = True

    def _open_tables(self, sizes: Mapping[str, int]) -> None:
        """Open each table after its first bytes, or a new one where no size is given."""
        history, walls, cells = (self.path / name for name in _TABLES)
        self._steps = RecordTable(history, StepRecord, size=sizes.get(history.name))
        self._walls = RecordTable(walls, WallRecord, size=sizes.get(walls.name))
        self._cells = RecordTable(cells, CellRecord, size=sizes.get(cells.name))

    def _go_on(self, restart: Restart) -> None:
        if read_summary(self.path).get("status") == "finished":
            raise OutputError(f"{self.path} needs no resuming: another run ended it meanwhile")
        if len(read_restart(self.path).reports) != len(restart.reports):
            raise OutputError(f"{self.path} was gone on with by another run meanwhile; resume it again")
        self._series = SnapshotSeries(self.path, snapshots=restart.snapshots, checksums=restart.checksums)
        damage = self._series.damage
        if damage is not None:
            raise cannot_resume(self.path, damage)
        for name, size in restart.table_sizes.items():
            if not (self.path / name).is_file():
                raise cannot_resume(self.path, f"{name} is missing")
            if restart.checksums.get(name) not in (None, _checksum(self.path / name, size)):
                raise cannot_resume(self.path, f"{name} is not the table that it was")
        try:
            self._open_tables({name: restart.table_sizes[name] for name in _TABLES})
            self._pairs = read_last_pairs(self.path / "walls.csv")
            self._ends = read_last_ends(self.path / "cells.csv")
        except (OutputError, KeyError) as error:
            raise cannot_resume(self.path, str(error)) from error
        self._series.write_list()
        self._is_open = True
        self._note("running")

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if self._is_open:
                self._close(error)
        finally:
            self._lock.release()

    def _close(self, error: BaseException | None) -> None:
        for table in (self._steps, self._walls, self._cells):
            table.close()
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

        The run can be resumed after this step if `report` is given, which the summary at the end is made of, and
        `checkpoint`, the arrays that the next step depends on.

        Raises
        ------
        OutputError
            If a part cannot be written; the steps before it are kept, and the message says where.
        """
        if not self._is_open:
            self._begin()
        tables: tuple[RecordTable[Any], ...] = self._walls, self._cells, self._steps
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
        self._ends = [end_of_cell(row) for row in cells if row.more] or self._ends
        if report is not None and checkpoint is not None:
            self._reports.append(report)
            self._remember(checkpoint)
        self._note("running")

    def _remember(self, checkpoint: Mapping[str, NDArray[Any]]) -> None:
        sizes = dict(zip(_TABLES, (self._steps.size, self._walls.size, self._cells.size), strict=True))
        try:
            checksums = {name: _checksum(self.path / name, size) for name, size in sizes.items()}
            restart = Restart(
                case_text=self._case_text or "",
                checkpoint=checkpoint,
                reports=tuple(self._reports),
                table_sizes=sizes,
                snapshots=self._series.snapshots,
                checksums=self._series.checksums | checksums,
            )
            write_restart(self.path, restart)
        except OutputError as error:
            raise OutputError(f"{error}; {self._kept()}") from error

    def draw(self, *, title: str = "", certified: bool, onset: float | None = None) -> None:
        """Draw `tissue.png` of the last snapshot, `gap.png` and `debonding.png`; those without data are left out.

        Raises
        ------
        OutputError
            If a picture cannot be written.
        """
        self._drawn = True
        if not (self._is_open and self._pictures):
            return
        if self._last is None and self._series.snapshots:
            self._last, _ = read_last_snapshot(self.path)
        if self._history:
            draw_curves(self._history, self.path / "gap.png", certified=certified, onset=onset)
        if (seen := self._last) is not None and is_drawn_from_above(seen.bulk):
            draw_tissue(seen, self.path / "tissue.png", title=title, certified=certified)
            if self._pairs:
                drawn = self._history, self._pairs, seen.bulk, self.path / "debonding.png"
                draw_debonding(*drawn, certified=certified, ends=self._ends)

    def finish(self, summary: Mapping[str, Any]) -> None:
        """Write the summary of the ended run, after the pictures if `draw` was not called.

        A run that accepted no step leaves an earlier result as it is.

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
        if not self._is_open:
            return
        try:
            if not self._drawn:
                self.draw(
                    title=summary.get("title") or "",
                    certified=bool(summary.get("certified")),
                    onset=summary.get("onset"),
                )
            write_summary(self.path, {"program": PROGRAM, "status": "finished", **summary})
            self._finished = True
            with output_errors(self.path):
                (self.path / RESTART).unlink(missing_ok=True)
        except OutputError as error:
            raise OutputError(f"{error}; {self._kept()}") from error

    def _note(self, status: str, **more: Any) -> None:
        last = self._history[-1] if self._history else None
        progress = {
            "program": PROGRAM,
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


def _checksum(path: Path, size: int) -> int:
    """Return the CRC-32 of the first bytes of a file."""
    with output_errors(path), path.open("rb") as file:
        return crc32(file.read(size))
