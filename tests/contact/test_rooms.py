"""The rooms of contact: they import one way, and the dimension is asked where a surface is found and nowhere else."""

from __future__ import annotations

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import ngcell.contact

HERE = Path(ngcell.contact.__file__).parent
MODULES = {
    ".".join(("ngcell", "contact", *path.relative_to(HERE).with_suffix("").parts)): path for path in HERE.rglob("*.py")
}
ROOMS = ["options", "surface", "pairing", "gap", "cohesion", "methods"]
#: The one module that asks for the dimension.
FACTORY = "ngcell.contact.surface.find"


def imported(tree: ast.AST) -> set[str]:
    """Modules of the room that a module or a function imports, also from packages."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


def asks_for_the_dimension(node: ast.AST) -> bool:
    """Whether something called dimension, or the length of something, is compared with 2 or 3."""
    if not isinstance(node, ast.Compare):
        return False
    sides = [node.left, *node.comparators]
    numbers = [side.value for side in sides if isinstance(side, ast.Constant)]
    text = " ".join(ast.unparse(side) for side in sides)
    return bool({2, 3} & set(numbers)) and ("dim" in text or "len(" in text or "shape" in text)


@pytest.mark.parametrize("name", sorted(MODULES))
def test_the_dimension_is_asked_where_a_surface_is_found_only(name):
    tree = ast.parse(MODULES[name].read_text())
    asked = [ast.unparse(node) for node in ast.walk(tree) if asks_for_the_dimension(node)]
    assert len(asked) == (name == FACTORY), asked


def test_rooms_import_the_rooms_before_them_and_no_circles():
    graph = {name: imported(ast.parse(path.read_text())) & set(MODULES) for name, path in MODULES.items()}
    list(TopologicalSorter(graph).static_order())  # raises CycleError
    for name, used in graph.items():
        for other in used:
            assert ROOMS.index(other.split(".")[2]) <= ROOMS.index(name.split(".")[2]), (name, other)


@pytest.mark.parametrize("name", sorted(MODULES))
def test_no_function_imports_a_module_of_the_package(name):
    for node in ast.walk(ast.parse(MODULES[name].read_text())):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.If)):
            assert not [each for each in imported(node) if each.startswith("ngcell")], name
