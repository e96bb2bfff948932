"""The package's own numbers by name, such as ``solver.continuation.last``, and runs in which one of them is another."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from operator import attrgetter
from typing import Any

from ngcell.build.options import Options


def usual(number: str) -> float:
    """Return one of the package's own numbers."""
    return float(attrgetter(number)(Options()))


def changed(number: str, value: float) -> Options:
    """Return the package's own numbers with a value in place of one of them."""
    options: Options = _with(Options(), number.split("."), value)
    return options


def with_tolerance(multiple: float) -> Options:
    """Return the package's own numbers with another decrement at which equilibria end."""
    number = "solver.continuation.at_the_end"
    return changed(number, usual(number) * multiple)


def names(record: Any | None = None, prefix: str = "") -> list[str]:
    """Return the names of all single numbers, of those of one record with a prefix."""
    given, found = Options() if record is None else record, []
    for name in (field.name for field in fields(given)):
        value = getattr(given, name)
        if is_dataclass(value):
            found += names(value, f"{prefix}{name}.")
        elif not isinstance(value, tuple):
            found.append(f"{prefix}{name}")
    return found


def _with(record: Any, path: list[str], value: float) -> Any:
    name, *rest = path
    return replace(record, **{name: _with(getattr(record, name), rest, value) if rest else value})
