"""Cases that extend others: ``extends = "shear-empty"`` takes over what another case says, and the file itself wins.

Tables merge key by key. A table of another `kind` takes the place of the inherited one. In lists of tables
that each have a `name`, or a `boundary`, of their own, those of the same merge and others are added; any other list
takes the place of the inherited one. Expected numbers are never inherited: they belong to one scene. An inherited title
and an inherited source tell which file has changed the scene. Paths of files are relative to the case file that names
them.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ngcell.errors import CaseError
from ngcell.scene.catalogue import case_in, shipped_cases
from ngcell.scene.lines import KeyPath, Place, endless_numbers, key_lines
from ngcell.scene.registry import default_kind

_POSITION = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")


@dataclass(frozen=True)
class CaseTable:
    """What a case says, and where.

    Attributes
    ----------
    table : dict
        What the file and those that it extends say together, without the key `extends`.
    places : dict of key path to Place
        File and line of each key.
    """

    table: dict[str, Any]
    places: dict[KeyPath, Place]


def read_table(file: Path, shown: str | None = None, heirs: tuple[Path, ...] = ()) -> CaseTable:
    """Return what a case file says together with the cases that it extends.

    Parameters
    ----------
    file : Path
        The file.
    shown : str, optional
        How messages name it.
    heirs : tuple of Path
        The files that led here.

    Raises
    ------
    CaseError
        A file cannot be read or is no TOML, or there is no case to extend.
    """
    shown = shown or str(file)
    table, text = read_toml(file, shown)
    table = _located(table, file.parent)
    places = {path: Place(shown, line, len(heirs)) for path, line in key_lines(text).items()}
    if "extends" not in table:
        return CaseTable(table, places)
    written = next((place for path, place in places.items() if path[0] == "extends"), None)
    where, name = shown if written is None else f"{shown}:{written.line}", table.pop("extends")
    places = {path: place for path, place in places.items() if path[0] != "extends"}
    parent = _parent(name, file, where)
    if parent.resolve() in {heir.resolve() for heir in (file, *heirs)}:
        raise CaseError(
            f'{where}: extends = "{name}" leads back to {parent}; allowed: a case that does not extend this one'
        )
    inherited = read_table(parent, None, (*heirs, file))
    inherited.table.pop("expected", None)
    if inherited.table.get("title") and "title" not in table:
        inherited.table["title"] = f"{inherited.table['title']}, changed by {file.name}"
    if inherited.table.get("source") and "source" not in table:
        inherited.table["source"] = f"Changed by {file.name}; of {name}: {inherited.table['source']}"
    return _extended(inherited, CaseTable(table, places))


def read_toml(file: Path, shown: str) -> tuple[dict[str, Any], str]:
    """Return the table of a TOML file and its text; messages name it as `shown`.

    Raises
    ------
    CaseError
        It cannot be read or is no TOML.
    """
    text = _text(file)
    return _parsed(text, shown), text


def _parent(name: object, file: Path, where: str) -> Path:
    """Return the file that a case extends."""
    shipped = shipped_cases()
    if isinstance(name, str):
        found = case_in(file.parent / name) or shipped.get(name)
        if found is not None:
            return found
    near = get_close_matches(str(name), shipped, n=1)
    hint = f"; did you mean {near[0]}?" if near else ""
    allowed = f"the path of a case file from this one, or one of {', '.join(shipped)}"
    raise CaseError(f"{where}: extends = {name!r}: no such case{hint}; allowed: {allowed}")


def _extended(inherited: CaseTable, own: CaseTable) -> CaseTable:
    replaced: set[KeyPath] = set()
    table = _merged(inherited.table, own.table, (), replaced)
    kept = {
        path: place
        for path, place in inherited.places.items()
        if path[0] != "expected" and not any(path[: len(gone)] == gone for gone in replaced)
    }
    renumbered = {_renumbered(path, own.table, table): place for path, place in own.places.items()}
    # Headers of tables that both have stand where they are inherited from unless the file repeats them.
    return CaseTable(table, {**kept, **renumbered})


def _merged(inherited: Any, own: Any, at: KeyPath, replaced: set[KeyPath]) -> Any:
    """Return an entry of both; paths at which the file's own takes the other's place are added to `replaced`."""
    if isinstance(inherited, dict) and isinstance(own, dict) and _same_kind(inherited, own, at):
        both = {key: _merged(inherited[key], own[key], (*at, key), replaced) for key in own.keys() & inherited.keys()}
        return {**inherited, **own, **both}
    if _are_named(inherited) and _are_named(own):
        merged = list(inherited)
        for entry in own:
            number = _number(merged, _label(entry))
            if number == len(merged):
                merged.append(entry)
            else:
                merged[number] = _merged(merged[number], entry, (*at, number), replaced)
        return merged
    replaced.add(at)
    return own


def _same_kind(inherited: dict[str, Any], own: dict[str, Any], at: KeyPath) -> bool:
    default = default_kind(str(at[-1])) if at else None
    return "kind" not in own or own["kind"] == inherited.get("kind", default or own["kind"])


def _are_named(value: Any) -> bool:
    """Return whether a value is a list of tables, each with a label that no other one has."""
    labels = [_label(entry) for entry in value] if isinstance(value, list) else []
    return bool(labels) and None not in labels and all(labels.count(label) == 1 for label in labels)


def _label(entry: Any) -> object:
    """Return what tells a table in a list from the others, None if nothing does."""
    return entry.get("name", entry.get("boundary")) if isinstance(entry, dict) else None


def _number(entries: list[dict[str, Any]], label: object) -> int:
    """Return the number of the entry of that label, that of the next one if there is none."""
    return next((number for number, entry in enumerate(entries) if _label(entry) == label), len(entries))


def _renumbered(path: KeyPath, own: Any, merged: Any) -> KeyPath:
    """Return the path in the merged table of a key of the file's own."""
    found: KeyPath = ()
    for part in path:
        if isinstance(part, int) and _are_named(own) and _are_named(merged):
            number = _number(merged, _label(own[part]))
            own, merged = own[part], merged[number]
            found = (*found, number)
            continue
        own, merged = _entry(own, part), _entry(merged, part)
        found = (*found, part)
    return found


def _entry(node: Any, part: str | int) -> Any:
    if isinstance(node, dict):
        return node.get(str(part))
    return node[part] if isinstance(node, list) and isinstance(part, int) and part < len(node) else None


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8-sig")
    except OSError as error:
        reason = error.strerror or error
        raise CaseError(f"{file}: cannot be read ({reason}); allowed: a readable TOML file") from error
    except UnicodeDecodeError as error:
        raise CaseError(f"{file}: byte {error.start} is not UTF-8; allowed: a TOML file in UTF-8") from error


def _located(table: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the table of a case in this folder with absolute paths of the files that it names."""
    tissue = table.get("tissue")
    if not isinstance(tissue, dict) or not isinstance(tissue.get("file"), str) or not tissue["file"]:
        return table
    return {**table, "tissue": {**tissue, "file": str((folder / tissue["file"]).absolute())}}


def _parsed(text: str, shown: str) -> dict[str, Any]:
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        reason, position = str(error), _POSITION.search(str(error))
        line = position[1] if position and position[1] else len(text.splitlines())
        column = f", column {position[2]}" if position and position[2] else ""
        told = _POSITION.sub("", reason).splitlines()[0]
        said = text.splitlines()[int(line) - 1].strip() if text.strip() else ""
        raise CaseError(f"{shown}:{line}: not TOML{column}: {told}: {said}; allowed: key = value") from None
    except ValueError:
        raise CaseError(f"{shown}: a whole number has more digits than can be read; allowed: fewer") from None
    for place in endless_numbers(table):
        lines = key_lines(text)
        line = next((f":{lines[place[:end]]}" for end in range(len(place), 0, -1) if place[:end] in lines), "")
        key = ".".join(map(str, place))
        raise CaseError(f"{shown}{line}: {key} has more than 308 digits; allowed: fewer")
    return table
