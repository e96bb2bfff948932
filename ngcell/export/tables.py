"""Tables that grow by a row as the run goes.

Every append is one unbuffered write followed by fsync, so that a killed run leaves whole rows only; an append
that fails leaves the table as it was.
"""

from __future__ import annotations

import csv
import io
import os
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np

from ngcell.errors import OutputError
from ngcell.export.atomic import output_errors

Record = TypeVar("Record")


class RecordTable(Generic[Record]):
    """A CSV file with one column per field of a record class and one row per record.

    Floats are written with as many digits as their exact value needs.

    Parameters
    ----------
    path : Path
        The file; replaced if it exists. Its header is written at once.
    record_type : type
        Dataclass of the rows.
    size : int, optional
        Go on with the existing table after its first `size` bytes instead.

    Raises
    ------
    OutputError
        If the file cannot be written, here or at an append, or is no such table of that size.
    """

    def __init__(self, path: Path, record_type: type[Record], *, size: int | None = None) -> None:
        self.path = Path(path)
        self._columns = [column.name for column in fields(record_type)]  # type: ignore[arg-type]
        with output_errors(self.path):
            self._file = open(self.path, "wb" if size is None else "r+b", buffering=0)
        if size is None:
            self._write([self._columns])
            return
        kept = self._file.read(size)
        if len(kept) < size or not kept.startswith(f"{','.join(self._columns)}\n".encode()):
            self._file.close()
            raise OutputError(f"{self.path} is not the table that it was: rows or columns are missing")
        self.rewind(size)

    @property
    def size(self) -> int:
        """Bytes written so far: what `rewind` takes to come back here."""
        return self._file.tell()

    def append(self, *records: Record) -> None:
        """Add a row for each record, on disk when this returns; all of them or none."""
        if records:
            self._write([[_text(getattr(record, name)) for name in self._columns] for record in records])

    def rewind(self, size: int) -> None:
        """Drop everything after the first `size` bytes."""
        with output_errors(self.path):
            self._file.truncate(size)
            self._file.seek(size)

    def close(self) -> None:
        """Close the file; the rows are on disk already."""
        self._file.close()

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


def _text(value: object) -> str:
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return str(value)
