"""Results by content: one file for each case that was run, which sweeps may share.

A file is written in full or not at all, and its name says all that its content depends on but for the time that a run
was given: whichever of two sweeps writes it last, it says the same. What ended for want of time, or was killed, never
takes the place of a result that a run would end in again.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from uuid import uuid4

from ngcell.export.atomic import output_errors, replace_file
from ngcell.sweeps.task import Result


class Store:
    """Results of cases in a folder.

    Parameters
    ----------
    folder : Path
        Where they are; made if it is not there.

    Raises
    ------
    OutputError
        The folder cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)
        with output_errors(self.folder):
            self.folder.mkdir(parents=True, exist_ok=True)

    def read(self, key: str) -> Result | None:
        """Return the result of a case; None where there is none that can be read."""
        try:
            found = json.loads(self._file(key).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return found if isinstance(found, dict) and found.get("key") == key else None

    def holds(self, key: str) -> bool:
        """Return whether a case needs no run: it has one that would end in the same way again."""
        found = self.read(key)
        return found is not None and bool(found.get("final"))

    def write(self, result: Mapping[str, Any]) -> None:
        """Keep a result, unless there is one that is final, and this one is not.

        Raises
        ------
        OutputError
            It cannot be written.
        """
        if not result.get("final") and self.holds(result["key"]):
            return
        file = self._file(result["key"])
        with output_errors(file):
            file.parent.mkdir(parents=True, exist_ok=True)
        # A draft of its own for each writer: two sweeps may end the same case at the same time.
        replace_file(file, (json.dumps(result, ensure_ascii=False) + "\n").encode(), draft=uuid4().hex)

    def _file(self, key: str) -> Path:
        return self.folder / key[:2] / f"{key}.json"
