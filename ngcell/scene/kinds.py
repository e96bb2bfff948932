"""The two kinds of case: a tissue, and user-defined bodies."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Any

from ngcell.errors import CaseError
from ngcell.scene.bodies import BodyScene
from ngcell.scene.case import Case
from ngcell.scene.case_of_bodies import BodyCase

AnyCase = Case | BodyCase


def kind_of_case(table: Any) -> type[Case] | type[BodyCase]:
    """Return which kind of case a table means to be: one of bodies if it names any, even with a slip of the pen."""
    keys = list(map(str, table)) if isinstance(table, dict) else []
    of_bodies = BodyCase.model_fields.keys() - Case.model_fields.keys()
    misspelt = any(get_close_matches(key, ["bodies"]) for key in keys)
    return BodyCase if "bodies" in keys or ("tissue" not in keys and (misspelt or of_bodies & set(keys))) else Case


def check_is_scene(scene: object) -> None:
    """Raise `CaseError` if something is no scene, as the name of a file."""
    if not isinstance(scene, Case | BodyCase | BodyScene):
        known = "allowed: a Case, BodyCase or BodyScene; `ngcell.read_case` reads files and shipped cases"
        raise CaseError(f"{scene!r} is no scene; {known}")
