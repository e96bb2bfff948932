"""How deep bodies in the plane lie inside each other, found from their outlines alone.

This shares nothing with the contact search: wall edges are chained by common unknowns to closed outlines,
each body becomes a polygon, and points of every wall are tested against the polygons of all other bodies. An
outline's holes count only where they are walls. A hollow cell whose lumen is no wall is filled: a cell that
it swallowed overlaps it. A body whose outline is not walls all around becomes the polygon of all its boundaries.

A polygon follows each edge by `_CHORDS` chords, so a depth is right to about the edge's sagitta / `_CHORDS`**2.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from numpy.typing import NDArray

from ngcell.contact.surface.edges import EdgeSurface, find_edges
from ngcell.mechanics.space import DisplacementSpace

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Straight pieces that stand for one curved edge.
_CHORDS = 16


def deepest_overlap_of_faces(walls: EdgeSurface, space: DisplacementSpace, positions: Array) -> float:
    """Return the largest depth [length], >= 0, by which a wall point of a body lies inside another body, in the plane.

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    space : DisplacementSpace
        The unknowns.
    positions : array of float, shape (2, scalar unknowns)
        Deformed positions as unknowns [length].
    """
    whole = _all_boundaries(walls, space)
    rest = None if whole is None else (whole, whole.nodes(positions))
    return deepest_overlap(walls, walls.nodes(positions), rest)


def _all_boundaries(walls: EdgeSurface, space: DisplacementSpace) -> EdgeSurface | None:
    """Return the boundaries of all bodies as if they were walls; None where walls go all around."""
    if walls not in _boundaries:
        everywhere = has_all_outlines(walls, space.bodies.body_count)
        all_names = replace(space.bodies, wall_names=".*")
        _boundaries[walls] = None if everywhere else find_edges(all_names, space.scalar, space.rest)
    return _boundaries[walls]


#: What was found of walls that are still in use.
_boundaries: WeakKeyDictionary[EdgeSurface, EdgeSurface | None] = WeakKeyDictionary()


def deepest_overlap(walls: EdgeSurface, nodes: Array, whole: tuple[EdgeSurface, Array] | None = None) -> float:
    """Return the largest depth [length], >= 0, by which a wall point of a body lies inside another body.

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    nodes : array of float, shape (edges, order + 1, 2)
        Deformed positions of their Lagrange nodes [length].
    whole : tuple of EdgeSurface and array, optional
        All boundaries of all bodies as if they were walls, and their nodes.

    Notes
    -----
    A depth is the distance to the nearest wall of the body that the point lies in. Each edge has
    `2 order + 1` points; a tip of another shape between them is not seen. Without `whole`, a body whose outer boundary
    is not wholly walls has no inside here: its points are tested, but none is tested against it.
    """
    bodies, polygons = _polygons(walls, nodes)
    if whole is not None:
        further, more = _polygons(*whole)
        is_new = ~np.isin(further, bodies)
        bodies, polygons = np.append(bodies, further[is_new]), np.append(polygons, more[is_new])
    places, owner = _wall_points(walls, nodes)
    place, polygon = shapely.STRtree(polygons).query(shapely.points(places))
    foreign = owner[place] != bodies[polygon]
    place, polygon = place[foreign], polygon[foreign]
    shapely.prepare(polygons)
    inside = shapely.contains_xy(polygons[polygon], *places[place].T)
    outlines = _outline_of_each(walls, nodes, bodies, polygons)[polygon[inside]]
    depth = shapely.distance(outlines, shapely.points(places[place[inside]]))
    return float(depth.max(initial=0.0))


def _outline_of_each(
    walls: EdgeSurface, nodes: Array, bodies: Index, polygons: NDArray[np.object_]
) -> NDArray[np.object_]:
    """Return the walls of each body as lines, and all of its boundary where it has no walls."""
    order = np.argsort(walls.body, kind="stable")
    present, number = np.unique(walls.body[order], return_inverse=True)
    values = walls.basis.values(np.linspace(0, 1, _chords(walls) + 1))
    lines = shapely.multilinestrings(shapely.linestrings(values @ nodes[order]), indices=number)
    outlines = shapely.boundary(polygons)
    has_walls = np.isin(bodies, present)
    outlines[has_walls] = lines[np.searchsorted(present, bodies[has_walls])]
    return np.asarray(outlines)


def _chords(walls: EdgeSurface) -> int:
    return 1 if walls.basis.order == 1 else _CHORDS


def has_all_outlines(walls: EdgeSurface, body_count: int) -> bool:
    """Return whether the walls go all around each body."""
    return len(_outlines(walls)[0]) == body_count


def _wall_points(walls: EdgeSurface, nodes: Array) -> tuple[Array, Index]:
    """Return points of all walls, shape (points, 2), and the body of each."""
    count = 2 * walls.basis.order + 1
    values = walls.basis.values(np.linspace(0, 1, count))
    return (values @ nodes).reshape(-1, 2), np.repeat(walls.body, count)


def _polygons(walls: EdgeSurface, nodes: Array) -> tuple[Index, NDArray[np.object_]]:
    """Return the bodies with a closed outline, shape (bodies,), and their deformed polygons."""
    values = walls.basis.values(np.linspace(0, 1, _chords(walls) + 1)[:-1])
    lines = values @ _anticlockwise(walls, nodes)
    shells, holes = _outlines(walls)
    polygons = [
        shapely.Polygon(lines[shell].reshape(-1, 2), [lines[hole].reshape(-1, 2) for hole in holes[body]])
        for body, shell in shells.items()
    ]
    return np.array(list(shells), dtype=np.int64), np.array(polygons, dtype=object)


def _outlines(walls: EdgeSurface) -> tuple[dict[int, Index], dict[int, list[Index]]]:
    """Return the edges around each body in order, and those around its holes.

    A loop with the body on its left runs anticlockwise around the body, and clockwise around a hole.
    """
    corners = _anticlockwise(walls, walls.rest)[:, 0]
    shells: dict[int, Index] = {}
    holes: dict[int, list[Index]] = defaultdict(list)
    for loop in _closed_loops(walls):
        body = int(walls.body[loop[0]])
        if _signed_area(corners[loop]) > 0:
            shells[body] = loop
        else:
            holes[body].append(loop)
    return shells, holes


def _closed_loops(walls: EdgeSurface) -> list[Index]:
    following = _following(walls).tolist()
    unseen = dict.fromkeys(range(walls.facet_count))
    loops = []
    while unseen:
        chain = [unseen.popitem()[0]]
        while following[chain[-1]] in unseen:
            chain.append(following[chain[-1]])
            del unseen[chain[-1]]
        if following[chain[-1]] == chain[0]:
            loops.append(np.array(chain))
    return loops


def _following(walls: EdgeSurface) -> Index:
    """Return the edge that starts where each edge ends, with its body on the left, or -1; shape (edges,)."""
    start, end = np.where(walls.side[:, None] > 0, walls.vertices, walls.vertices[:, ::-1]).T
    starting = np.full(walls.dofs.max(initial=-1) + 1, -1)
    starting[start] = np.arange(walls.facet_count)
    return np.asarray(starting[end])


def _anticlockwise(walls: EdgeSurface, nodes: Array) -> Array:
    """Return the nodes of each edge in the order that has its body on the left."""
    return np.where(walls.side[:, None, None] > 0, nodes, nodes[:, ::-1])


def _signed_area(corners: Array) -> float:
    following = np.roll(corners, -1, axis=0)
    return float(np.sum(corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0])) / 2
