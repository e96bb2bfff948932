"""From polygons to outlines that share their walls: corners that are one, sides that are split, neighbours.

A place where corners of several polygons lie becomes one node. A node inside a side of a polygon splits that side, as
the vertical joints of a running bond do those of the bricks above and below. What two polygons then share is whole
sides of both.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.near import components, near_pairs
from ngcell.geometry.outlines import Outlines, following

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of the smaller cell's area by which cells may overlap: what round-off leaves.
_OVERLAP = 1e-6
#: Largest width of a gap that is a mistake, as a share of the side along it: a wider one is a corner of a pore.
_GAP = 0.1


def outlines_of(
    polygons: Sequence[Array], same: float, *, narrowest: float = 0.0, names: Sequence[str] | None = None
) -> Outlines:
    """Return the outlines of polygons.

    Parameters
    ----------
    polygons : sequence of array of float, shape (corners, 2)
        Corners of each cell in either sense of rotation, each once [length].
    same : float
        Distance up to which corners, and a corner and a side, are one [length].
    narrowest : float
        Width of the narrowest pore between cells [length]; what is narrower is a gap that should not be there.
    names : sequence of str, optional
        How messages name the cells; by default by their numbers.

    Raises
    ------
    GeometryError
        If a polygon crosses itself or has no area, or two of them overlap or have a gap between them.
    """
    names = names or [f"cell {number}" for number in range(len(polygons))]
    _check_each(polygons, names)
    given = [polygon[::-1] if _area(polygon) < 0 else polygon for polygon in map(np.asarray, polygons)]
    counts = np.array([len(polygon) for polygon in given])
    points = np.concatenate(given)
    node = components(len(points), *near_pairs(points, same))
    number = np.bincount(node)
    places = np.column_stack([np.bincount(node, points[:, axis]) / number for axis in range(2)])
    outlines = outlines_through(places, *_with_junctions(places, node, counts, same), names)
    _check_still_simple(outlines, names)
    _check_gaps(outlines, same, narrowest, names)
    return outlines


def outlines_through(places: Array, node: Index, counts: Index, names: Sequence[str] | None = None) -> Outlines:
    """Return the outlines through nodes at these places; each cell's nodes follow each other, (counts.sum(),).

    Raises
    ------
    GeometryError
        If a cell has less than three corners, or two cells are on the same side of a wall.
    """
    names = names or [f"cell {number}" for number in range(len(counts))]
    cell = np.repeat(np.arange(len(counts)), counts)
    kept = node != node[following(counts)]
    node, cell = node[kept], cell[kept]
    counts = np.bincount(cell, minlength=len(counts))
    if (counts < 3).any():
        raise GeometryError(f"{names[int(np.argmin(counts))]} has less than three corners; allowed: a polygon")
    end = node[following(counts)]
    key, opposite = node * len(places) + end, end * len(places) + node
    order = np.argsort(key)
    twice = np.flatnonzero(np.diff(key[order]) == 0)
    if len(twice):
        one, two = (names[cell[order[twice[0] + step]]] for step in (0, 1))
        raise GeometryError(f"{one} and {two} are on the same side of a wall: they overlap; allowed: cells that touch")
    at = np.minimum(np.searchsorted(key[order], opposite), len(key) - 1)
    twins = np.where(key[order][at] == opposite, order[at], -1)
    return Outlines(places[node], counts, twins)


def _with_junctions(places: Array, node: Index, counts: Index, same: float) -> tuple[Index, Index]:
    """Return the nodes of each cell with those inside of its sides, and their number."""
    import shapely

    ahead = node[following(counts)]
    sides = shapely.linestrings(np.stack([places[node], places[ahead]], axis=1))
    side, inside = shapely.STRtree(shapely.points(places)).query(sides, predicate="dwithin", distance=same)
    is_end = (inside == node[side]) | (inside == ahead[side])
    side, inside = side[~is_end], inside[~is_end]
    way = places[ahead] - places[node]
    place = ((places[inside] - places[node[side]]) * way[side]).sum(1) / (way[side] ** 2).sum(1)
    every, at = np.concatenate([np.arange(len(node)), side]), np.concatenate([np.zeros(len(node)), place])
    order = np.lexsort((at, every))
    cell = np.repeat(np.arange(len(counts)), counts)
    return np.concatenate([node, inside])[order], np.bincount(cell[every], minlength=len(counts))


def _area(polygon: Array) -> float:
    x, y = (polygon - polygon[0]).T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _check_each(polygons: Sequence[Array], names: Sequence[str]) -> None:
    import shapely

    for polygon, name in zip(polygons, names, strict=True):
        if len(polygon) < 3 or not np.isfinite(polygon).all():
            raise GeometryError(f"{name} has {len(polygon)} corners; allowed: three or more, at finite places")
    shapes = np.array([shapely.Polygon(polygon) for polygon in polygons])
    areas = shapely.area(shapes)
    wrong = np.flatnonzero(~shapely.is_valid(shapes) | ~(areas > 0))
    if len(wrong):
        reason = shapely.is_valid_reason(shapes[wrong[0]])
        raise GeometryError(f"{names[wrong[0]]}: {reason}; allowed: a simple polygon with an area")
    one, two = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    one, two = one[one < two], two[one < two]
    share = shapely.area(shapely.intersection(shapes[one], shapes[two])) / np.minimum(areas[one], areas[two])
    if (share > _OVERLAP).any():
        worst = int(share.argmax())
        raise GeometryError(
            f"{names[one[worst]]} and {names[two[worst]]} overlap by {100 * share[worst]:.3g} % of the smaller one; "
            "allowed: cells that touch"
        )


def _check_still_simple(outlines: Outlines, names: Sequence[str]) -> None:
    import shapely

    broken = np.flatnonzero(~shapely.is_valid(outlines.polygons))
    if len(broken):
        reason = shapely.is_valid_reason(outlines.polygons[broken[0]])
        raise GeometryError(f"{names[broken[0]]}: {reason} once near corners are one; allowed: a smaller tolerance")


def _check_gaps(outlines: Outlines, same: float, narrowest: float, names: Sequence[str]) -> None:
    """Check that no outer side runs along another cell without touching it."""
    import shapely

    outer = np.flatnonzero(outlines.twins < 0)
    middle = (outlines.corners + outlines.corners[outlines.ahead])[outer] / 2
    limit = np.minimum(_GAP * outlines.lengths[outer], narrowest)
    tree = shapely.STRtree(outlines.polygons)
    side, cell = tree.query(shapely.points(middle), predicate="dwithin", distance=limit)
    way = np.diff(_ends(shapely.shortest_line(shapely.points(middle[side]), outlines.polygons[cell])), axis=1)[:, 0]
    along = outlines.directions[outer[side]]
    is_outward = way[:, 0] * along[:, 1] - way[:, 1] * along[:, 0] > 0
    found = np.flatnonzero(is_outward & (cell != outlines.cell[outer[side]]))
    if len(found):
        at, width = side[found[0]], np.linalg.norm(way[found[0]])
        one, two = outlines.cell[outer[at]], cell[found[0]]
        raise GeometryError(
            f"{names[one]} and {names[two]} have a gap of {width:.3g} between them, about ({middle[at, 0]:.4g}, "
            f"{middle[at, 1]:.4g}); allowed: walls that touch to {same:.3g}, or pores wider than "
            f"{narrowest:.3g}"
        )


def _ends(lines: NDArray[np.object_]) -> Array:
    """Return both ends of straight lines, shape (lines, 2, 2)."""
    import shapely

    return np.asarray(shapely.get_coordinates(lines).reshape(-1, 2, 2))
