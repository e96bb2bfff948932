"""Dotted keys: ``tissue.wall`` as a path, and tables of tables as one table with dotted keys."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ngcell.scene.lines import KeyPath

#: Digits with which a part of a key is no number of an entry in a list.
_DIGITS = 10


def key_path(dotted: str) -> KeyPath | None:
    """Return the path that a dotted key means; None if it is none."""
    parts = [part.strip() for part in dotted.split(".")]
    if not all(parts):
        return None
    return tuple(int(part) if part.isdecimal() and len(part) < _DIGITS else part for part in parts)


def flattened(table: Any) -> Any:
    """Return a table of tables as one with dotted keys; a table that names its kind is a value.

    TOML reads ``tissue.wall = 0.1`` as a table in a table.
    """
    return joined(table, lambda name, value: isinstance(value.get("kind"), str))


def joined(table: Any, is_value: Callable[[str, Mapping[str, Any]], bool], before: str = "") -> Any:
    """Return a table of tables as one with dotted keys, down to tables that are values; anything else as it is."""
    if not isinstance(table, Mapping):
        return table
    found: dict[str, Any] = {}
    for key, value in table.items():
        name = f"{before}{key}"
        inner = isinstance(value, Mapping) and value and not is_value(name, value)
        found.update(joined(value, is_value, f"{name}.") if inner else {name: value})
    return found
