"""Simulate tissues of hollow, hyperelastic cells that press, slide and part: the table of contents."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ngcell.build.options import Options
    from ngcell.build.reported import Step
    from ngcell.contact.cohesion.exponential import Cohesion
    from ngcell.contact.methods.by_mortar import Mortar
    from ngcell.contact.methods.by_ngsolve import NgsolveContact
    from ngcell.contact.methods.by_penalty import Penalty
    from ngcell.contact.methods.normal_law import NormalLaw
    from ngcell.ensemble import members
    from ngcell.errors import CaseError, DependencyError, GeometryError, NgcellError, NotConverged, OutputError
    from ngcell.geometry.tissues.brick import Brick
    from ngcell.geometry.tissues.honeycomb import Tissue
    from ngcell.geometry.tissues.label_image import LabelImage
    from ngcell.geometry.tissues.perturbed import Perturbed
    from ngcell.geometry.tissues.polygon_file import Polygons
    from ngcell.geometry.tissues.polygons import PolygonTissue
    from ngcell.geometry.tissues.voronoi import Voronoi
    from ngcell.geometry.user_bodies.block import Block
    from ngcell.geometry.user_bodies.disc import Disc
    from ngcell.geometry.user_bodies.ring import Ring
    from ngcell.mechanics.applied.body_force import BodyForce
    from ngcell.mechanics.applied.boundary_pressure import Pressure
    from ngcell.mechanics.applied.traction import Traction
    from ngcell.mechanics.laws.custom import CustomLaw
    from ngcell.mechanics.laws.fibres import ExponentialFibres, QuadraticFibres
    from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
    from ngcell.mechanics.loading.ends import Ends
    from ngcell.mechanics.loading.frame import Frame
    from ngcell.mechanics.loading.indenter import Indenter
    from ngcell.mechanics.loading.plates import Plates
    from ngcell.mechanics.lumens.fluid import Fluid
    from ngcell.mechanics.lumens.inclusion import Inclusion
    from ngcell.mechanics.lumens.pressure import CellPressure
    from ngcell.mechanics.supports import PrescribedMotion, Support
    from ngcell.mechanics.symbolic import OwnEnergy
    from ngcell.mechanics.term import Term
    from ngcell.recording import Recording
    from ngcell.results.observables.rotation import Rotation
    from ngcell.results.observables.self_contact_force import SelfContactForce
    from ngcell.results.quantities import View
    from ngcell.run import inspect, record, resume, simulate
    from ngcell.scene import (
        Body,
        BodyCase,
        BodyExpected,
        BodyMeshChoice,
        BodyScene,
        BodySupport,
        Case,
        Expected,
        MeshChoice,
        Refinement,
        read_case,
        register,
    )
    from ngcell.scene.study import Study
    from ngcell.solve.options import SolverOptions
    from ngcell.solve.strategies.load_stepping import LoadStepping
    from ngcell.solve.strategies.sddp import Sddp
    from ngcell.solve.strategies.single_step import SingleStep
    from ngcell.sweeps.arrays import table_to_xarray
    from ngcell.sweeps.sweep import read_sweep, sweep

__version__ = "0.2.0"

#: Where each name is; all are loaded on first use, so that `import ngcell` and `ngcell --help` stay free of NGSolve's
#: seconds.
_PLACES = {
    "ngcell.build.observation": ("Step",),
    "ngcell.build.options": ("Options",),
    "ngcell.contact.cohesion.exponential": ("Cohesion",),
    "ngcell.contact.methods.by_mortar": ("Mortar",),
    "ngcell.contact.methods.by_ngsolve": ("NgsolveContact",),
    "ngcell.contact.methods.by_penalty": ("Penalty",),
    "ngcell.contact.methods.normal_law": ("NormalLaw",),
    "ngcell.ensemble": ("members",),
    "ngcell.errors": (
        "CaseError", "DependencyError", "GeometryError", "NgcellError", "NotConverged", "OutputError",
    ),
    "ngcell.geometry.tissues.brick": ("Brick",),
    "ngcell.geometry.tissues.honeycomb": ("Tissue",),
    "ngcell.geometry.tissues.label_image": ("LabelImage",),
    "ngcell.geometry.tissues.perturbed": ("Perturbed",),
    "ngcell.geometry.tissues.polygon_file": ("Polygons",),
    "ngcell.geometry.tissues.polygons": ("PolygonTissue",),
    "ngcell.geometry.tissues.voronoi": ("Voronoi",),
    "ngcell.geometry.user_bodies.block": ("Block",),
    "ngcell.geometry.user_bodies.disc": ("Disc",),
    "ngcell.geometry.user_bodies.ring": ("Ring",),
    "ngcell.mechanics.applied.body_force": ("BodyForce",),
    "ngcell.mechanics.applied.boundary_pressure": ("Pressure",),
    "ngcell.mechanics.applied.traction": ("Traction",),
    "ngcell.mechanics.laws.custom": ("CustomLaw",),
    "ngcell.mechanics.laws.fibres": ("ExponentialFibres", "QuadraticFibres"),
    "ngcell.mechanics.laws.mooney_rivlin": ("MooneyRivlin",),
    "ngcell.mechanics.loading.ends": ("Ends",),
    "ngcell.mechanics.loading.frame": ("Frame",),
    "ngcell.mechanics.loading.indenter": ("Indenter",),
    "ngcell.mechanics.loading.plates": ("Plates",),
    "ngcell.mechanics.lumens.fluid": ("Fluid",),
    "ngcell.mechanics.lumens.inclusion": ("Inclusion",),
    "ngcell.mechanics.lumens.pressure": ("CellPressure",),
    "ngcell.mechanics.supports": ("PrescribedMotion", "Support"),
    "ngcell.mechanics.symbolic": ("OwnEnergy",),
    "ngcell.mechanics.term": ("Term",),
    "ngcell.recording": ("Recording",),
    "ngcell.results.observables.rotation": ("Rotation",),
    "ngcell.results.observables.self_contact_force": ("SelfContactForce",),
    "ngcell.results.quantities": ("View",),
    "ngcell.run": ("inspect", "record", "resume", "simulate"),
    "ngcell.scene": (
        "Body", "BodyCase", "BodyExpected", "BodyMeshChoice", "BodyScene", "BodySupport", "Case", "Expected",
        "MeshChoice", "Refinement", "read_case", "register",
    ),
    "ngcell.scene.study": ("Study",),
    "ngcell.solve.options": ("SolverOptions",),
    "ngcell.solve.strategies.load_stepping": ("LoadStepping",),
    "ngcell.solve.strategies.sddp": ("Sddp",),
    "ngcell.solve.strategies.single_step": ("SingleStep",),
    "ngcell.sweeps.arrays": ("table_to_xarray",),
    "ngcell.sweeps.sweep": ("read_sweep", "sweep"),
}  # fmt: skip
_PLACE_OF = {name: place for place, names in _PLACES.items() for name in names}

__all__ = [
    "Block",
    "Body",
    "BodyCase",
    "BodyExpected",
    "BodyForce",
    "BodyMeshChoice",
    "BodyScene",
    "BodySupport",
    "Brick",
    "Case",
    "CaseError",
    "CellPressure",
    "Cohesion",
    "CustomLaw",
    "DependencyError",
    "Disc",
    "Ends",
    "Expected",
    "ExponentialFibres",
    "Fluid",
    "Frame",
    "GeometryError",
    "Inclusion",
    "Indenter",
    "LabelImage",
    "LoadStepping",
    "MeshChoice",
    "MooneyRivlin",
    "Mortar",
    "NgcellError",
    "NgsolveContact",
    "NormalLaw",
    "NotConverged",
    "Options",
    "OutputError",
    "OwnEnergy",
    "Penalty",
    "Perturbed",
    "Plates",
    "PolygonTissue",
    "Polygons",
    "PrescribedMotion",
    "Pressure",
    "QuadraticFibres",
    "Recording",
    "Refinement",
    "Ring",
    "Rotation",
    "Sddp",
    "SelfContactForce",
    "SingleStep",
    "SolverOptions",
    "Step",
    "Study",
    "Support",
    "Term",
    "Tissue",
    "Traction",
    "View",
    "Voronoi",
    "inspect",
    "members",
    "read_case",
    "read_sweep",
    "record",
    "register",
    "resume",
    "simulate",
    "sweep",
    "table_to_xarray",
]


def __getattr__(name: str) -> Any:
    if name not in _PLACE_OF:
        raise AttributeError(f"module 'ngcell' has no attribute {name!r}")
    return getattr(import_module(_PLACE_OF[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
