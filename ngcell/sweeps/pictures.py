"""Small pictures of some cases of a sweep, spread over the study.

The folder of a run goes when the run has ended, maybe on another machine. What is left is a picture, which comes back
with the result, is in the store with it, and is written into the folder of the sweep beside the table.
"""

from __future__ import annotations

from base64 import b64decode, b64encode
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from ngcell.export import small_tissue
from ngcell.export.atomic import output_errors, replace_file
from ngcell.sweeps.task import Result

#: Folder of the pictures in that of the sweep, and the names of their files.
_FOLDER, _NAME = "pictures", "case_{:06d}.png"


def pictured(numbers: Sequence[int], most: int) -> set[int]:
    """Return which cases get a picture: all, or `most` of them at equal distances, the first and the last included."""
    if len(numbers) <= most:
        return set(numbers)
    return {numbers[place] for place in np.linspace(0, len(numbers) - 1, most).round().astype(int).tolist()}


def picture_of(run: Path, *, certified: bool) -> str | None:
    """Return a small picture of the last level of a run as a result has it, in base64; None where there is none."""
    content = small_tissue(run, certified=certified)
    return None if content is None else b64encode(content).decode()


class Pictures:
    """The pictures in the folder of a sweep; those of an earlier table are removed.

    Parameters
    ----------
    out : Path
        The folder of the sweep.
    """

    def __init__(self, out: Path) -> None:
        self._folder = out / _FOLDER
        for file in self._folder.glob(_NAME.format(0).replace("000000", "*")):
            with output_errors(file):
                file.unlink()

    def keep(self, number: int, result: Result) -> None:
        """Write the picture of a case, if its result has one."""
        content = result.get("picture")
        if not content:
            return
        with output_errors(self._folder):
            self._folder.mkdir(exist_ok=True)
        with suppress(ValueError):  # of a store that was damaged
            replace_file(self._folder / _NAME.format(number), b64decode(content, validate=True))
