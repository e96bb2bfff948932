"""What is simulated: the skeleton of a case, the registry of kinds, and the reader of case files.

Kinds live in the rooms that realise them. Those of the package are offered here, too, by the names of their classes,
and loaded when they are asked for: ``from ngcell.scene import MooneyRivlin``.
"""

from __future__ import annotations

from typing import Any

from ngcell.scene.bodies import Body, BodyScene, BodySupport
from ngcell.scene.case import Case, Load
from ngcell.scene.case_of_bodies import BodyCase
from ngcell.scene.catalogue import case_name, find_case, shipped_cases
from ngcell.scene.expected import BodyExpected, Expected
from ngcell.scene.kinds import AnyCase
from ngcell.scene.members import MemberChoice, check_has_members, geometry_share, member_of
from ngcell.scene.mesh import BodyMeshChoice, MeshChoice, Refinement
from ngcell.scene.reader import case_title, read_case, resolved_toml
from ngcell.scene.registry import register, section_named, section_names
from ngcell.scene.vocabulary import schema

__all__ = [
    "AnyCase",
    "Body",
    "BodyCase",
    "BodyExpected",
    "BodyMeshChoice",
    "BodyScene",
    "BodySupport",
    "Case",
    "Expected",
    "Load",
    "MemberChoice",
    "MeshChoice",
    "Refinement",
    "case_name",
    "case_title",
    "check_has_members",
    "find_case",
    "geometry_share",
    "member_of",
    "read_case",
    "register",
    "resolved_toml",
    "schema",
    "shipped_cases",
]


def __getattr__(name: str) -> Any:
    section = section_named(name)
    if section is None:
        raise AttributeError(f"module 'ngcell.scene' has no attribute {name!r}")
    return section


def __dir__() -> list[str]:
    return sorted({*globals(), *section_names()})
