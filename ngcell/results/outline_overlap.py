"""How deep bodies in the plane lie inside each other, found from their outlines alone.

This shares nothing with the contact search: wall edges are chained by common unknowns to closed outlines,
each body becomes a polygon, and points of every wall are tested against the polygons of all other bodies. An
outline's holes count only where they are walls. A hollow cell whose lumen is no wall is filled: a cell that
it swallowed overlaps it. A body whose outline is not walls all around becomes the polygon of all its boundaries.

A polygon follows each edge by 16 chords, so a depth is right to about the edge's sagitta / 16**2.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from ngcell.contact.surface.edges import EdgeSurface
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.outlines import all_boundaries, chords, outlines

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def deepest_overlap_of_faces(
    walls: EdgeSurface, space: DisplacementSpace, positions: Array, unit: Array | None = None
) -> float:
    """Return the largest depth, >= 0, by which a wall point of a body lies inside another body, in the plane.

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    space : DisplacementSpace
        The unknowns.
    positions : array of float, shape (2, scalar unknowns)
        Deformed positions as unknowns [length].
    unit : array of float, shape (bodies,), optional
        A length of each body; a depth is taken over the smaller one of the two. By default it is a length.
    """
    if has_all_outlines(walls, space.body_count):
        return deepest_overlap(walls, walls.nodes(positions), unit=unit)
    whole = all_boundaries(space)
    return deepest_overlap(walls, walls.nodes(positions), (whole, whole.nodes(positions)), unit)


def deepest_overlap(
    walls: EdgeSurface, nodes: Array, whole: tuple[EdgeSurface, Array] | None = None, unit: Array | None = None
) -> float:
    """Return the largest depth, >= 0, by which a wall point of a body lies inside another body.

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    nodes : array of float, shape (edges, order + 1, 2)
        Deformed positions of their Lagrange nodes [length].
    whole : tuple of EdgeSurface and array, optional
        All boundaries of all bodies as if they were walls, and their nodes.
    unit : array of float, shape (bodies,), optional
        A length of each body; a depth is taken over the smaller one of the two. By default it is a length.

    Notes
    -----
    A depth is the distance to the nearest wall of the body that the point lies in. Each edge has
    `2 order + 1` points; a tip of another shape between them is not seen. Without `whole`, a body whose outer boundary
    is not wholly walls has no inside here: its points are tested, but none is tested against it.
    """
    bodies, polygons = outlines(walls).polygons(nodes)
    if whole is not None:
        further, more = outlines(whole[0]).polygons(whole[1])
        is_new = ~np.isin(further, bodies)
        bodies, polygons = np.append(bodies, further[is_new]), np.append(polygons, more[is_new])
    places, owner = _wall_points(walls, nodes)
    place, polygon = shapely.STRtree(polygons).query(shapely.points(places))
    foreign = owner[place] != bodies[polygon]
    place, polygon = place[foreign], polygon[foreign]
    shapely.prepare(polygons)
    inside = shapely.contains_xy(polygons[polygon], *places[place].T)
    lines = _outline_of_each(walls, nodes, bodies, polygons)[polygon[inside]]
    depth = shapely.distance(lines, shapely.points(places[place[inside]]))
    if unit is not None:
        depth = depth / np.minimum(unit[owner[place[inside]]], unit[bodies[polygon[inside]]])
    return float(depth.max(initial=0.0))


def _outline_of_each(
    walls: EdgeSurface, nodes: Array, bodies: Index, polygons: NDArray[np.object_]
) -> NDArray[np.object_]:
    """Return the walls of each body as lines, and all of its boundary where it has no walls."""
    order = np.argsort(walls.body, kind="stable")
    present, number = np.unique(walls.body[order], return_inverse=True)
    values = walls.basis.values(np.linspace(0, 1, chords(walls.basis.order) + 1))
    lines = shapely.multilinestrings(shapely.linestrings(values @ nodes[order]), indices=number)
    found = shapely.boundary(polygons)
    has_walls = np.isin(bodies, present)
    found[has_walls] = lines[np.searchsorted(present, bodies[has_walls])]
    return np.asarray(found)


def has_all_outlines(walls: EdgeSurface, body_count: int) -> bool:
    """Return whether the walls go all around each body."""
    return len(outlines(walls).shells) == body_count


def _wall_points(walls: EdgeSurface, nodes: Array) -> tuple[Array, Index]:
    """Return points of all walls, shape (points, 2), and the body of each."""
    count = 2 * walls.basis.order + 1
    values = walls.basis.values(np.linspace(0, 1, count))
    return (values @ nodes).reshape(-1, 2), np.repeat(walls.body, count)
