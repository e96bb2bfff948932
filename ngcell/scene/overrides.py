"""Values given beside a case file: `key=value` with dotted keys, as `--set` takes them."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import Any

from ngcell.errors import CaseError
from ngcell.scene.lines import KeyPath


def apply_overrides(table: dict[str, Any], overrides: Sequence[str]) -> tuple[dict[str, Any], list[KeyPath]]:
    """Return the table of a case file with overrides set, and the keys they set.

    Parameters
    ----------
    table : dict
        What the case file says; left unchanged.
    overrides : sequence of str
        Each ``key=value``: a dotted key (``tissue.wall``, ``expected.0.value``) and a TOML value. What is
        no TOML value is taken as a bare string. Later ones win.

    Raises
    ------
    CaseError
        An override is not of that form, or its key leads through something that is not a table.
    """
    for override in overrides:
        path, value = _parse(override)
        table = _replaced(table, path, value, override)
    return table, override_paths(overrides)


def override_paths(overrides: Sequence[str]) -> list[KeyPath]:
    """Return the keys that overrides set.

    Raises
    ------
    CaseError
        An override is not of the form ``key=value``.
    """
    return [_parse(override)[0] for override in overrides]


def _parse(override: str) -> tuple[KeyPath, Any]:
    key, equals, value = override.partition("=")
    parts = [part.strip() for part in key.split(".")]
    if not equals or not all(parts):
        raise CaseError(f"--set {override}: allowed: key=value with a dotted key, as in tissue.wall=0.1")
    return tuple(int(part) if part.isdecimal() else part for part in parts), _toml_value(value.strip())


def _toml_value(text: str) -> Any:
    try:
        parsed = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    return parsed["value"] if len(parsed) == 1 else text


def _replaced(node: Any, path: KeyPath, value: Any, override: str) -> Any:
    """Return a copy of `node` in which the entry at `path` is `value`."""
    if not path:
        return value
    first, *rest = path
    if isinstance(node, list) and isinstance(first, int) and first < len(node):
        inner = _replaced(node[first], tuple(rest), value, override)
        return [*node[:first], inner, *node[first + 1 :]]
    if not isinstance(node, dict):
        raise CaseError(f"--set {override}: nothing to set {first} in; allowed: a key of a table")
    return {**node, first: _replaced(node.get(first, {}), tuple(rest), value, override)}
