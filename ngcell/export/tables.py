"""Tables that grow by a row as the run goes.

Every append is one unbuffered write followed by fsync, so that a killed run leaves whole rows only; an append
that fails leaves the table as it was.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import Any, Generic, TypeVar, get_type_hints

import numpy as np

from ngcell.errors import OutputError
from ngcell.export.atomic import output_errors

Record = TypeVar("Record")

_MORE = "more"


class RecordTable(Generic[Record]):
    """A CSV file with one column per field of a record class and one row per record.

    A record class may have a field ``more: Mapping[str, float]``. Its entries are further columns, after those of the
    other fields and in the order of the first record. The first record fixes these columns: every other one must have
    the same. Floats are written with as many digits as their exact value needs.

    Parameters
    ----------
    path : Path
        The file; replaced if it exists.
    record_type : type
        Dataclass of the rows.
    size : int, optional
        Go on with the existing table after its first `size` bytes instead.
    more : sequence of str, optional
        Names of the further columns. By default the first record tells them, and the header of a record class with
        the field `more` is written together with its first row; else the header is written at once.

    Raises
    ------
    OutputError
        If the file cannot be written, here or at an append, or is no such table of that size; at an append also if
        the further columns of a record are not those of the table.
    """

    def __init__(
        self,
        path: Path,
        record_type: type[Record],
        *,
        size: int | None = None,
        more: Sequence[str] | None = None,
    ) -> None:
        self.path = Path(path)
        names = [column.name for column in fields(record_type)]  # type: ignore[arg-type]
        self._fixed = [name for name in names if name != _MORE]
        self._open_ended = _MORE in names
        self._more: Sequence[str] = ()
        with output_errors(self.path):
            self._file = open(self.path, "wb" if size is None else "r+b", buffering=0)
        if size is not None:
            self._go_on(size, more)
        elif more is not None or not self._open_ended:
            self._choose_more(more or ())
            self._write([self._header])

    @property
    def size(self) -> int:
        """Bytes written so far: what `rewind` takes to come back here."""
        return self._file.tell()

    def append(self, *records: Record) -> None:
        """Add a row for each record, on disk when this returns; all of them or none."""
        if not records:
            return
        header = []
        if not self.size:
            self._choose_more(tuple(_more_of(records[0])))
            header = [self._header]
        self._write(header + [self._row(record) for record in records])

    def rewind(self, size: int) -> None:
        """Drop everything after the first `size` bytes."""
        with output_errors(self.path):
            self._file.truncate(size)
            self._file.seek(size)

    def close(self) -> None:
        """Close the file; the rows are on disk already."""
        self._file.close()

    @property
    def _header(self) -> list[str]:
        return [*self._fixed, *self._more]

    def _row(self, record: Record) -> list[str]:
        more = _more_of(record)
        if more.keys() != set(self._more):
            raise OutputError(
                f"{self.path} has the further columns {list(self._more)}, a row {list(more)}; the first row fixes them"
            )
        return [
            *(_text(getattr(record, name)) for name in self._fixed),
            *(_text(more[name]) for name in self._more),
        ]

    def _choose_more(self, names: Sequence[str]) -> None:
        if twice := sorted(set(names) & set(self._fixed)):
            raise OutputError(f"{self.path} has a column {twice[0]!r} already; a further one needs another name")
        self._more = tuple(names)

    def _go_on(self, size: int, more: Sequence[str] | None) -> None:
        """Keep the first `size` bytes, which must be a header and whole rows, and its further columns."""
        kept = self._file.read(size)
        if not size and self._open_ended:
            header = self._fixed  # the table had no row yet, and so no header
        else:
            header = _header_of(kept)
        found = header[len(self._fixed) :]
        same = header[: len(self._fixed)] == self._fixed and (self._open_ended or not found)
        if len(kept) < size or not same or (more is not None and list(more) != found):
            self._file.close()
            raise OutputError(f"{self.path} is not the table that it was: rows or columns are missing")
        self._more = tuple(found)
        self.rewind(size)

    def _write(self, rows: list[list[str]]) -> None:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows)
        start = self.size
        with output_errors(self.path):
            try:
                self._write_through(text.getvalue().encode())
            except OSError:
                with suppress(OSError):
                    self._file.truncate(start)
                    self._file.seek(start)
                raise

    def _write_through(self, content: bytes) -> None:
        while content:  # a nearly full disk takes a part before it refuses the rest
            content = content[self._file.write(content) :]
        os.fsync(self._file.fileno())


def read_records(path: Path, record_type: type[Record]) -> list[Record]:
    """Read the rows of a table of whole rows, as they were written.

    Raises
    ------
    OutputError
        If there is none, or it is not of this record class.
    """
    types = {name: kind for name, kind in get_type_hints(record_type).items() if name != _MORE}
    try:
        with Path(path).open(newline="", encoding="utf-8") as file:
            return [_record_of(row, record_type, types) for row in csv.DictReader(file)]
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, UnicodeDecodeError, csv.Error) as error:
        raise OutputError(f"{path} is not the table that it was: {error}") from error


def _record_of(row: Mapping[str, str], record_type: type[Record], types: Mapping[str, Any]) -> Record:
    read: dict[Any, Any] = {bool: lambda text: text == "True", int: int, float: float}
    values = {name: read.get(kind, str)(row[name]) for name, kind in types.items()}
    if _MORE in {column.name for column in fields(record_type)}:  # type: ignore[arg-type]
        values[_MORE] = {name: float(text) for name, text in row.items() if name not in types}
    return record_type(**values)


def _more_of(record: object) -> Mapping[str, Any]:
    more: Mapping[str, Any] = getattr(record, _MORE, {})
    return more


def _header_of(table: bytes) -> list[str]:
    """Return the names of the columns of a table that ends with a whole row; of another one none."""
    if not table.endswith(b"\n"):
        return []
    return next(csv.reader(io.StringIO(table.decode(errors="replace"), newline="")), [])


def _text(value: object) -> str:
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return str(value)
