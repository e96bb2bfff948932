"""Whether the parts of a case go together: each part says itself which others it refuses.

A part with a method ``check_scope(scene)`` is asked as soon as it has been read. ``scene`` holds the parts that were
read before it, by their keys in the case; those that were wrong are missing. It calls `refuse` for what cannot be.
"""

from __future__ import annotations

from typing import Any, NoReturn, TypeVar

from pydantic import ValidationInfo
from pydantic_core import PydanticCustomError

Part = TypeVar("Part")


def in_scope(part: Part, info: ValidationInfo) -> Part:
    """Return a part of a case after it has said that it goes with those read before it."""
    check = getattr(part, "check_scope", None)
    if check is not None:
        check(info.data)
    return part


def refuse(words: str, *place: str | int, **values: Any) -> NoReturn:
    """Refuse a part of a case.

    Parameters
    ----------
    words : str
        What is wrong and what is allowed; ``{name}`` stands for one of `values`.
    *place : str or int
        The key in the part that is to blame; by default the part itself.
    """
    raise PydanticCustomError("limit", words, {"place": place, **values})


def is_planar(scene: dict[str, Any]) -> bool:
    """Return whether a case has a tissue, and one without height."""
    return "tissue" in scene and getattr(scene["tissue"], "height", None) is None


def are_open_prisms(scene: dict[str, Any]) -> bool:
    """Return whether a case has a tissue of prisms whose lumens are open at their ends."""
    return "tissue" in scene and not is_planar(scene) and getattr(scene["tissue"], "end_wall", None) is None


def only_for_prisms(part: Any, scene: dict[str, Any], *names: str) -> None:
    """Refuse keys that only prisms have a use for, in a case of planar cells."""
    for name in names:
        if is_planar(scene) and getattr(part, name) is not None:
            refuse("is for prisms; allowed: only beside tissue.height", name)
