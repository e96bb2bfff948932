"""Study files in: TOML text to a checked study, and where each of its keys stands."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ngcell.errors import CaseError
from ngcell.scene.catalogue import case_in, find_study
from ngcell.scene.complaint import CaseText, complaints
from ngcell.scene.dotted import flattened, joined, key_path
from ngcell.scene.inheritance import read_toml
from ngcell.scene.lines import KeyPath, Place, key_lines, place_of
from ngcell.scene.overrides import Setting
from ngcell.scene.section import validated
from ngcell.scene.study import Study, named_axes

_TISSUE, _FILE = "tissue", "file"


@dataclass(frozen=True)
class WrittenStudy:
    """A study, and where it says what.

    Attributes
    ----------
    study : Study
        What is asked.
    name : str
        How messages name it: its file.
    places : dict of key path to Place
        File and line of each key; empty for a study from Python.
    """

    study: Study
    name: str = "study"
    places: dict[KeyPath, Place] = field(default_factory=dict)

    def where(self, *path: str) -> str:
        """Return file and line of a key, else the name of the study."""
        place = place_of(path, self.places)
        return self.name if place is None else f"{place.file}:{place.line}"

    def setting(self, key: str, value: Any, *path: str) -> Setting:
        """Return what sets a dotted key of the case, as said at `path`."""
        parts, where = key_path(key), self.where(*path)
        assert parts is not None
        return Setting(parts, value, f"{where}: {key}", where)

    @property
    def fixed(self) -> tuple[Setting, ...]:
        """What is set in every case."""
        return tuple(self.setting(key, value, "set", key) for key, value in self.study.set.items())


def read_study(path: Path | str) -> WrittenStudy:
    """Read and check a study file.

    Raises
    ------
    CaseError
        The file cannot be read or is no study; one line for each mistake.
    """
    file = find_study(path)
    shown = str(file)
    try:
        table, text = read_toml(file, shown)
        places = {path: Place(shown, line) for path, line in key_lines(text).items()}
        places |= {(path[0], ".".join(map(str, path[1:]))): place for path, place in places.items() if len(path) > 1}
        if "set" in table:
            table["set"] = _as_set(table["set"], places)
        table = _located(table, file.parent)
        return WrittenStudy(validated(Study, table), shown, places)
    except RecursionError:
        raise CaseError(f"{shown}: tables or lists are nested too deep; allowed: the keys of a study") from None
    except ValidationError as error:
        raise CaseError("\n".join(complaints(error, CaseText(shown, table, places, {}, Study.__name__)))) from None


def _as_set(fixed: Any, places: Container[KeyPath]) -> Any:
    """Return what is set by the keys that the file spells out: ``tissue.kind = "voronoi"`` sets one key, where
    ``tissue = { kind = "voronoi" }`` sets the whole table."""
    return joined(fixed, lambda name, table: not any(("set", f"{name}.{key}") in places for key in table))


def _located(table: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return what a study in this folder says, with dotted keys and with paths from anywhere."""
    read: dict[str, Callable[[Any], Any]] = {"set": flattened, "axes": named_axes}
    found = {name: read[name](value) if name in read else value for name, value in table.items()}
    if isinstance(table.get("case"), str) and (file := case_in(folder / table["case"])) is not None:
        found["case"] = str(file)
    fixed, axes = found.get("set"), found.get("axes")
    if isinstance(fixed, dict):
        found["set"] = {key: _beside(folder, key, value) for key, value in fixed.items()}
    for name, axis in axes.items() if isinstance(axes, dict) else ():
        values = axis.get("values") if isinstance(axis, dict) else None
        if isinstance(values, list):
            axis["values"] = [_beside(folder, name, each) for each in values]
        elif isinstance(values, dict):  # lists that are taken together
            lists = flattened(values)
            axis["values"] = {key: [_beside(folder, key, each) for each in many] if isinstance(many, list) else many
                              for key, many in lists.items()}  # fmt: skip
    return found


def _beside(folder: Path, key: str, value: Any) -> Any:
    """Return the value of a dotted key, with the path of a file from anywhere, where it is one or a table that has one.
    """
    if key == f"{_TISSUE}.{_FILE}" and isinstance(value, str):
        return str((folder / value).absolute())
    if key == _TISSUE and isinstance(value, dict) and _FILE in value:
        return {**value, _FILE: _beside(folder, f"{_TISSUE}.{_FILE}", value[_FILE])}
    return value
