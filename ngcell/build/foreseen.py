"""What a scene will take, foreseen before it is meshed: a slip of the pen in a size should cost a line, not an hour.

The number of elements is that of the tissue's own mesh, or at least that of equilateral elements of the asked-for size
in the areas and volumes of user-defined bodies. The number of entries of the matrix is that of an endless regular mesh
without contact. Along one axis an element of order p has p - 1 nodes inside, each of which meets p + 1 nodes, and one
at an end, which meets 2 p + 1: together p (p + 2) pairs of nodes, in d dimensions (p (p + 2))**d, d**2 entries each,
half of them below the diagonal. Both are too low rather than too high, so that nothing is refused that would fit.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import factorial, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from netgen import occ
from pydantic import BaseModel

from ngcell.build.memory import foreseen_memory
from ngcell.errors import CaseError, GeometryError, TooLarge
from ngcell.scene import BodyScene, Case

#: Elements of unit size in a unit of area or volume, equilateral triangles or tetrahedra.
_IN_A_UNIT = {2: 4 / sqrt(3), 3: 6 * sqrt(2)}
#: Entries of the matrix for each element, over those of a quadrilateral or a hexahedron; measured, and rounded down.
_SIMPLEX_SHARE = {2: 0.17, 3: 0.045}
#: Default size of elements as a share of the body's thickness.
_SHARE = 0.5
#: Magnitude of numbers whose powers, as they occur in energies, are far from the limits of floating-point numbers.
_LARGEST = 1e50
_CGROUP = Path("/sys/fs/cgroup/memory.max")


def check_magnitudes(case: BaseModel) -> None:
    """Check that products of the numbers of a case are numbers, too.

    Raises
    ------
    CaseError
        If one is so large or so small that its powers are not.
    """
    for path, number in _numbers(case.model_dump(exclude={"expected", "accuracy"})):
        if number and not 1 / _LARGEST <= abs(number) <= _LARGEST:
            raise CaseError(
                f"{path} = {number:g} leaves no room to calculate; allowed: 0, or a magnitude from {1 / _LARGEST:g} to "
                f"{_LARGEST:g}"
            )


def _numbers(value: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Yield the numbers with a decimal point in a table, and where they are."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, (list, tuple)):
        for number, inner in enumerate(value):
            yield from _numbers(inner, f"{path}[{number}]")
    elif isinstance(value, float):
        yield path, value


def check_tissue_fits(case: Case) -> None:
    """Check that a tissue can be solved with the memory of this machine, without meshing it.

    Raises
    ------
    TooLarge
        If it cannot.
    """
    count = getattr(case.tissue, "element_count", None)
    if count is None:
        return  # a tissue of a script, which says nothing of its mesh
    elements, dimension = float(count(case.mesh)), 2 if case.tissue.height is None else 3
    _check_fits(elements, case.mesh.plain_order, dimension, 1.0, "mesh.size, mesh.layers, mesh.slices")


def check_bodies_fit(scene: BodyScene) -> None:
    """Check that user-defined bodies have a size, and can be solved with the memory of this machine, without meshing.

    Raises
    ------
    GeometryError, TooLarge
        If they have not, or cannot.
    """
    elements, dimension = body_elements(scene)
    _check_fits(elements, scene.plain_order, dimension, _SIMPLEX_SHARE[dimension], "mesh.size, sizes of bodies")


def body_elements(scene: BodyScene) -> tuple[float, int]:
    """Return the number of elements of user-defined bodies, at least, and their dimension."""
    shapes = [(body.name, body.shape) for body in scene.bodies if isinstance(body.shape, occ.TopoDS_Shape)]
    dimension = 3 if any(len(shape.solids) for _, shape in shapes) else 2
    parts = [part for name, shape in shapes for part in _parts(name, shape, scene.size)]
    total, elements = sum(volume for volume, _ in parts), 0.0
    for volume, size in parts:
        elements += _count(volume, size, dimension)
    for circle in scene.refinements:
        elements += _count(min(total, pi * circle.within**2), circle.size, dimension)
    return elements, dimension


def _parts(name: str, shape: Any, size: float | None) -> Iterator[tuple[float, float]]:
    """Yield area or volume of the parts of a body, and the largest length of an element's edge in each."""
    solids = shape.solids
    for part in solids or shape.faces:
        volume, surface = abs(part.mass), sum(side.mass for side in (part.faces if len(solids) else part.edges))
        if not volume > 0 or not surface > 0:
            raise GeometryError(f"body {name}: it is too small or too thin to have a size; allowed: lengths above 1e-6")
        yield volume, min(part.maxh, _SHARE * 2 * volume / surface if size is None else size)


def _count(volume: float, size: float, dimension: int) -> float:
    with np.errstate(all="ignore"):
        return float(np.float64(_IN_A_UNIT[dimension] * volume) / np.float64(size) ** dimension)


def _check_fits(elements: float, order: int, dimension: int, share: float, keys: str) -> None:
    entries = share * _entries(elements, order, dimension)
    needed, there = foreseen_memory(entries, dimension), available_memory()
    if not needed <= there:
        raise TooLarge(
            f"at least {elements:.2g} elements of order {order}, for which the run would take {needed:.2g} GiB of "
            f"memory; allowed: at most {there:.3g} GiB, by larger or fewer elements ({keys}), fewer bodies or a lower "
            "mesh.order"
        )


def _entries(elements: float, order: int, dimension: int) -> float:
    return float(elements * dimension**2 / 2 * (order * (order + 2)) ** dimension)


@dataclass(frozen=True)
class Foreseen:
    """What a case will take on one mesh, without meshing it.

    Attributes
    ----------
    unknowns : float
        Scalar unknowns of the displacement; of walls that are one element thick.
    memory : float
        Memory of a run [GiB].
    """

    unknowns: float
    memory: float


def foreseen(case: Case | BodyScene) -> Foreseen | None:
    """Return what a scene will take on its own mesh; None for a tissue that does not tell its number of elements."""
    if isinstance(case, BodyScene):
        (elements, dimension), order = body_elements(case), case.plain_order
        share, nodes = _SIMPLEX_SHARE[dimension], order**dimension / factorial(dimension)
    else:
        count = getattr(case.tissue, "element_count", None)
        if count is None:
            return None
        elements, dimension = float(count(case.mesh)), 2 if case.tissue.height is None else 3
        order = case.mesh.plain_order
        share, nodes = 1.0, order ** (dimension - 1) * (order + 1)
    entries = share * _entries(elements, order, dimension)
    return Foreseen(elements * nodes * dimension, foreseen_memory(entries, dimension))


def available_memory() -> float:
    """Return the memory that this process may use [GiB]; infinite where the system does not tell."""
    limits = [float("inf"), *_limits()]
    return min(limits) / 2**30


def _limits() -> Sequence[float]:
    found: list[float] = []
    with suppress(OSError, ValueError, AttributeError):
        found.append(float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE"))
    with suppress(OSError, ValueError):
        found.append(float(_CGROUP.read_text()))  # "max" where there is no limit
    if sys.platform != "win32":
        import resource

        soft = resource.getrlimit(resource.RLIMIT_AS)[0]
        found += [] if soft == resource.RLIM_INFINITY else [float(soft)]
    return [limit for limit in found if limit > 0]
