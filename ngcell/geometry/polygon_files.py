"""Cells from files: GeoJSON, WKT, or a table of corners."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import GeometryError

Array = NDArray[np.float64]

_COLUMNS = ("cell", "x", "y")


def read_polygons(file: Path) -> tuple[list[Array], list[str]]:
    """Return the corners of each cell in a file, shape (corners, 2), and what messages call the cells.

    A GeoJSON file holds a collection of polygons, a WKT file one polygon a line or a collection of them. A CSV file has
    the columns cell, x and y, a row for each corner: those of a cell follow each other, in the order around it.

    Raises
    ------
    GeometryError
        If there is no such file, or it holds something else than polygons without holes.
    """
    readers: dict[str, Callable[[Path, str], tuple[list[Array], list[str]]]] = {
        ".geojson": _from_geojson, ".json": _from_geojson, ".wkt": _from_wkt, ".csv": _from_csv,
    }  # fmt: skip
    reader = readers.get(file.suffix.lower())
    if reader is None:
        raise GeometryError(f"{file}: its name ends in none of {', '.join(readers)}; allowed: a file of that sort")
    try:
        text = file.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8"
        raise GeometryError(f"{file}: cannot be read ({reason}); allowed: a readable file of polygons") from error
    polygons, names = reader(file, text)
    if not polygons:
        raise GeometryError(f"{file}: holds no polygon; allowed: one or more")
    return polygons, names


def _from_geojson(file: Path, text: str) -> tuple[list[Array], list[str]]:
    import shapely

    try:
        shape = shapely.from_geojson(text)
    except (shapely.GEOSException, NotImplementedError) as error:
        reason = _first_line(error)
        raise GeometryError(f"{file}: is no GeoJSON ({reason}); allowed: a collection of polygons") from error
    return _of_shapes(file, _members(shape))


def _from_wkt(file: Path, text: str) -> tuple[list[Array], list[str]]:
    import shapely

    shapes = []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip():
            continue
        try:
            shapes += _members(shapely.from_wkt(line))
        except (shapely.GEOSException, NotImplementedError) as error:
            reason = _first_line(error)
            raise GeometryError(f"{file}:{number}: is no WKT ({reason}); allowed: a POLYGON a line") from error
    return _of_shapes(file, shapes)


def _from_csv(file: Path, text: str) -> tuple[list[Array], list[str]]:
    try:
        rows = list(csv.DictReader(text.splitlines()))
    except csv.Error as error:
        raise GeometryError(f"{file}: is no CSV ({error}); allowed: the columns {', '.join(_COLUMNS)}") from error
    if text.strip() and not rows:
        raise GeometryError(f"{file}: has no row below its first line; allowed: a row for each corner")
    if not rows or not set(_COLUMNS) <= set(rows[0]):
        raise GeometryError(f"{file}: its first line does not name {', '.join(_COLUMNS)}; allowed: these columns")
    corners: dict[str, list[tuple[float, float]]] = {}
    last = None
    for number, row in enumerate(rows, start=2):
        cell = row["cell"]
        if cell != last and cell in corners:
            raise GeometryError(f"{file}:{number}: cell {cell} again; allowed: corners of a cell one after the other")
        try:
            corners.setdefault(cell, []).append((float(row["x"]), float(row["y"])))
        except (TypeError, ValueError):
            said = f"x = {row['x']!r}, y = {row['y']!r}"
            raise GeometryError(f"{file}:{number}: {said}; allowed: two numbers") from None
        last = cell
    return [_once(np.array(places)) for places in corners.values()], [f"cell {cell}" for cell in corners]


def _of_shapes(file: Path, shapes: list[object]) -> tuple[list[Array], list[str]]:
    import shapely

    polygons = []
    for number, shape in enumerate(shapes):
        if isinstance(shape, shapely.MultiPolygon) and len(shape.geoms) == 1:
            shape = shape.geoms[0]
        if isinstance(shape, shapely.MultiPolygon):
            pieces = len(shape.geoms)
            raise GeometryError(f"{file}: cell {number} is of {pieces} pieces; allowed: one polygon a cell")
        if not isinstance(shape, shapely.Polygon) or shape.is_empty:
            sort = getattr(shape, "geom_type", "nothing")
            raise GeometryError(f"{file}: cell {number} is a {sort}; allowed: a polygon with an area")
        if shape.interiors:
            raise GeometryError(
                f"{file}: cell {number} has a hole; allowed: polygons without holes (pores lie between cells)"
            )
        polygons.append(_once(np.asarray(shape.exterior.coords)[:, :2]))
    return polygons, [f"cell {number}" for number in range(len(polygons))]


def _members(shape: object) -> list[object]:
    """Return the members of a collection; a polygon, of one piece or of several, is its own."""
    import shapely

    return list(shape.geoms) if isinstance(shape, shapely.GeometryCollection) else [shape]


def _once(places: Array) -> Array:
    """Return corners without the last, where it repeats the first."""
    return places[:-1] if len(places) > 1 and (places[0] == places[-1]).all() else places


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0]
