"""The folder of all members of a case: a folder of its own for each of them, and tables and a picture over all.

`members.csv` has a row for each member and level, `spread.csv` one for each level and number. Both are made again
whenever a member has ended, so that a run that is stopped leaves what it has found.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, astuple, fields
from math import nan
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from ngcell.errors import OutputError
from ngcell.export.atomic import output_errors, replace_file
from ngcell.export.ownership import CASE_FILE, PROGRAM, claim_folder, clear_folder, held_already, holds_result
from ngcell.export.spread import draw_spread
from ngcell.export.summary import CASE_TEXT, MEMBERS, SUMMARY, write_summary
from ngcell.results.spread import Member, Spread, errors_of, numbers_of


class EnsembleFolder:
    """The folder of all members, open from the first to the last.

    Parameters
    ----------
    path : Path
        A folder that does not exist, is empty, or holds an earlier result.
    case_text : str
        The resolved case that members are made from.
    told : mapping of str to Any
        How they are made: what a resumed run needs to know besides the case.
    force : bool
        Whether an earlier result may be replaced; members give way one by one.
    resumed : bool
        Whether these members have been begun in this folder before.
    pictures : bool
        Whether `finish` draws a picture.

    Raises
    ------
    OutputError
        On entering: the folder cannot be made, is in use, or holds what must stay. Later: it cannot be written.
    """

    def __init__(
        self,
        path: Path,
        *,
        case_text: str,
        told: Mapping[str, Any],
        force: bool = False,
        resumed: bool = False,
        pictures: bool = True,
    ) -> None:
        self.path, self._case_text, self._told = Path(path), case_text, dict(told)
        self._force, self._resumed, self._pictures = force, resumed, pictures
        self._accepted, self._is_open, self._finished = 0, False, False

    def __enter__(self) -> Self:
        self._lock = claim_folder(self.path)
        try:
            if self._resumed or not holds_result(self.path):
                self._begin()
            elif not self._force:
                raise held_already(self.path)
        except BaseException:
            self._lock.release()
            raise
        return self

    def _begin(self) -> None:
        """Make the folder that of these members: whatever ends them from here on, they can be resumed."""
        self._is_open = True
        self._note("running")
        if not self._resumed:
            clear_folder(self.path)
        replace_file(self.path / CASE_FILE, self._case_text.encode())

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if self._is_open and not self._finished:
                reason = str(error) or type(error).__name__ if error is not None else "not finished"
                with suppress(OutputError):  # the error that ends the run matters more than the note of it
                    self._note("stopped", reason=reason)
        finally:
            self._lock.release()

    def member(self, number: int) -> Path:
        """Return the folder of a member."""
        return member_folder(self.path, number)

    def count(self, steps: int) -> None:
        """Note that further steps have been accepted: an earlier result gives way to the first of them."""
        if not steps:
            return
        if not self._is_open:
            self._begin()
        first, self._accepted = self._accepted == 0, self._accepted + steps
        if first:  # a later run asks before it replaces them
            self._note("running")

    def keep(self, members: Sequence[Member], spreads: Sequence[Spread], factors: Sequence[float]) -> None:
        """Write the tables of the members so far; none before a step is accepted where an earlier result is. Then
        members that were refused have no earlier result either."""
        if not self._is_open:
            return
        for member in members:
            if member.is_refused:
                _remove(self.member(member.number))
        replace_file(self.path / "members.csv", _csv(_member_rows(members, factors)))
        replace_file(self.path / "spread.csv", _csv(_spread_rows(spreads)))

    def finish(self, members: Sequence[Member], spreads: Sequence[Spread], summary: Mapping[str, Any]) -> None:
        """Draw the picture and write the summary of the ended run; members of an earlier, larger run are removed."""
        if not self._is_open:
            return
        if self._pictures and spreads:
            draw_spread(members, spreads, self.path / "spread.png")
        kept = {self.member(member.number) for member in members}
        for folder in sorted(self.path.glob("member_*")):
            if folder not in kept:
                _remove(folder)
        head = {"program": PROGRAM, "status": "finished", "accepted_steps": self._accepted, MEMBERS: self._told}
        write_summary(self.path, {**head, **summary})
        self._finished = True

    def _note(self, status: str, **more: Any) -> None:
        known = {"program": PROGRAM, "status": status, "accepted_steps": self._accepted, MEMBERS: self._told}
        write_summary(self.path, {**known, CASE_TEXT: self._case_text, **more})


def member_folder(path: Path, number: int) -> Path:
    """Return the folder of a member in that of all."""
    return Path(path) / f"member_{number:03d}"


def _remove(folder: Path) -> None:
    """Remove the result of a member, if there is one, and its folder if nothing else is in it."""
    if not (folder / SUMMARY).is_file():
        return
    clear_folder(folder)
    with output_errors(folder):
        (folder / SUMMARY).unlink()
    with suppress(OSError):
        folder.rmdir()


def _member_rows(members: Sequence[Member], factors: Sequence[float]) -> list[list[Any]]:
    """Return a row for each member and level; numbers of levels that were not reached are NaN."""
    found = [record for member in members for record in member.levels if record]
    numbers = list(dict.fromkeys(name for record in found for name in numbers_of(record)))
    errors = list(errors_of(found[0])) if found else []
    header = ["member", "seed", "level", "load_factor", "plate_displacement", "certified", "outcome"]
    rows: list[list[Any]] = [[*header, *numbers, *(f"{name}_error" for name in errors)]]
    for member in members:
        for level, (record, factor) in enumerate(zip(member.levels, factors, strict=True)):
            place = [member.number, member.seed, level, factor, record.plate_displacement if record else nan]
            verdict = [record is not None and record.certified, member.outcome]
            mine, theirs = (numbers_of(record), errors_of(record)) if record else ({}, {})
            values = [*(mine.get(name, nan) for name in numbers), *(theirs.get(name, nan) for name in errors)]
            rows.append([*place, *verdict, *values])
    return rows


def _spread_rows(spreads: Sequence[Spread]) -> list[list[Any]]:
    return [[column.name for column in fields(Spread)], *map(list, map(astuple, spreads))]


def spread_table(spreads: Iterable[Spread]) -> list[dict[str, Any]]:
    """Return rows of `spread.csv` as a summary holds them."""
    return [asdict(spread) for spread in spreads]


def _csv(rows: Iterable[Iterable[Any]]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()
