"""Whose folder it is: a run writes into an empty folder or over a result of its own kind, never over other files.

`summary.json` is the mark of ownership: it names the program, and is the first file that a run writes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from ngcell.errors import OutputError
from ngcell.export.atomic import output_errors
from ngcell.export.summary import SUMMARY, read_summary

PROGRAM = "ngcell"
_DRAFT = re.compile(r"\..+\.tmp")
_WRITTEN = re.compile(
    r"case\.toml|(history|walls|cells)\.csv|restart\.npz|tissue\.pvd|(tissue|walls)_\d{4,}\.vtu|"
    r"(tissue|gap|debonding)\.png|\..+\.tmp"
)


def claim_folder(path: Path) -> None:
    """Make the folder of a run if it is not there, and make sure that nothing else is in it.

    Raises
    ------
    OutputError
        If the folder cannot be made or read, or holds something that is not a result.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        names = [entry.name for entry in path.iterdir()]
    except OSError as error:
        raise OutputError(f"cannot use {path} as the result folder: {error.strerror}; choose another folder") from error
    if not _is_ours(path, names):
        raise OutputError(f"{path} is not empty and holds no {PROGRAM} result; choose another folder or empty it")


def clear_folder(path: Path) -> None:
    """Remove what an earlier run wrote into the folder, its summary excepted; leave other files alone.

    Raises
    ------
    OutputError
        If a file cannot be removed.
    """
    with output_errors(path):
        for entry in path.iterdir():
            if _WRITTEN.fullmatch(entry.name):
                entry.unlink()


def _is_ours(path: Path, names: Sequence[str]) -> bool:
    if SUMMARY in names:
        with suppress(OutputError):
            return read_summary(path).get("program") == PROGRAM
        return False
    return all(_DRAFT.fullmatch(name) for name in names)
