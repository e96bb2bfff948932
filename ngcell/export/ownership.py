"""Whose folder it is: a run writes into an empty folder or, if told to, over a result of its own kind.

`summary.json` is the mark of ownership: it names the program, and is the first file that a run writes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from ngcell.errors import OutputError
from ngcell.export.atomic import output_errors, replace_file
from ngcell.export.lock import LOCK, FolderLock
from ngcell.export.summary import CASE_TEXT, SUMMARY, accepted_steps, read_summary

PROGRAM = "ngcell"
CASE_FILE = "case.toml"
_DRAFT = re.compile(r"\..+\.tmp")
_WRITTEN = re.compile(
    r"case\.toml|(history|walls|cells|members|spread)\.csv|restart\.npz|tissue\.pvd|(tissue|walls)_\d{4,}\.vtu|"
    r"(tissue|gap|debonding|spread)\.png|report\.html|sweep\.(csv|parquet)|\..+\.tmp"
)


def claim_folder(path: Path) -> FolderLock:
    """Make the folder of a run if it is not there, make sure that nothing else is in it, and lock it.

    Raises
    ------
    OutputError
        If the folder cannot be made or read, holds something that is not a result, or is another run's.
    """
    _check_ours(path)
    lock = FolderLock(path)
    try:
        _check_ours(path)
    except OutputError:
        lock.release()
        raise
    return lock


def holds_result(path: Path) -> bool:
    """Return whether accepted steps of an earlier run are in a folder that `claim_folder` has claimed."""
    if not (path / SUMMARY).exists():
        return False
    summary = read_summary(path)
    counted = "accepted_steps" in summary or summary.get("status") != "finished"
    return accepted_steps(path, summary) > 0 if counted else True


def held_already(path: Path) -> OutputError:
    """Return the error that says that a folder is left as it is."""
    return OutputError(
        f"{path} holds the accepted steps of an earlier run; "
        "replace them with --force (from Python: force=True) or choose another folder"
    )


def restore_case(path: Path, summary: Mapping[str, Any]) -> None:
    """Write the case of a run that was stopped just before it wrote it.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    text = summary.get(CASE_TEXT)
    if isinstance(text, str):
        replace_file(path / CASE_FILE, text.encode())


def _check_ours(path: Path) -> None:
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
    return all(_DRAFT.fullmatch(name) or name == LOCK for name in names)
