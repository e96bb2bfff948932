"""The tail of a continuation: the share of its work that hardly moves the energy, from what the solver tells."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager
from io import StringIO

import numpy as np

#: What the solver tells of a minimisation on the way, and of the end of a mesh.
_TOLD = re.compile(
    r"proximal weight .* (?P<factorisations>\d+) factorisations, .* energy (?P<energy>\S+),"
    r"|refinement: mesh (?P<mesh>\d+)"
)
#: Share of the energy within which no minimisation of a tail moves it.
_SETTLED = 3e-4


@contextmanager
def listened() -> Iterator[StringIO]:
    """Collect what the package tells meanwhile."""
    log, package = StringIO(), logging.getLogger("ngcell")
    handler, level = logging.StreamHandler(log), package.level
    handler.setFormatter(logging.Formatter("%(name)s: %(message)s"))
    package.addHandler(handler)
    package.setLevel(logging.INFO)
    try:
        yield log
    finally:
        package.removeHandler(handler)
        package.setLevel(level)


def tail_of(log: str) -> str:
    """Return the share of factorisations after which the energy on a mesh hardly changes, as a text; "" without any."""
    meshes: list[list[tuple[int, float]]] = [[]]
    for told in _TOLD.finditer(log):
        if told["mesh"]:
            meshes.append([])
        else:
            meshes[-1].append((int(told["factorisations"]), float(told["energy"])))
    tail = 0
    for minimisations in meshes:
        moving = [abs(energy - minimisations[-1][1]) > _SETTLED * abs(energy) for _, energy in minimisations]
        settled = 1 + max(np.flatnonzero(moving), default=-1)
        tail += sum(factorisations for factorisations, _ in minimisations[settled + 1 :])
    total = sum(factorisations for minimisations in meshes for factorisations, _ in minimisations)
    return f"{tail / total:.2f}" if total else ""
