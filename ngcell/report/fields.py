"""Fields of a snapshot that the report can show, each as one number a point, by name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.report.surface import is_solid
from ngcell.results.snapshot import Grid, Snapshot

Array = NDArray[np.float64]

BODIES, WALLS = "bodies", "walls"
#: Headings of fields whose names in the files are short.
_TITLES = {
    "J": "volume ratio J", "von_mises": "von Mises stress", "gap": "gap", "contact_pressure": "contact pressure",
    "cell_pressure": "pressure in the cell", "energy_density": "energy density",
}  # fmt: skip
#: Fields that are shown first, and given up last where a report would be too large.
_FIRST = ("von_mises", "gap", "displacement_x", "contact_pressure", "energy_density", "J", "cell_pressure")
#: Components of a symmetric tensor that is given by rows.
_TENSOR = {"xx": 0, "yy": 4, "xy": 1, "zz": 8, "yz": 5, "xz": 2}


@dataclass(frozen=True, eq=False)
class Field:
    """One number at each point of the bodies or of the walls.

    Attributes
    ----------
    name : str
        Its name, of this component.
    title : str
        What the report calls it.
    where : {"bodies", "walls"}
        Whose points.
    values : array of float, shape (points,)
        NaN where there is none.
    """

    name: str
    title: str
    where: str
    values: Array


def fields_of(snapshot: Snapshot) -> list[Field]:
    """Return all fields of a snapshot, the most telling first."""
    axes = "xyz" if is_solid(snapshot.bulk) else "xy"
    found = [*_fields(snapshot.bulk, BODIES, axes), *_fields(snapshot.walls, WALLS, axes)]
    return sorted(found, key=lambda one: _FIRST.index(one.name) if one.name in _FIRST else len(_FIRST))


def _fields(grid: Grid, where: str, axes: str) -> Iterator[Field]:
    for name, values in grid.point_data.items():
        if name == "displacement":
            if where == BODIES:
                yield from (
                    Field(f"{name}_{axis}", f"{axis.upper()} displacement", where, np.asarray(values)[:, number])
                    for number, axis in enumerate(axes)
                )
        elif np.ndim(values) == 2 and np.shape(values)[1] == 9:
            for pair, number in _TENSOR.items():
                if set(pair) <= set(axes):
                    yield Field(f"{name}_{pair}", f"{_words(name)} {pair}", where, np.asarray(values)[:, number])
        elif np.ndim(values) == 1:
            yield Field(name, _TITLES.get(name, _words(name)), where, np.asarray(values, dtype=float))
    for name, values in grid.cell_data.items():
        if name not in ("cell_id", "free", "rigid") and np.ndim(values) == 1:
            at_points = np.full(len(grid.points), np.nan)
            at_points[grid.cells] = np.asarray(values, dtype=float)[:, None]
            yield Field(name, _TITLES.get(name, _words(name)), where, at_points)


def _words(name: str) -> str:
    words = name.replace("_", " ")
    return words[:1].upper() + words[1:] if words.startswith("cauchy") else words
