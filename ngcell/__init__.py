"""Simulate tissues of hollow, hyperelastic cells that press, slide and part: the table of contents."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ngcell.contact.cohesion.exponential import Cohesion
    from ngcell.contact.methods.by_mortar import Mortar
    from ngcell.contact.methods.by_penalty import Penalty
    from ngcell.contact.methods.stages import ContactOptions
    from ngcell.geometry.tissues.honeycomb import Tissue
    from ngcell.geometry.tissues.polygons import PolygonTissue
    from ngcell.geometry.user_bodies.block import Block
    from ngcell.geometry.user_bodies.disc import Disc
    from ngcell.geometry.user_bodies.ring import Ring
    from ngcell.mechanics.laws.custom import CustomLaw
    from ngcell.mechanics.laws.fibres import ExponentialFibres, QuadraticFibres
    from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
    from ngcell.run import inspect, record, resume, simulate
    from ngcell.scene import (
        Body,
        BodyCase,
        BodyForce,
        BodyScene,
        BodySupport,
        Case,
        Expected,
        Frame,
        MeshChoice,
        Plates,
        Pressure,
        Refinement,
        Sddp,
        SingleStep,
        Traction,
        read_case,
        register,
    )

__version__ = "0.1.0"

__all__ = [
    "Block",
    "Body",
    "BodyCase",
    "BodyForce",
    "BodyScene",
    "BodySupport",
    "Case",
    "Cohesion",
    "ContactOptions",
    "CustomLaw",
    "Disc",
    "Expected",
    "ExponentialFibres",
    "Frame",
    "MeshChoice",
    "MooneyRivlin",
    "Mortar",
    "Penalty",
    "Plates",
    "PolygonTissue",
    "Pressure",
    "QuadraticFibres",
    "Refinement",
    "Ring",
    "Sddp",
    "SingleStep",
    "Tissue",
    "Traction",
    "inspect",
    "read_case",
    "record",
    "register",
    "resume",
    "simulate",
]

#: Where names come from that the scene does not offer.
_HOMES = {
    **dict.fromkeys(("inspect", "record", "resume", "simulate"), "ngcell.run"),
    "ContactOptions": "ngcell.contact.methods.stages",
    "CustomLaw": "ngcell.mechanics.laws.custom",
    "PolygonTissue": "ngcell.geometry.tissues.polygons",
}


def __getattr__(name: str) -> Any:
    # Loaded on first use: `import ngcell` and `ngcell --help` stay free of NGSolve's seconds.
    if name not in __all__:
        raise AttributeError(f"module 'ngcell' has no attribute {name!r}")
    return getattr(import_module(_HOMES.get(name, "ngcell.scene")), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
