"""Files that are written in full or not at all, and the message of a write that failed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ngcell.errors import OutputError


@contextmanager
def output_errors(path: Path) -> Iterator[None]:
    """Turn an `OSError` while `path` is written into an `OutputError` of one line."""
    try:
        yield
    except OSError as error:
        raise OutputError(
            f"cannot write {path}: {error.strerror or error}; free some space or choose another folder"
        ) from error


def replace_file(path: Path, content: bytes, *, draft: str = "") -> None:
    """Write `path` so that a reader sees the old content or the new one, never a part of it.

    Parameters
    ----------
    path : Path
        The file.
    content : bytes
        What it will hold.
    draft : str
        What tells the draft of this process from that of others, where several may write the file.

    Raises
    ------
    OutputError
        If the file cannot be written; its old content is kept.
    """
    written = path.with_name(f".{path.name}{draft}.tmp")
    with output_errors(path):
        try:
            written.write_bytes(content)
            os.replace(written, path)
        except OSError:
            with suppress(OSError):
                written.unlink()
            raise
