"""Prismatic tissues to look at: cases, and the same built by hand."""

from __future__ import annotations

from functools import lru_cache
from math import inf
from typing import Any

from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.scene import Case

MATERIAL = {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0}
SOFT = {"kind": "mooney-rivlin", "c1": 0.05, "c2": 0.05, "bulk_modulus": 10.0}


def case(height: float | None, *, ends: str | None = None, **parts: Any) -> Case:
    """Two cells between plates, sheared; a part that is given replaces that of the case."""
    mesh = {"order": 2, "size": 1.0} | ({} if height is None else {"slices": 1})
    load = {"kind": "plates", "displacement": (0.2, 0.0), "levels": 1} | ({} if ends is None else {"ends": ends})
    tissue = {"rows": 1, "cols": 2, "wall": 0.1} | ({} if height is None else {"height": height})
    table = {"tissue": tissue, "material": MATERIAL, "load": load, "mesh": mesh, "accuracy": inf}
    return Case.model_validate(table | parts)


@lru_cache(maxsize=8)  # tests of a file compare the same few scenes
def last_step(scene: Case) -> Step:
    return list(Simulation(scene).accepted_steps())[-1]
