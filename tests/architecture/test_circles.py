"""No module imports itself by way of others, inside a room or across rooms, also not from within a function."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import ngcell

PACKAGE = Path(ngcell.__file__).parent
ROOMS = sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))


def dotted(module: Path) -> str:
    return ".".join((PACKAGE.name, *module.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")


MODULES = {dotted(module): module for module in sorted(PACKAGE.rglob("*.py"))}


@cache
def imported(module: str) -> frozenset[str]:
    """Return the modules of the package that a module imports, wherever; those only for type checkers count too."""
    return frozenset(_imported(module))


def _imported(module: str) -> Iterator[str]:
    path = MODULES[module]
    package = module.split(".") if path.stem == "__init__" else module.split(".")[:-1]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in MODULES)
        elif isinstance(node, ast.ImportFrom):
            start = package[: len(package) - node.level + 1] if node.level else []
            source = ".".join([*start, *([node.module] if node.module else [])])
            yield from (found for alias in node.names if (found := _module(source, alias.name)))


def _module(source: str, name: str) -> str | None:
    """A name taken from a package is a module of its own, or stands in the package's `__init__`."""
    return next((found for found in (f"{source}.{name}", source) if found in MODULES), None)


def circle(modules: set[str]) -> list[str]:
    graph = {module: sorted(imported(module) & modules - {module}) for module in sorted(modules)}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


@pytest.mark.parametrize("room", ROOMS)
def test_no_circle_inside_a_room(room: str) -> None:
    assert circle({module for module in MODULES if module.split(".")[1:2] == [room]}) == []


def test_no_circle_in_the_package() -> None:
    assert circle(set(MODULES)) == []
