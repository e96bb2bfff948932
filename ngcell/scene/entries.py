"""Checks of what a script hands over for bodies: names, numbers and vectors of the right dimension."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from sys import float_info
from types import UnionType
from typing import Any, get_args

from ngcell.errors import CaseError

#: Names become parts of region names, where other signs would have a meaning of their own.
PLAIN_NAME = re.compile(r"[A-Za-z0-9_-]+")

#: What bodies of a dimension are, in words.
_BODIES = {2: "faces in the plane", 3: "solids"}

NUMBERS = "two finite numbers, or three for solids"


def check_unique_names(names: Iterable[str]) -> None:
    """Raise CaseError if a body's name occurs twice."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise CaseError(f"body name {twice[0]!r} is used twice; allowed: a name of its own for each body")


def check_name(name: object, place: str) -> None:
    """Raise CaseError if a name has characters that would mean something in the names of regions."""
    if not isinstance(name, str) or not PLAIN_NAME.fullmatch(name):
        raise CaseError(f"{place} is {name!r}; allowed: letters, digits, _ and -, at least one of them")


def sequence_of(value: object, kind: type | UnionType, place: str) -> tuple[Any, ...]:
    """Return a list of such objects as a tuple; raise CaseError if it is none."""
    if not isinstance(value, (list, tuple)) or not all(isinstance(entry, kind) for entry in value):
        names = " or ".join(each.__name__ for each in get_args(kind) or (kind,))
        raise CaseError(f"{place} is {value!r}; allowed: a list of {names}")
    return tuple(value)


def check_dimension(value: tuple[Any, ...], place: str, dimension: int) -> None:
    """Raise CaseError if what was given for bodies of this dimension has another number of entries."""
    if len(value) != dimension:
        kind = _BODIES[dimension]
        raise CaseError(f"{place} has {len(value)} entries; allowed: {dimension}, since the bodies are {kind}")


def entries_of(value: object, place: str, allowed: str) -> tuple[Any, ...]:
    """Return two or three entries as a tuple; raise CaseError if there is another number of them."""
    if not isinstance(value, (list, tuple)) or len(value) not in (2, 3):
        raise CaseError(f"{place} is {value!r}; allowed: {allowed}")
    return tuple(value)


def check_numbers(value: object, place: str, allowed: str) -> None:
    """Raise CaseError if a value is not two or three finite numbers."""
    if not all(is_number(entry) for entry in entries_of(value, place, allowed)):
        raise CaseError(f"{place} is {value!r}; allowed: {allowed}")


def is_number(value: object) -> bool:
    """Return whether a value is a finite number, and no boolean."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= float_info.max
