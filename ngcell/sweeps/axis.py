"""What an axis of a study offers."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

#: Values of the keys of an axis at one of its points.
Point = tuple[Any, ...]


@runtime_checkable
class Axis(Protocol):
    """Points along which keys of a case vary."""

    def keys(self, name: str) -> tuple[str, ...]:
        """Return the dotted keys that vary along the axis of this name."""

    def points(self) -> tuple[Point, ...]:
        """Return its points, each with a value for each key; at least one."""
