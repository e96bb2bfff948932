"""Area that bodies in the plane cover twice: two of them, or one by itself.

Points of walls tell how deep walls lie in other bodies; they say nothing of bodies whose walls coincide, nor of corners
that stick out of an element between its points. Here it is areas that decide, from polygons that share nothing with the
contact search. A *depth* is twice the area of a connected part over its circumference: the mean thickness of a thin
part, at most half the width of a thick one. It is never above the largest depth of a point of the part.

One body lies in itself where its whole boundary, lumens included, goes around points more than once, or the wrong way
round. With the body on the left of the boundary, the winding number is 1 inside and 0 outside. It is 2 where a wall
passes another one of the same body, and within the part of a lumen that is inside out; it is negative where a lumen has
left its wall.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.loops import signed_area
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.outlines import all_boundaries, outlines

Array = NDArray[np.float64]


def depth_in_itself(space: DisplacementSpace, positions: Array, unit: Array | None = None) -> tuple[float, int]:
    """Return the largest depth, >= 0, of a part of a body that lies in the same body, and that body.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns, in the plane.
    positions : array of float, shape (2, scalar unknowns)
        Deformed positions as unknowns [length].
    unit : array of float, shape (bodies,), optional
        A length of each body, which depths are taken over. By default a depth is a length.
    """
    boundary = all_boundaries(space)
    rings = outlines(boundary).rings(boundary.nodes(positions))
    polygons = np.array([shapely.Polygon(shell, holes) for shell, *holes in rings.values()], dtype=object)
    simple, deepest, where = shapely.is_valid(polygons), 0.0, 0
    for is_simple, (body, loops) in zip(simple, rings.items(), strict=True):
        if is_simple and _keeps_its_sense(loops):
            continue
        depth = max(map(_depth, _covered_twice(loops)), default=0.0) / (1.0 if unit is None else float(unit[body]))
        if depth > deepest:
            deepest, where = depth, body
    return deepest, where


def _keeps_its_sense(loops: list[Array]) -> bool:
    shell, *holes = loops
    return signed_area(shell) > 0 and all(signed_area(hole) < 0 for hole in holes)


def _covered_twice(loops: list[Array]) -> list[shapely.Geometry]:
    """Return the parts whose winding number is neither 0 nor 1."""
    closed = [np.vstack([loop, loop[:1]]) for loop in loops]
    found = list(shapely.get_parts(shapely.polygonize(_noded(closed))))
    points = shapely.get_coordinates(shapely.point_on_surface(found)) if found else np.zeros((0, 2))
    winding = sum((_winding(points, line) for line in closed), np.zeros(len(points)))
    wrong = [face for face, number in zip(found, winding, strict=True) if number not in (0, 1)]
    return list(shapely.get_parts(shapely.union_all(wrong))) if wrong else []


def _noded(closed: list[Array]) -> list[shapely.Geometry]:
    """Return the lines, cut where they meet."""
    return list(shapely.get_parts(shapely.union_all([shapely.LineString(line) for line in closed])))


def _winding(points: Array, line: Array) -> Array:
    """Return how often a closed line, (corners, 2), goes around each point anticlockwise."""
    start, end = line[:-1] - points[:, None], line[1:] - points[:, None]
    left = start[..., 0] * end[..., 1] - start[..., 1] * end[..., 0]
    up = (start[..., 1] <= 0) & (end[..., 1] > 0) & (left > 0)
    down = (start[..., 1] > 0) & (end[..., 1] <= 0) & (left < 0)
    return np.asarray(up.sum(1) - down.sum(1), dtype=float)


def depth_in_others(space: DisplacementSpace, walls: EdgeSurface, positions: Array, unit: Array | None = None) -> float:
    """Return the largest depth, >= 0, of a part that two bodies share, in the plane; over the smaller `unit` of both,
    shape (bodies,), where lengths of bodies are given.

    A hollow body whose lumen is no wall counts as filled, as for `ngcell.results.outline_overlap.deepest_overlap`.
    """
    whole = walls if len(outlines(walls).shells) == space.body_count else all_boundaries(space)
    bodies, polygons = outlines(whole).polygons(whole.nodes(positions))
    crossed = ~shapely.is_valid(polygons)
    polygons[crossed] = shapely.make_valid(polygons[crossed])
    one, two = shapely.STRtree(polygons).query(polygons)
    one, two = one[one < two], two[one < two]
    shared, pair = shapely.get_parts(shapely.intersection(polygons[one], polygons[two]), return_index=True)
    depth = np.fromiter(map(_depth, shared), dtype=float, count=len(shared))
    if unit is not None:
        depth = depth / np.minimum(unit[bodies[one]], unit[bodies[two]])[pair]
    return float(depth.max(initial=0.0))


def _depth(part: shapely.Geometry) -> float:
    around = float(shapely.length(part))
    return 2 * float(shapely.area(part)) / around if around > 0 else 0.0
