"""The rooms of the house import in one direction only, and the front door opens fast."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import ngcell

PACKAGE = Path(ngcell.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))
IDS = [str(module.relative_to(PACKAGE)) for module in MODULES]

#: Rooms in their order: each may import those named before it, besides itself.
ORDER = (
    "errors", "clock", "threads", "scene", "geometry", "mechanics", "contact", "problem", "results", "build", "export",
    "report", "recording", "run", "ensemble", "sweeps", "cli",
)  # fmt: skip

#: Rooms that may import less: what they do not name they cannot come to depend on.
NARROW = {
    "clock": set(),
    "threads": set(),
    "scene": {"errors"},
    "geometry": {"errors", "scene"},
    "export": {"errors", "scene", "results"},
    # The report tells what folders hold, and by which version.
    "report": {"errors", "scene", "results", "export", "__version__"},
    # The solver knows a problem by protocol only, and of scenes what sections of cases are made of.
    "solve": {"errors", "clock", "threads", "scene"},
    # The command line hands on what a case says, and shows what came of it.
    "cli": {"errors", "scene", "results", "export", "report", "recording", "run", "ensemble", "sweeps", "__version__"},
    # The table of contents names what it offers to type checkers; at run time it imports on demand.
    "__init__": {*ORDER, "solve"} - {"cli"},
    "__main__": {"cli"},
}
#: Rooms that may import the solver.
SOLVING = {"build", "recording", "run", "ensemble", "sweeps"}

#: Modules of the scene that kinds may know, wherever they stand: what sections are made of. No case, no reader.
SECTIONS = {"bodies", "choice", "dotted", "entries", "levels", "scope", "section"}
#: Rooms that may know less of the scene.
SECTIONS_OF = {"solve": {"section"}}


def allowed(room: str) -> set[str]:
    """Return the rooms that a room may import, besides itself."""
    before = set(ORDER[: ORDER.index(room)]) if room in ORDER else set()
    return NARROW.get(room, before | ({"solve"} if room in SOLVING else set()))


#: Libraries that a room does not know.
NUMERICS = {"ngsolve", "netgen", "numpy", "scipy", "shapely"}
PICTURES = {"pyvista", "vtk", "vtkmodules", "matplotlib"}
UNKNOWN = {
    "scene": NUMERICS | PICTURES | {"time", "click", "rich"},
    "geometry": PICTURES | {"click", "rich"},
    "mechanics": PICTURES | {"click", "rich"},
    "contact": PICTURES | {"click", "rich"},
    "results": PICTURES | {"click", "rich"},
    "solve": PICTURES | {"netgen", "click", "rich"},
    "export": {"click", "rich"},
    "report": {"click", "rich", "ngsolve", "netgen"},
    "problem": PICTURES | {"click", "rich"},
    "build": PICTURES | {"click", "rich"},
    "recording": PICTURES | {"click", "rich"},
    "run": PICTURES | {"click", "rich"},
    "ensemble": PICTURES | {"click", "rich"},
    "sweeps": PICTURES | {"click", "rich"},
    "cli": NUMERICS | PICTURES,
    "errors": NUMERICS | PICTURES | {"click", "rich", "pydantic"},
}


def room_of(module: Path) -> str:
    return module.relative_to(PACKAGE).parts[0].removesuffix(".py")


@cache
def imports(module: Path) -> tuple[tuple[str, ...], ...]:
    """Return the dotted parts of each import, wherever it stands in the module."""
    return tuple(_imports(module))


def _imports(module: Path) -> Iterator[tuple[str, ...]]:
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from imported_from(node, module)


def imported_from(node: ast.ImportFrom, module: Path) -> Iterator[tuple[str, ...]]:
    package = ("ngcell", *module.relative_to(PACKAGE).parent.parts)
    start = package[: len(package) - node.level + 1] if node.level else ()
    source = (*start, *(node.module.split(".") if node.module else ()))
    for alias in node.names:
        yield (*source, alias.name)


@pytest.mark.parametrize("module", MODULES, ids=IDS)
def test_rooms_import_only_the_rooms_before_them(module: Path) -> None:
    room = room_of(module)
    assert room in {*ORDER, *NARROW}, f"{room} is no room of the house: give it a place in ORDER"
    used = {parts[1] for parts in imports(module) if parts[0] == "ngcell" and len(parts) > 1}
    assert used <= allowed(room) | {room}


@pytest.mark.parametrize("module", MODULES, ids=IDS)
def test_kinds_know_of_the_scene_what_sections_are_made_of(module: Path) -> None:
    room = room_of(module)
    is_kind = room != "scene" and re.search(r"^    kind: Literal\[", module.read_text(), re.MULTILINE)
    if is_kind or room in SECTIONS_OF:
        used = {parts[2] for parts in imports(module) if parts[:2] == ("ngcell", "scene")}
        assert used <= SECTIONS_OF.get(room, SECTIONS)


@pytest.mark.parametrize("module", MODULES, ids=IDS)
def test_rooms_do_not_know_the_libraries_of_others(module: Path) -> None:
    used = {parts[0] for parts in imports(module)}
    assert not used & UNKNOWN.get(room_of(module), set())


@pytest.mark.parametrize("module", MODULES, ids=IDS)
def test_modules_are_named_after_what_they_hold(module: Path) -> None:
    assert module.stem not in {"utils", "helpers", "misc", "common", "manager", "base"}
    assert not module.stem.startswith("new_")


@pytest.mark.parametrize("front_door", ["ngcell", "ngcell.cli", "ngcell.scene", "ngcell.sweeps.worker"])
def test_front_doors_open_without_numerics(front_door: str) -> None:
    heavy = sorted(NUMERICS | PICTURES)
    program = f"import sys, {front_door}; print(*(name for name in {heavy} if name in sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert loaded.stdout.split() == []


#: Libraries that take long to load and that a run needs at its end, for pictures, or not at all.
LATE = {
    "scipy.spatial", "scipy.sparse.csgraph", "scipy.linalg", "scipy.stats", "matplotlib", "pyvista", "vtkmodules",
    "rich", "dask", "distributed", "pandas", "pyarrow", "xarray",
}  # fmt: skip


def test_a_run_starts_without_what_it_may_never_need() -> None:
    program = f"import sys, ngcell.run; print(*(name for name in {sorted(LATE)} if name in sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert loaded.stdout.split() == []


def test_a_scene_without_fluids_and_fibres_does_not_load_them() -> None:
    program = (
        "import sys\nfrom ngcell.scene import read_case\nfrom ngcell.run import inspect\n"
        "inspect(read_case('shear-empty-3x3'))\n"
        "print(*(name for name in ('fluid', 'lumens.fluid', 'laws.fibres', 'laws.custom')"
        " if f'ngcell.mechanics.{name}' in sys.modules))"
    )
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert loaded.stdout.split() == []


def test_table_of_contents_is_sorted_and_holds_the_case() -> None:
    assert sorted(ngcell.__all__) == ngcell.__all__
    assert ngcell.Case.__name__ == "Case"
    assert set(ngcell.__all__) <= set(dir(ngcell))
    with pytest.raises(AttributeError, match="no attribute 'Cas'"):
        _ = ngcell.Cas
