"""What a result depends on, as one name: the resolved case, the files that it names, and the code that runs it."""

from __future__ import annotations

import sys
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

from ngcell.recording import file_told
from ngcell.scene import AnyCase, resolved_toml

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


def content_key(case: AnyCase) -> str:
    """Return the name by which the result of a case is known, whatever its title: SHA-256, 64 hexadecimal digits."""
    untitled = case.model_copy(update={"title": "", "source": ""})
    return sha256(f"{resolved_toml(untitled)}{file_told(case)}# {code_told()}\n".encode()).hexdigest()
