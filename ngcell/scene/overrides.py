"""Values given beside a case file: `key=value` with dotted keys, as `--set` takes them, or those of a study."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ngcell.errors import CaseError
from ngcell.scene.dotted import key_path
from ngcell.scene.lines import KeyPath, endless_numbers

#: Keys that change nothing of what a title says.
_SAYS_NOTHING = {"title", "source", "expected", "accuracy", "estimate_error", "mesh"}
#: Longest value that a title tells.
_LONGEST = 30


@dataclass(frozen=True)
class Setting:
    """A value that takes the place of what a case file says.

    Attributes
    ----------
    path : tuple of str or int
        The key.
    value : object
        Its value, as TOML would give it.
    told : str
        How messages name it.
    place : str, optional
        File and line where it is said; by default it is an option of the command line.
    """

    path: KeyPath
    value: Any
    told: str
    place: str | None = None


def settings_of(overrides: Sequence[str]) -> tuple[Setting, ...]:
    """Return what overrides set.

    Parameters
    ----------
    overrides : sequence of str
        Each ``key=value``: a dotted key (``tissue.wall``, ``expected.0.value``) and a TOML value. What is
        no TOML value is taken as a bare string. Later ones win.

    Raises
    ------
    CaseError
        An override is not of that form.
    """
    return tuple(_parse(override) for override in overrides)


def with_settings(table: dict[str, Any], settings: Sequence[Setting]) -> dict[str, Any]:
    """Return the table of a case file, which is left unchanged, with values set.

    Raises
    ------
    CaseError
        A key leads through something that is not a table.
    """
    for setting in settings:
        table = _replaced(table, setting.path, setting)
    return table


def title_of_changed(table: Mapping[str, Any], settings: Sequence[Setting]) -> tuple[Setting, ...]:
    """Return the title of a case beside whose file values are set: the file's own, and what was set.

    Parameters
    ----------
    table : mapping of str to Any
        What the file says.
    settings : sequence of Setting
        What is set.

    Returns
    -------
    tuple of Setting
        The title; empty where the file has none, where it is set itself, or where nothing else is.
    """
    keys, title = {setting.path[0] for setting in settings}, table.get("title")
    last = {setting.path: setting for setting in settings}  # what is set twice counts once
    told = [_said(setting) for setting in last.values() if setting.path[0] not in _SAYS_NOTHING]
    if not told or "title" in keys or not isinstance(title, str) or not title:
        return ()
    return (Setting(("title",), f"{title} (with {', '.join(told)})", "title"),)


def _said(setting: Setting) -> str:
    key, value = ".".join(map(str, setting.path)), str(setting.value)
    return f"{key} = {value}" if len(value) <= _LONGEST else f"another {key}"


def _parse(override: str) -> Setting:
    key, equals, value = override.partition("=")
    path = key_path(key)
    if not equals or path is None:
        raise CaseError(f"--set {override}: allowed: key=value with a dotted key, as in tissue.wall=0.1")
    return Setting(path, _toml_value(value.strip()), f"--set {override}")


def _toml_value(text: str) -> Any:
    try:
        parsed = tomllib.loads(f"value = {text}")
    except ValueError:  # no TOML, or a number of thousands of digits
        return text
    return parsed["value"] if len(parsed) == 1 and not endless_numbers(parsed) else text


def _replaced(node: Any, path: KeyPath, setting: Setting) -> Any:
    """Return a copy of `node` in which the entry at `path` is the value of the setting."""
    if not path:
        return setting.value
    first, *rest = path
    if isinstance(node, list) and isinstance(first, int) and first < len(node):
        inner = _replaced(node[first], tuple(rest), setting)
        return [*node[:first], inner, *node[first + 1 :]]
    if not isinstance(node, dict):
        raise CaseError(f"{setting.told}: nothing to set {first} in; allowed: a key of a table")
    return {**node, first: _replaced(node.get(first, {}), tuple(rest), setting)}
