"""The code that a result comes from; a worker tells it without the solver, which only the runs that it starts load."""

from __future__ import annotations

import sys
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

#: Where the package is.
SOURCE = Path(__file__).parents[2]
#: Rooms that no number of a run depends on.
_TELLING = ("cli", "sweeps", "export", "report")


def own_version() -> str:
    """Return the version of ngcell; its table of contents names the sweep, and is not to be imported from here."""
    return str(sys.modules["ngcell"].__version__)


@cache
def code_told() -> str:
    """Return versions of ngcell, with a digest of its sources, and of NGSolve."""
    package, digest = SOURCE / "ngcell", sha256()
    for file in sorted(package.rglob("*.py")):
        place = file.relative_to(package)
        if place.parts[0] not in _TELLING:
            digest.update(f"{place.as_posix()}\n".encode() + file.read_bytes())
    return f"ngcell {own_version()} {digest.hexdigest()}, ngsolve {version('ngsolve')}, {sys.byteorder}"
