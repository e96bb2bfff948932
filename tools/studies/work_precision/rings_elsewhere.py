"""The rings as other programs are given them: mesh and penalty of this package, and a row of what they found."""

from __future__ import annotations

import json
from typing import Any

import ngsolve

from ngcell import Penalty
from tools.solutions import meshed
from tools.studies.work_precision import rings
from tools.studies.work_precision.grid import Setting


def mesh_and_stiffness(setting: Setting) -> tuple[ngsolve.Mesh, float]:
    """Return the mesh, and the stiffness of the default penalty: about ten times a layer of elements."""
    mesh, modulus = meshed(rings.scene(setting.problem, Penalty(), setting.order, setting.size))
    return mesh, 10 * modulus / (rings.MISMATCH * setting.size * 3**0.5 / 4)


def row(setting: Setting, at: list[Any], hoop: float, unknowns: int, iterations: int, seconds: float) -> dict[str, Any]:
    """Return what is compared of a solution: places on the circles, hoop force, and what it took."""
    found = rings.compared(setting.problem, at, hoop=hoop)
    return {
        **{f"error_{name}": value for name, value in found.items()},
        "unknowns": unknowns,
        "iterations": iterations,
        "seconds": round(seconds, 3),
        "phases": json.dumps({}),
    }
