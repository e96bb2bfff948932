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


def replace_file(path: Path, content: bytes) -> None:
    """Write `path` so that a reader sees the old content or the new one, never a part of it.

    Raises
    ------
    OutputError
        If the file cannot be written; its old content is kept.
    """
    draft = path.with_name(f".{path.name}.tmp")
    with output_errors(path):
        try:
            draft.write_bytes(content)
            os.replace(draft, path)
        except OSError:
            with suppress(OSError):
                draft.unlink()
            raise
