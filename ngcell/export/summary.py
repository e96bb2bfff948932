"""The summary of a run as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ngcell.errors import OutputError
from ngcell.export.atomic import replace_file

SUMMARY = "summary.json"
#: Key of a run whose `case.toml` is about to be written: what it will say.
CASE_TEXT = "case"
#: Key of a sweep: its first case, fully resolved.
FIRST_CASE = "first_case"
#: Key by which a folder of members of a case is known: how many, of which seeds.
MEMBERS = "members"


def write_summary(folder: Path, summary: Mapping[str, Any]) -> None:
    """Replace `summary.json` of `folder`, in full or not at all; a number that is not finite becomes null.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    text = json.dumps(_plain(summary), indent=2, ensure_ascii=False, allow_nan=False)
    replace_file(Path(folder) / SUMMARY, f"{text}\n".encode())


def read_summary(folder: Path) -> dict[str, Any]:
    """Read `summary.json` of `folder`.

    Raises
    ------
    OutputError
        If there is none, or it is not a JSON object.
    """
    path = Path(folder) / SUMMARY
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror}; is {folder} the result of a run?") from error
    except ValueError as error:
        raise OutputError(f"{path} is not JSON: {error}") from error
    if not isinstance(summary, dict):
        raise OutputError(f"{path} holds a {type(summary).__name__}, not an object")
    return summary


def accepted_steps(folder: Path, summary: Mapping[str, Any]) -> int:
    """Return the number of accepted steps that a summary of `folder` tells.

    Raises
    ------
    OutputError
        If it is no number of steps.
    """
    count = summary.get("accepted_steps") or 0
    if isinstance(count, bool) or not isinstance(count, int) or count < 0:
        raise OutputError(f"{Path(folder) / SUMMARY}: accepted_steps = {count!r} is no number of steps; allowed: >= 0")
    return count


def failed_checks(summary: Mapping[str, Any]) -> list[str]:
    """Return the names of the checks that any step of a run has failed."""
    return list(dict.fromkeys(name for names in (summary.get("failed_steps") or {}).values() for name in names))


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Path):
        return str(value)
    return value
