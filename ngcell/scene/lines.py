"""Where in the text of a TOML file a key stands; the standard parser does not say."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from sys import float_info
from typing import Any

#: The keys, and numbers in lists, that lead to an entry of a case.
KeyPath = tuple[str | int, ...]

_NAME = r"""(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')"""
_DOTTED = rf"{_NAME}(?:\s*\.\s*{_NAME})*"
_HEADER = re.compile(rf"\s*(\[\[?)\s*({_DOTTED})\s*\]")
_ENTRY = re.compile(rf"\s*({_DOTTED})\s*=")
#: What a line may hold outside of texts of several lines, and how these end.
_TOKEN = re.compile(r'''"""|\'\'\'|"(?:\\.|[^"\\])*"|'[^']*'|#''')
_END = {'"""': re.compile(r'(?:[^\\]|\\.)*?"""'), "'''": re.compile(r".*?'''")}


def key_lines(text: str) -> dict[KeyPath, int]:
    """Return the line, counted from 1, of each table header and key of a valid or broken TOML text.

    Notes
    -----
    Keys inside inline tables are left out: they stand on the line of the key that holds them.
    """
    lines: dict[KeyPath, int] = {}
    entries: Counter[KeyPath] = Counter()
    table: KeyPath = ()
    quote = ""
    for number, line in enumerate(text.splitlines(), start=1):
        starts_inside, quote = bool(quote), _open_after(line, quote)
        if starts_inside:
            continue
        if header := _HEADER.match(line):
            table = _in_last_entries(_split(header[2]), entries)
            if header[1] == "[[":
                lines.setdefault(table, number)
                entries[table] += 1
                table = (*table, entries[table] - 1)
            lines.setdefault(table, number)
        elif entry := _ENTRY.match(line):
            lines.setdefault((*table, *_split(entry[1])), number)
    return lines


@dataclass(frozen=True)
class Place:
    """Where a key stands.

    Attributes
    ----------
    file : str
        The file, as messages name it.
    line : int
        Its line, counted from 1.
    generation : int
        How many files extend this one on the way from the case that is read.
    """

    file: str
    line: int
    generation: int = 0

    @property
    def order(self) -> tuple[int, int]:
        """What places are sorted by: the case that is read comes first."""
        return self.generation, self.line


def place_of(path: KeyPath, places: dict[KeyPath, Place]) -> Place | None:
    """Return where a key stands, else the nearest table that holds it, else None."""
    return next((places[path[:n]] for n in range(len(path), 0, -1) if path[:n] in places), None)


def endless_numbers(table: Any, at: KeyPath = ()) -> list[KeyPath]:
    """Return the places of whole numbers in a table that are too large for a floating point number."""
    if isinstance(table, (dict, list)):
        inner = table.items() if isinstance(table, dict) else enumerate(table)
        return [place for key, value in inner for place in endless_numbers(value, (*at, key))]
    return [at] if isinstance(table, int) and abs(table) > float_info.max else []


def _open_after(line: str, quote: str) -> str:
    """Return the quotes of the text that goes on behind a line, from those of the one that it begins in; empty outside.
    """
    at = 0
    while True:
        if quote:
            end = _END[quote].match(line, at)
            if end is None:
                return quote
            at, quote = end.end(), ""
        token = _TOKEN.search(line, at)
        if token is None or token[0] == "#":
            return ""
        at, quote = token.end(), token[0] if token[0] in _END else ""


def _split(dotted: str) -> KeyPath:
    return tuple(name.strip("\"'") for name in re.findall(_NAME, dotted))


def _in_last_entries(path: KeyPath, entries: Counter[KeyPath]) -> KeyPath:
    """Return the path of a table whose header leads through lists of tables: it belongs to their last entries."""
    *holders, last = path
    found: KeyPath = ()
    for part in holders:
        found = (*found, part)
        if entries[found]:
            found = (*found, entries[found] - 1)
    return (*found, last)
