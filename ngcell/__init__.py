"""Simulate tissues of hollow, hyperelastic cells that press, slide and part: the table of contents."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ngcell.run import inspect, record, resume, simulate
    from ngcell.scene import (
        Body,
        BodyCase,
        BodyForce,
        BodyScene,
        BodySupport,
        Case,
        Cohesion,
        Expected,
        Frame,
        MeshChoice,
        MooneyRivlin,
        Mortar,
        Penalty,
        Plates,
        Pressure,
        Refinement,
        Sddp,
        SingleStep,
        Tissue,
        Traction,
        read_case,
    )

__version__ = "0.1.0"

__all__ = [
    "Body",
    "BodyCase",
    "BodyForce",
    "BodyScene",
    "BodySupport",
    "Case",
    "Cohesion",
    "Expected",
    "Frame",
    "MeshChoice",
    "MooneyRivlin",
    "Mortar",
    "Penalty",
    "Plates",
    "Pressure",
    "Refinement",
    "Sddp",
    "SingleStep",
    "Tissue",
    "Traction",
    "inspect",
    "read_case",
    "record",
    "resume",
    "simulate",
]

_FROM_RUN = {"inspect", "record", "resume", "simulate"}


def __getattr__(name: str) -> Any:
    # Loaded on first use: `import ngcell` and `ngcell --help` stay free of NGSolve's seconds.
    if name not in __all__:
        raise AttributeError(f"module 'ngcell' has no attribute {name!r}")
    return getattr(import_module("ngcell.run" if name in _FROM_RUN else "ngcell.scene"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
