"""What is simulated: the case, its parts, and the reader of case files."""

from __future__ import annotations

from ngcell.scene.bodies import Body, BodyForce, BodyScene, BodySupport, Pressure, Traction
from ngcell.scene.case import Case
from ngcell.scene.case_of_bodies import BodyCase
from ngcell.scene.catalogue import case_name, find_case, shipped_cases
from ngcell.scene.cohesion import Cohesion
from ngcell.scene.contact import Contact, Mortar, Penalty
from ngcell.scene.drawn import Block, Disc, Ring, UserBody
from ngcell.scene.expected import BodyExpected, Expected
from ngcell.scene.kinds import AnyCase
from ngcell.scene.load import Ends, Frame, Load, Plates
from ngcell.scene.lumen import CellPressure, Fluid, Inclusion
from ngcell.scene.material import ExponentialFibres, Material, MooneyRivlin, QuadraticFibres
from ngcell.scene.mesh import BodyMeshChoice, MeshChoice, Refinement
from ngcell.scene.reader import read_case, resolved_toml
from ngcell.scene.strategy import Sddp, SingleStep, Strategy
from ngcell.scene.tissue import Tissue
from ngcell.scene.vocabulary import schema

__all__ = [
    "AnyCase",
    "Block",
    "Body",
    "BodyCase",
    "BodyExpected",
    "BodyMeshChoice",
    "BodyForce",
    "BodyScene",
    "BodySupport",
    "Case",
    "CellPressure",
    "Cohesion",
    "Contact",
    "Disc",
    "UserBody",
    "Ends",
    "Expected",
    "ExponentialFibres",
    "Fluid",
    "Frame",
    "Inclusion",
    "Load",
    "Material",
    "MeshChoice",
    "MooneyRivlin",
    "Mortar",
    "Penalty",
    "Plates",
    "Pressure",
    "QuadraticFibres",
    "Refinement",
    "Ring",
    "Sddp",
    "SingleStep",
    "Strategy",
    "Tissue",
    "Traction",
    "case_name",
    "find_case",
    "read_case",
    "resolved_toml",
    "schema",
    "shipped_cases",
]
