"""The tissues of the study `kinds`: entries of a case, and the files that two of them are read from."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Entries = dict[str, Any]

#: Thickness of the walls; the side of hexagons is 1, and other cells are about as large.
WALL = 0.1
#: Of the file of polygons: side of a square cell, sagitta of its upright walls, and the length that pores cut off.
_SIDE, _SAGITTA, _PORE = 1.6, 0.25, 0.25
#: Of the image: pixels along the side of a cell; by how much centres are displaced, and the radius of the pore,
#: as shares of that side.
_PIXELS, _NOISE, _HOLE = 32, 0.18, 0.2


def polygons(cols: int, rows: int) -> list[list[tuple[float, float]]]:
    """Return square cells whose upright walls have a kink, into every second cell, with pores between them.

    Every second corner inside the tissue is a pore: the cells around it end short of it.
    """
    return [_polygon(col, row, cols, rows) for row in range(rows) for col in range(cols)]


def _polygon(col: int, row: int, cols: int, rows: int) -> list[tuple[float, float]]:
    corners = [(col, row), (col + 1, row), (col + 1, row + 1), (col, row + 1)]
    places: list[tuple[float, float]] = []
    for number, corner in enumerate(corners):
        ahead, behind = corners[(number + 1) % 4], corners[number - 1]
        if 0 < corner[0] < cols and 0 < corner[1] < rows and sum(corner) % 2 == 0:
            places += [_towards(corner, behind), _towards(corner, ahead)]
        else:
            places.append((_SIDE * corner[0], _SIDE * corner[1]))
        if ahead[0] == corner[0] and 0 < corner[0] < cols:
            kink = _SAGITTA * (-1) ** (corner[0] + row)
            places.append((_SIDE * corner[0] + kink, _SIDE * (corner[1] + ahead[1]) / 2))
    return places


def _towards(corner: tuple[int, int], other: tuple[int, int]) -> tuple[float, float]:
    x, y = (_SIDE * at + _PORE * (to - at) for at, to in zip(corner, other, strict=True))
    return x, y


def labels(cols: int, rows: int) -> NDArray[np.uint16]:
    """Return a label image: each pixel has the number of its nearest centre, those of a pore have 0.

    Centres are those of a running bond, displaced at random by one seed; the pore is where three cells meet, near the
    middle.
    """
    row, col = np.divmod(np.arange(cols * rows), cols)
    noise = np.random.default_rng(1).uniform(-_NOISE, _NOISE, (cols * rows, 2))
    centres = _PIXELS * (np.column_stack([col + 0.25 + 0.5 * (row % 2), row + 0.5]) + noise)
    y, x = np.mgrid[: rows * _PIXELS, : cols * _PIXELS] + 0.5
    distance = (x[..., None] - centres[:, 0]) ** 2 + (y[..., None] - centres[:, 1]) ** 2
    nearest = distance.argmin(-1) + 1
    second = np.sort(distance, axis=-1)[..., 2] - distance.min(-1)  # next to nothing where three cells meet
    away = np.hypot(x / _PIXELS - cols / 2, y / _PIXELS - rows / 2)
    at = np.unravel_index(np.where(away < 1, second, np.inf).argmin(), x.shape)
    nearest[np.hypot(x - x[at], y - y[at]) < _HOLE * _PIXELS] = 0
    return np.asarray(nearest, dtype=np.uint16)


def _written_polygons(folder: Path, cols: int, rows: int) -> str:
    cells = [{"type": "Polygon", "coordinates": [[*cell, cell[0]]]} for cell in polygons(cols, rows)]
    file = folder / f"cells-{cols}x{rows}.geojson"
    file.write_text(json.dumps({"type": "GeometryCollection", "geometries": cells}), encoding="utf-8")
    return str(file)


def _written_labels(folder: Path, cols: int, rows: int) -> str:
    from PIL import Image

    file = folder / f"cells-{cols}x{rows}.png"
    Image.fromarray(labels(cols, rows)).save(file)
    return str(file)


def _voronoi(cells: int, width: float, height: float) -> Callable[[Path], Entries]:
    extent = [width, height]
    return lambda _: {"kind": "voronoi", "cells": cells, "extent": extent, "seed": 1, "relaxation": 3}


def _bricks(rows: int, cols: int) -> Callable[[Path], Entries]:
    return lambda _: {"kind": "brick", "rows": rows, "cols": cols, "aspect": 1.5, "length": 2.0}


def _noisy(rows: int, cols: int) -> Callable[[Path], Entries]:
    return lambda _: {"kind": "perturbed", "rows": rows, "cols": cols, "spread": 0.03, "seed": 1}


def _file(cols: int, rows: int) -> Callable[[Path], Entries]:
    return lambda folder: {"kind": "polygons", "file": _written_polygons(folder, cols, rows), "held_within": 0.01}


def _image(cols: int, rows: int) -> Callable[[Path], Entries]:
    pixel = _SIDE / _PIXELS
    return lambda folder: {"kind": "image", "file": _written_labels(folder, cols, rows), "pixel": pixel}


#: The tissues by name, for a folder of files: in full, and of a dozen cells.
TISSUES = {
    "voronoi": _voronoi(60, 12.0, 13.0),
    "bricks": _bricks(10, 6),
    "noisy honeycomb": _noisy(5, 7),
    "polygons": _file(5, 4),
    "image": _image(5, 4),
}
SMALL = {
    "voronoi": _voronoi(12, 5.2, 6.0),
    "bricks": _bricks(4, 3),
    "noisy honeycomb": _noisy(3, 3),
    "polygons": _file(3, 3),
    "image": _image(3, 3),
}
