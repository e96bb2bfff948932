"""A study: a case, what is set in it, and the axes along which it varies."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, Strict, ValidationInfo, field_validator

from ngcell.scene.choice import OneOf
from ngcell.scene.dotted import flattened, joined, key_path
from ngcell.scene.scope import refuse
from ngcell.scene.section import PositiveNumber, Section

Axis = Annotated[Any, OneOf("axis")]
_TRUNK = "key of the case, as in tissue.wall"


def named_axes(table: Any) -> Any:
    """Return axes by name, and a list as the grid that it stands for."""
    found = joined(table, _is_axis)
    if not isinstance(found, dict):
        return found
    return {
        name: {"kind": "grid", "values": list(value)} if isinstance(value, (list, tuple)) else value
        for name, value in found.items()
    }


def _is_axis(name: str, table: Mapping[str, Any]) -> bool:
    """Return whether a table is an axis, if only one that lacks its kind: no axis is a mere number or text. A list of
    kinds is an axis over the key `kind`."""
    kind = table.get("kind", ())
    inner = (Mapping, list, tuple, BaseModel)
    return isinstance(kind, str) or not all(isinstance(value, inner) for value in table.values())


def _check_tables(axes: Mapping[str, Any], owner: Mapping[str, str]) -> None:
    """Refuse an axis of tables, or of lists, that say what another axis, or `set`, says as well."""
    paths = {key: key_path(key) or () for key in owner}
    for name, axis in axes.items():
        for number, trunk in enumerate(axis.keys(name)):
            start = paths[trunk]
            inner = {key: path[len(start) :] for key, path in paths.items() if path[: len(start)] == start != path}
            points = [flattened(point[number]) for point in axis.points()] if inner else []
            for key, rest in inner.items():
                if any(not isinstance(table, Mapping) or _says(table, ".".join(map(str, rest))) for table in points):
                    said = {"key": key, "other": owner[key]}
                    refuse("{key} is in {other} as well; allowed: one of the two", name, **said)


def _says(table: Mapping[str, Any], key: str) -> bool:
    """Return whether a table with dotted keys says a key, or a part of it."""
    return any(each == key or each.startswith(f"{key}.") or key.startswith(f"{each}.") for each in table)


class Study(Section):
    """Runs of one case along axes: every combination of a point of each axis is a run.

    Parameters
    ----------
    case : str
        The case: a path, or the name of one that comes with ngcell. A path is relative to the study's file.
    title : str
        One line that says what is asked.
    set : table
        Values in place of the case's, by dotted key.
    axes : table
        By name: a list of values, or a kind of axis. The name of an axis over one key is the dotted key.
    outputs : list of str
        Columns of `history.csv` that the table has; by default all.
    minutes : float, optional
        Time on the clock after which a run ends, > 0; by default it takes as long as it needs.
    """

    case: Annotated[str, BeforeValidator(lambda case: str(case) if isinstance(case, Path) else case)]
    title: str = ""
    set: Annotated[dict[str, Any], BeforeValidator(flattened)] = {}
    axes: Annotated[dict[str, Axis], BeforeValidator(named_axes)]
    outputs: Annotated[tuple[str, ...], Strict(False)] = ()
    minutes: PositiveNumber | None = None

    @field_validator("set")
    @classmethod
    def _sets_keys(cls, values: dict[str, Any]) -> dict[str, Any]:
        for name in values:
            if key_path(name) is None:
                refuse("is no key; allowed: a dotted {what}", name, what=_TRUNK)
        return values

    @field_validator("axes")
    @classmethod
    def _each_key_once(cls, axes: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        if not axes:
            refuse("there is none; allowed: at least one, as in tissue.wall = [0.05, 0.1]")
        owner = dict.fromkeys(info.data.get("set", ()), "set")
        for name, axis in axes.items():
            for key in axis.keys(name):
                if key_path(key) is None:
                    refuse("{key} is no key; allowed: a dotted {what}", name, key=repr(key), what=_TRUNK)
                if (same := next((other for other in owner if key_path(other) == key_path(key)), None)) is not None:
                    said = {"key": key, "other": owner[same]}
                    refuse("{key} is in {other} already; allowed: one axis a key, or set", name, **said)
                owner[key] = name
        _check_tables(axes, owner)
        return axes

    @property
    def keys(self) -> tuple[str, ...]:
        """Dotted keys that vary, in the order of the axes."""
        return tuple(key for name, axis in self.axes.items() for key in axis.keys(name))
