"""Other programs on the rings: the same meshes, laws, supports and loads, an error and a time.

`naive` is NGSolve as its tutorial on contact has it, `calculix` is CalculiX. Stiffnesses are those of this package's
default penalty.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

from tools.studies.work_precision.calculix import calculix
from tools.studies.work_precision.grid import Setting
from tools.studies.work_precision.naive import naive

PROBLEMS = ("press-fit", "above")
SOLVERS: dict[str, Callable[[Setting], dict[str, Any]]] = {"naive": naive, "calculix": calculix}


def settings(quick: bool) -> Iterator[Setting]:
    """Yield what the others are asked to solve."""
    for size, problem in product((0.25, 0.125) if quick else (0.25, 0.125, 0.0625), PROBLEMS):
        for order in (2, 3):
            yield Setting("naive", problem, "naive", order, size)
        yield Setting("calculix", problem, "calculix", 1, size)


def missing() -> list[str]:
    """Return what is not installed here, in words."""
    lines = [] if shutil.which("ccx") else ["CalculiX: no program `ccx` (Debian: calculix-ccx); its lines are left out"]
    return [*lines, "GetFEM: no script for these scenes; its line is left out"]


def available(setting: Setting) -> bool:
    """Return whether a peer can run here."""
    return setting.kind != "calculix" or shutil.which("ccx") is not None
