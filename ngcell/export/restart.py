"""The checkpoint that a stopped run is resumed from: one small file, replaced after each accepted step.

It holds the lengths of the tables and the list of snapshots at that moment. What the run wrote later belongs to a step
that may be incomplete: a resumed run cuts it off and computes that step again.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import OutputError
from ngcell.export.atomic import replace_file
from ngcell.results.report import StepReport

RESTART = "restart.npz"
_NOTES = "notes"
_CHECKPOINT = "checkpoint_"


@dataclass(frozen=True, eq=False)
class Restart:
    """What a stopped run is resumed from.

    Attributes
    ----------
    case_text : str
        The resolved case.
    checkpoint : mapping of str to array
        State of the load stepping: the arrays that the next step depends on.
    reports : tuple of StepReport
        The accepted steps.
    table_sizes : mapping of str to int
        Length of each table, by file name [byte].
    snapshots : tuple of (int, float, float)
        Step, load factor and plate displacement of each snapshot.
    checksums : mapping of str to int
        CRC-32 of each file that the run goes on with, by file name; of tables, of what `table_sizes` says.
    """

    case_text: str
    checkpoint: Mapping[str, NDArray[Any]]
    reports: tuple[StepReport, ...]
    table_sizes: Mapping[str, int]
    snapshots: tuple[tuple[int, float, float], ...]
    checksums: Mapping[str, int] = field(default_factory=dict)


def write_restart(folder: Path, restart: Restart) -> None:
    """Replace the restart file of `folder`, in full or not at all.

    Raises
    ------
    OutputError
        If the file cannot be written; the one before is kept.
    """
    notes = {
        "case_text": restart.case_text,
        "reports": [report.plain() for report in restart.reports],
        "table_sizes": dict(restart.table_sizes),
        "snapshots": restart.snapshots,
        "checksums": dict(restart.checksums),
    }
    content = io.BytesIO()
    arrays: dict[str, Any] = {f"{_CHECKPOINT}{name}": values for name, values in restart.checkpoint.items()}
    arrays[_NOTES] = np.frombuffer(json.dumps(notes).encode(), dtype=np.uint8)
    np.savez(content, **arrays)
    replace_file(Path(folder) / RESTART, content.getvalue())


def read_restart(folder: Path) -> Restart:
    """Read the restart file of `folder`.

    Raises
    ------
    OutputError
        If there is none, or it is damaged.
    """
    path = Path(folder) / RESTART
    try:
        with np.load(path, allow_pickle=False) as content:
            notes = json.loads(content[_NOTES].tobytes())
            checkpoint = {
                name.removeprefix(_CHECKPOINT): content[name] for name in content if name.startswith(_CHECKPOINT)
            }
        return Restart(
            case_text=notes["case_text"],
            checkpoint=checkpoint,
            reports=tuple(StepReport.from_plain(report) for report in notes["reports"]),
            table_sizes=notes["table_sizes"],
            snapshots=tuple((int(step), float(load), float(far)) for step, load, far in notes["snapshots"]),
            checksums=dict(notes.get("checksums", {})),
        )
    except OSError as error:
        raise cannot_resume(folder, f"{RESTART} cannot be read ({error.strerror or error})") from error
    except (zipfile.BadZipFile, ValueError, KeyError, TypeError, AttributeError, EOFError) as error:
        raise cannot_resume(folder, f"{RESTART} is damaged ({error})") from error


def cannot_resume(folder: Path, reason: str) -> OutputError:
    """Return the error that says why a run cannot be resumed, and what to do instead."""
    return OutputError(
        f"cannot resume {folder}: {reason}; start again with: ngcell solve {folder}/case.toml --out {folder} --force"
    )
