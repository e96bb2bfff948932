"""A tissue from polygons of a user: each cell is a ring between its outline and that outline moved inwards.

Where the honeycomb is a mesh of quadrilaterals written down directly, cells of any shape are faces that Netgen meshes,
in a scene of user-defined bodies: `PolygonTissue.bodies` makes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from netgen import occ
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.faces import check_area
from ngcell.geometry.near import near_pairs
from ngcell.scene.bodies import Body

Array = NDArray[np.float64]
Point = tuple[float, float]

#: Distance, as a share of a side or of the wall, below which two points coincide.
_SAME = 1e-6


@dataclass(frozen=True)
class PolygonTissue:
    """Cells whose outlines are polygons, such as those of a segmented picture.

    Parameters
    ----------
    polygons : sequence of sequence of tuple of float, shape (2,)
        Corners of each cell's outline, in either sense of rotation [length]. Neighbours repeat the corners of their
        common wall; cells may touch and do not overlap.
    wall : float
        Thickness of the walls [length], > 0; every lumen stays open.
    name : str
        Cells are named ``<name>0``, ``<name>1``, ...

    Notes
    -----
    Sides that no other cell has, corner for corner, are outer ones: they get the name ``<cell>_outer`` and the others
    ``<cell>_wall``, by which supports and loads mean them. All may touch.

    Raises
    ------
    GeometryError
        If an outline is no list of corners or crosses itself, or its lumen closes or falls apart.
    """

    polygons: Sequence[Sequence[Point]]
    wall: float
    name: str = "cell"

    def __post_init__(self) -> None:
        for number, corners in enumerate(self.polygons):
            if not _are_corners(corners):
                raise GeometryError(f"polygon {number}: {corners!r:.80}; allowed: three corners or more, (x, y) each")
        for number, outline in enumerate(self._outlines):
            if not outline.is_valid or outline.is_empty:
                raise GeometryError(f"polygon {number}: {shapely.is_valid_reason(outline)}; allowed: a simple polygon")
            lumen = outline.buffer(-self.wall, join_style="mitre")
            if not self.wall > 0 or not isinstance(lumen, shapely.Polygon) or lumen.is_empty:
                raise GeometryError(
                    f"polygon {number}: a wall of {self.wall:g} leaves no single lumen; allowed: 0 < wall < "
                    f"{shapely.maximum_inscribed_circle(outline).length:g}"
                )

    def bodies(self, material: Any) -> tuple[Body, ...]:
        """Return the cells as bodies of a scene, all of one material."""
        faces = enumerate(self.faces)
        return tuple(Body(face, material, f"{self.name}{number}") for number, face in faces)

    @cached_property
    def faces(self) -> tuple[occ.Face, ...]:
        """Face of each cell, in the plane z = 0, with the names of its sides."""
        return tuple(self._face(number) for number in range(len(self.polygons)))

    def _face(self, number: int) -> occ.Face:
        outline, cell = self._outlines[number], f"{self.name}{number}"
        lumen = outline.buffer(-self.wall, join_style="mitre")
        made = _polygon_face(_corners(outline)) - _polygon_face(_corners(lumen))
        check_area(cell, made, outline.area - lumen.area)
        face = made.faces[0]
        middles = _middles(outline)
        for edge in face.edges:
            place = (edge.center.x, edge.center.y)
            if outline.exterior.distance(shapely.Point(place)) < _SAME * self.wall:
                side = np.linalg.norm(middles - place, axis=1).argmin()
                edge.name = f"{cell}_outer" if self._is_outer[number][side] else f"{cell}_wall"
        return face

    @cached_property
    def _outlines(self) -> list[shapely.Polygon]:
        return [shapely.geometry.polygon.orient(shapely.Polygon(corners)) for corners in self.polygons]

    @cached_property
    def _is_outer(self) -> list[NDArray[np.bool_]]:
        """Whether each side of each cell is one that no other cell has."""
        middles = [_middles(outline) for outline in self._outlines]
        shortest = min(outline.length / len(_corners(outline)) for outline in self._outlines)
        is_outer = np.ones(sum(map(len, middles)), dtype=bool)
        for twins in near_pairs(np.concatenate(middles), _SAME * shortest):
            is_outer[twins] = False
        return np.split(is_outer, np.cumsum([len(cell) for cell in middles])[:-1])


def _are_corners(corners: Any) -> bool:
    try:
        places = np.asarray(corners, dtype=float)
    except (TypeError, ValueError):
        return False
    return places.ndim == 2 and len(places) >= 3 and places.shape[1] == 2 and bool(np.isfinite(places).all())


def _corners(polygon: shapely.Polygon) -> Array:
    """Return the corners of a polygon, anticlockwise, each once [length], shape (corners, 2)."""
    return np.asarray(shapely.geometry.polygon.orient(polygon).exterior.coords)[:-1]


def _middles(polygon: shapely.Polygon) -> Array:
    """Return the middles of the sides of a polygon [length], shape (corners, 2)."""
    corners = _corners(polygon)
    return np.asarray((corners + np.roll(corners, -1, axis=0)) / 2)


def _polygon_face(corners: Array) -> occ.Face:
    points = [occ.Pnt(x, y, 0) for x, y in corners]
    sides = [occ.Segment(one, two) for one, two in zip(points, [*points[1:], points[0]], strict=True)]
    return occ.Face(occ.Wire(sides))
