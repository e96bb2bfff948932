"""Scenes from Python as text: all of it that a case file could say, and, for the rest, what it is.

A shape cannot be written. Its size, place and names tell whether a scene is the one that a folder was made from, so
that a run can be resumed when the scene is handed over again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import tomli_w
from pydantic import BaseModel

from ngcell.scene.bodies import BodyScene

#: Digit to which the place of a shape is written, as a share of its size.
_DIGIT = 1e-6

#: The first line of what is written; what begins with it is no case file.
FROM_PYTHON = "# From Python: shapes, functions and objects of a script are told here, and cannot be read back.\n"


def written_bodies(scene: BodyScene) -> str:
    """Return a scene from Python as TOML that begins with `FROM_PYTHON`."""
    return FROM_PYTHON + tomli_w.dumps(_of_fields(scene))


def is_from_python(case_text: str) -> bool:
    """Return whether a text was made by `written_bodies`."""
    return case_text.startswith(FROM_PYTHON)


def _of_fields(owner: Any) -> dict[str, Any]:
    values = {entry.name: getattr(owner, entry.name) for entry in fields(owner)}
    return {name: _plain(value) for name, value in values.items() if value is not None}


def _plain(value: Any) -> Any:
    """Return what TOML can say of a value."""
    if isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json", exclude_none=True)
    if is_dataclass(value) and not isinstance(value, type):
        return _of_fields(value)
    if hasattr(value, "bounding_box"):
        return _shape(value)
    if isinstance(value, Mapping):
        return {str(name): _plain(entry) for name, entry in value.items() if entry is not None}
    return f"not written: {getattr(value, '__qualname__', None) or type(value).__qualname__}"


def _shape(shape: Any) -> dict[str, Any]:
    """Return what a shape of OpenCASCADE is like: area or volume, where it is, and the names of its boundaries."""
    low, high = (list(map(float, corner)) for corner in shape.bounding_box)
    # Meshing a shape changes the last digits of its box.
    digit = _DIGIT * max(abs(above - below) for below, above in zip(low, high, strict=True))
    sides = shape.faces if len(shape.solids) else shape.edges
    return {
        "not_written": type(shape).__qualname__,
        "measure": float(f"{float(shape.mass):.6g}"),
        "low": _rounded(low, digit),
        "high": _rounded(high, digit),
        "sides": [side.name or "" for side in sides],
    }


def _rounded(place: Sequence[float], digit: float) -> list[float]:
    """Return a place in whole multiples of a digit [length]; none is -0."""
    return [float(f"{digit * round(value / digit):.9g}") + 0.0 if digit else value for value in place]
