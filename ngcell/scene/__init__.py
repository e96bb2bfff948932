"""What is simulated: the case, its parts, and the reader of case files."""

from __future__ import annotations

from ngcell.scene.bodies import Body, BodyScene, BodySupport, Pressure, Traction
from ngcell.scene.case import Case
from ngcell.scene.catalogue import case_name, find_case, shipped_cases
from ngcell.scene.contact import Contact, Mortar, Penalty
from ngcell.scene.expected import Expected
from ngcell.scene.load import Frame, Load, Plates
from ngcell.scene.material import Material, MooneyRivlin
from ngcell.scene.mesh import MeshChoice
from ngcell.scene.reader import read_case, resolved_toml
from ngcell.scene.strategy import Sddp, SingleStep, Strategy
from ngcell.scene.tissue import Tissue
from ngcell.scene.vocabulary import schema

__all__ = [
    "Body",
    "BodyScene",
    "BodySupport",
    "Case",
    "Contact",
    "Expected",
    "Frame",
    "Load",
    "Material",
    "MeshChoice",
    "MooneyRivlin",
    "Mortar",
    "Penalty",
    "Plates",
    "Pressure",
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
