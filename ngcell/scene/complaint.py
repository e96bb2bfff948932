"""One line for each mistake in a case: file, line, key, value, what is allowed, and the key that was meant.

The validating library knows the place and the sort of a mistake; what would be allowed there is read off the
schema, so that no limit is written down twice.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from ngcell.scene.choice import KIND_MISSING, KIND_UNKNOWN
from ngcell.scene.lines import KeyPath, Place, place_of
from ngcell.scene.vocabulary import Node, allowed, keys, kinds, node_at

_LONGEST_VALUE = 60


@dataclass(frozen=True)
class Mistake:
    """One mistake: its sort, the key it is about and, for what the schema cannot say, its own words."""

    sort: str
    path: KeyPath
    words: str


@dataclass(frozen=True)
class CaseText:
    """What a case file, or a study, says and where.

    Parameters
    ----------
    name : str
        The file, as the user named it.
    table : dict
        What it says, overrides included.
    places : dict of key path to Place
        File and line of each key.
    overridden : dict of key path to str
        Keys that were set beside the file, and where.
    section : str, optional
        Name of the section that it is; by default that of a case.
    """

    name: str
    table: dict[str, Any]
    places: dict[KeyPath, Place]
    overridden: dict[KeyPath, str]
    section: str | None = None

    def node(self, path: KeyPath) -> Node:
        """Return the schema of the key at `path`."""
        return node_at(path, self.table, self.section)

    def order(self, mistake: Mistake) -> tuple[int, int]:
        """Return what mistakes are sorted by: the file and the line that each stands in."""
        place = place_of(mistake.path, self.places)
        return (0, 0) if place is None else place.order


def complaints(error: ValidationError, text: CaseText) -> list[str]:
    """Return a line for each mistake; misspelt keys first, for they cause others."""
    mistakes = [_mistake(detail, text.table) for detail in error.errors()]
    unknown = [mistake for mistake in mistakes if mistake.sort == "extra_forbidden"]
    explained = {_meant(mistake.path, text) for mistake in unknown}
    others = [
        mistake
        for mistake in mistakes
        if mistake not in unknown and (mistake.sort != "missing" or mistake.path not in explained)
    ]
    in_order = sorted(unknown, key=text.order) + sorted(others, key=text.order)
    lines = (f"{_where(mistake.path, text)}: {_what(mistake, text)}" for mistake in in_order)
    return list(dict.fromkeys(lines))


def _mistake(detail: ErrorDetails, table: dict[str, Any]) -> Mistake:
    sort, path = detail["type"], tuple(_file_path(detail, table))
    if _is_of_a_choice(detail, table):
        return Mistake("choice", path, "")
    if sort == "missing" and isinstance(path[-1], int):
        return Mistake("too_short", path[:-1], "")
    if sort in (KIND_MISSING, KIND_UNKNOWN):
        return Mistake("missing" if sort == KIND_MISSING else sort, (*path, "kind"), "")
    # A check across keys is reported for their table; its "place" is the key in it that is to blame.
    return Mistake(sort, (*path, *detail.get("ctx", {}).get("place", ())), detail["msg"])


def _file_path(detail: ErrorDetails, table: Any) -> Iterator[str | int]:
    """Yield the place of a mistake as the file spells it, without the kinds that the validator adds.

    Where a value may be of one sort or of another, the validator goes on with the name of the sort, once for each: the
    value itself is to blame.
    """
    if not detail["loc"]:
        return  # of the case as a whole
    *inner, last = detail["loc"]
    for part in inner:
        if isinstance(part, str) and not isinstance(table, dict):
            return
        if isinstance(part, str) and part not in table:
            continue
        yield part
        table = table[part]
    if detail["type"] == "missing" or _value_at((last,), table) is not None or isinstance(last, int):
        yield last


def _is_of_a_choice(detail: ErrorDetails, table: Any) -> bool:
    """Return whether a mistake is one of several, one for each sort that a value might be of."""
    for part in detail["loc"]:
        if isinstance(part, str) and not isinstance(table, dict):
            return True
        table = _value_at((part,), table) if not isinstance(table, dict) or part in table else table
    return False


def _where(path: KeyPath, text: CaseText) -> str:
    for key, where in reversed(text.overridden.items()):
        if path[: len(key)] == key:
            return where
    place = place_of(path, text.places)
    return text.name if place is None else f"{place.file}:{place.line}"


def _what(mistake: Mistake, text: CaseText) -> str:
    key, value = _dotted(mistake.path), _shown(_value_at(mistake.path, text.table))
    if mistake.sort == "missing":
        return f"{key} is missing; allowed: {_allowed(mistake.path, text)}"
    if mistake.sort == "extra_forbidden":
        known = ", ".join(keys(text.node(mistake.path[:-1])))
        return f"{key}{value} is unknown{_suggestion(mistake.path, text)}; allowed: {known}"
    if mistake.sort == "limit":
        return f"{key}{value}: {mistake.words}"
    suggestion = _suggestion(mistake.path, text) if mistake.sort == KIND_UNKNOWN else ""
    return f"{key}{value} is not possible{suggestion}; allowed: {_allowed(mistake.path, text)}"


def _allowed(path: KeyPath, text: CaseText) -> str:
    holder = text.node(path[:-1])
    if path[-1] == "kind" and kinds(holder):
        names = [f'"{kind}"' for kind in kinds(holder)]
        return ("one of " if len(names) > 1 else "") + ", ".join(names)
    node = text.node(path)
    known = keys(node) or (["kind"] if kinds(node) else [])
    return f"a table [{_dotted(path)}] with {', '.join(known)}" if known else allowed(node)


def _suggestion(path: KeyPath, text: CaseText) -> str:
    holder = text.node(path[:-1])
    if path[-1] == "kind":
        near = get_close_matches(str(_value_at(path, text.table)), kinds(holder), n=1)
    else:
        near = [str(_meant(path, text)[-1])] if _meant(path, text) else []
    return f"; did you mean {near[0]}?" if near else ""


def _meant(path: KeyPath, text: CaseText) -> KeyPath:
    """Return the path of the known key nearest to an unknown one, empty if none is near."""
    near = get_close_matches(str(path[-1]), keys(text.node(path[:-1])), n=1)
    return (*path[:-1], near[0]) if near else ()


def _dotted(path: KeyPath) -> str:
    first, *rest = path
    return str(first) + "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in rest)


def _value_at(path: KeyPath, table: Any) -> Any:
    for part in path:
        present = part in table if isinstance(table, dict) else isinstance(part, int) and part < len(table)
        if not present:
            return None
        table = table[part]
    return table


def _shown(value: Any) -> str:
    """Return `` = value`` on one line and cut to length, nothing for a table."""
    if value is None or isinstance(value, dict):
        return ""
    shown = json.dumps(value, default=str, ensure_ascii=False)
    return f" = {shown if len(shown) <= _LONGEST_VALUE else shown[:_LONGEST_VALUE] + '...'}"
