"""The one place where studies change what the package does not hand down as a setting: its own numbers, and calls.

A number is named by its module and name, such as ``solve.continuation.LAST``, or by the record of defaults that holds
it. When the package hands such a number down
in a record, `changed` is where it is put into that record.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from time import process_time
from types import ModuleType
from typing import Any

from ngcell.build import simulation
from ngcell.contact.methods.penalty import PenaltyContact, PenaltySet
from ngcell.export import ResultFolder

#: Fields of `Continuation` that take their defaults from these names when the class is made.
_FIELDS = {"LAST": "last", "NARROWEST": "narrowest"}


#: Functions that take these numbers as the defaults of their last parameters when they are defined.
_DEFAULTS = {"contact.pairing.near.FACING": "facing"}


def usual(number: str) -> float:
    """Return one of the package's own numbers."""
    owner, name = _owner_and_name(number)
    return float(getattr(owner, name))


@contextmanager
def changed(number: str, value: float) -> Iterator[None]:
    """Put a value in place of one of the package's own numbers."""
    owner, name = _owner_and_name(number)
    places = [place for place in (owner, simulation) if hasattr(place, name)]
    before, path = getattr(owner, name), simulation.Continuation
    function = getattr(owner, _DEFAULTS[number]) if number in _DEFAULTS else None
    for place in places:
        _set(place, name, value)
    if name in _FIELDS:
        simulation.Continuation = partial(path, **{_FIELDS[name]: value})
    if function is not None:
        function.__defaults__ = (value,)
    try:
        yield
    finally:
        simulation.Continuation = path
        for place in places:
            _set(place, name, before)
        if function is not None:
            function.__defaults__ = (before,)


@contextmanager
def changed_tolerance(multiple: float) -> Iterator[None]:
    """Multiply the decrement at which equilibria end."""
    number = "solve.continuation.AT_THE_END"
    with changed(number, usual(number) * multiple):
        yield


@contextmanager
def without_pictures() -> Iterator[None]:
    """Leave out the pictures of result folders, which take longer than many small runs."""
    draw = ResultFolder.draw
    ResultFolder.draw = lambda *_, **__: None
    try:
        yield
    finally:
        ResultFolder.draw = draw


@contextmanager
def seconds_of_contact() -> Iterator[dict[str, float]]:
    """Add up the processor seconds that contact takes: search, gaps and penalty terms."""
    spent = {"contact": 0.0}
    contact = [(PenaltyContact, name) for name in ("__init__", "pair", "couplings") if hasattr(PenaltyContact, name)]
    calls = contact + [(PenaltySet, name) for name in _methods(PenaltySet)]
    before = [getattr(owner, name) for owner, name in calls]
    for (owner, name), call in zip(calls, before, strict=True):
        setattr(owner, name, _timed(call, spent))
    try:
        yield spent
    finally:
        for (owner, name), call in zip(calls, before, strict=True):
            setattr(owner, name, call)


def _owner_and_name(number: str) -> tuple[Any, str]:
    """Return the module, or the record of default options in a module, that holds a number, and its name there."""
    path, _, name = number.rpartition(".")
    module, _, record = path.rpartition(".")
    if record.isupper():
        return getattr(import_module(f"ngcell.{module}"), record), name
    return import_module(f"ngcell.{path}"), name


def _set(owner: Any, name: str, value: float) -> None:
    if isinstance(owner, ModuleType):
        setattr(owner, name, value)
    else:
        object.__setattr__(owner, name, value)  # a record of defaults is frozen, and shared by all that use it


def _methods(owner: type) -> Sequence[str]:
    return [name for name, value in vars(owner).items() if callable(value) and not name.startswith("__")]


def _timed(call: Callable[..., Any], spent: dict[str, float]) -> Callable[..., Any]:
    """Return a function whose seconds are added up, once where such functions call each other."""

    def timed(*arguments: Any, **options: Any) -> Any:
        if spent.get("inside"):
            return call(*arguments, **options)
        started, spent["inside"] = process_time(), 1.0
        try:
            return call(*arguments, **options)
        finally:
            spent["inside"] = 0.0
            spent["contact"] += process_time() - started

    return timed
