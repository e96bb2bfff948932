"""How deep solid bodies lie inside each other, found from their surfaces alone.

As in the plane (`ngcell.results.outline_overlap`) this shares nothing with the contact search: the whole surface of
each body, walls or not, becomes a closed polyhedron, and points of every wall are tested against the polyhedra of all
other bodies. A polyhedron follows each facet by triangles, so a depth is right to about the facet's sagitta over the
square of their number along a side; where points seem to lie deepest, the polyhedron is made finer. Centres of elements
are tested as well: where two bodies are at the same place, no wall point is inside the other. A solid that passes
through itself is not seen here.
"""

from __future__ import annotations

from dataclasses import replace

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.facets import FacetSurface, find_facets
from ngcell.geometry.enclosure import winding_numbers
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.bernstein import FACTORS
from ngcell.results.places import element_type, map_points

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Triangles along a side of one curved facet: where points are looked for, and near the deepest of those found.
_PIECES, _FINE_PIECES = 4, 16
#: Most distances at once.
_CHUNK = 500_000


def deepest_overlap_of_solids(
    walls: FacetSurface, space: DisplacementSpace, positions: Array, unit: Array | None = None
) -> float:
    """Return the largest depth, >= 0, by which a wall point of a body lies inside another body.

    Parameters
    ----------
    walls : FacetSurface
        The walls, whose quadrature points and nodes are tested.
    space : DisplacementSpace
        The unknowns of the bodies.
    positions : array of float, shape (3, scalar unknowns)
        Deformed positions as unknowns [length].
    unit : array of float, shape (bodies,), optional
        A length of each body; a depth is taken over the smaller one of the two. By default it is a length.
    """
    unit = np.ones(space.body_count) if unit is None else unit
    xi = np.concatenate([walls.quadrature_points, walls.basis.nodes])
    centre = _centres(space, positions)
    point = np.concatenate([(walls.basis.values(xi) @ walls.nodes(positions)).reshape(-1, 3), centre])
    owner = np.concatenate([np.repeat(walls.body, len(xi)), space.bodies.body_of_element])
    surface = find_facets(replace(space.bodies, wall_names=".*"), space.scalar, space.rest)
    nodes, found = surface.nodes(positions), []
    for number in np.unique(surface.body) if len(point) else ():
        mine = np.flatnonzero(surface.body == number)
        triangles = _triangles(surface, nodes, mine, _PIECES)
        inside = np.flatnonzero(owner != number)
        inside = inside[_is_inside(point[inside], triangles)]
        over = np.minimum(unit[number], unit[owner[inside]])
        found.append((mine, point[inside], over, _distances(point[inside], triangles) / over))
    deepest = max((float(share.max(initial=0.0)) for *_, share in found), default=0.0)
    shallow = max((float(share[share <= deepest / 2].max(initial=0.0)) for *_, share in found), default=0.0)
    deep = ((mine, inside[share > deepest / 2], over[share > deepest / 2]) for mine, inside, over, share in found)
    return max([shallow, *(_finer_share(surface, nodes, *each, deepest) for each in deep)])


def _finer_share(surface: FacetSurface, nodes: Array, mine: Index, point: Array, over: Array, deepest: float) -> float:
    """Return the largest depth of points, over a length of each, in a body whose facets near the points have finer
    triangles."""
    if not len(point):
        return 0.0
    coarse = _triangles(surface, nodes, mine, _PIECES)
    away = np.concatenate([_to_triangles(point[[at], None], coarse) for at in range(len(point))]).min(0)
    near = away.reshape(len(mine), -1).min(1) <= 2 * deepest * over.max()
    parts = [_triangles(surface, nodes, mine[near], _FINE_PIECES), _triangles(surface, nodes, mine[~near], _PIECES)]
    triangles = np.concatenate(parts)
    inside = _is_inside(point, triangles)
    return float((_distances(point[inside], triangles) / over[inside]).max(initial=0.0))


def _centres(space: DisplacementSpace, positions: Array) -> Array:
    """Return the deformed centres of all elements, shape (elements, 3)."""
    kind = element_type(space)
    centre = np.concatenate([np.full(dimension, 1 / (dimension + 1)) for dimension in FACTORS[kind]])
    places = map_points(space, kind, centre[None])
    rest = ngsolve.CF((ngsolve.x, ngsolve.y, ngsolve.z))(places)
    return np.asarray(rest + space.function((positions - space.rest).ravel())(places))


def _is_inside(point: Array, triangles: Array) -> NDArray[np.bool_]:
    """Return which points are inside a closed surface."""
    low, high = triangles.min((0, 1)), triangles.max((0, 1))
    is_inside = (point > low).all(1) & (point < high).all(1)
    if is_inside.any():
        is_inside[is_inside] = winding_numbers(point[is_inside], triangles) > 0.5
    return np.asarray(is_inside)


def _triangles(surface: FacetSurface, nodes: Array, chosen: Index, pieces: int) -> Array:
    """Return the triangles that stand for chosen facets, (n, 3, 3), with their outer side out."""
    pieces = 1 if surface.basis.order == 1 and surface.basis.corner_count == 3 else pieces
    lattice = np.array([(i, j) for i in range(pieces) for j in range(pieces)])
    lower = lattice[:, None] + [(0, 0), (1, 0), (0, 1)]
    upper = lattice[:, None] + [(1, 1), (0, 1), (1, 0)]
    if surface.basis.corner_count == 3:
        lower, upper = lower[lattice.sum(1) < pieces], upper[lattice.sum(1) < pieces - 1]
    xi = np.concatenate([lower, upper]) / pieces
    corners = np.einsum("tci,fid->ftcd", surface.basis.values(xi), nodes[chosen])
    corners = np.where(surface.side[chosen, None, None, None] > 0, corners, corners[:, :, ::-1])
    return np.asarray(corners.reshape(-1, 3, 3))


def _distances(points: Array, triangles: Array) -> Array:
    """Return the distance of each point to the nearest triangle [length], shape (points,)."""
    count = max(1, _CHUNK // max(len(triangles), 1))
    return np.concatenate(
        [np.zeros(0)]
        + [_to_triangles(points[at : at + count, None], triangles).min(1) for at in range(0, len(points), count)]
    )


def _to_triangles(point: Array, triangles: Array) -> Array:
    """Return the distances of all points, (n, 1, 3), to all triangles: to their planes, or to their sides."""
    best = np.full((len(point), len(triangles)), np.inf)
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    normal = np.cross(first, second)
    square = np.maximum((normal**2).sum(1), np.finfo(float).tiny)
    away = point - triangles[:, 0]
    share_two = (np.cross(first, away) * normal).sum(2) / square
    share_one = (np.cross(away, second) * normal).sum(2) / square
    over = (share_one >= 0) & (share_two >= 0) & (share_one + share_two <= 1)
    best[over] = (np.abs((away * normal).sum(2)) / np.sqrt(square))[over]
    for corner in range(3):
        start, side = triangles[:, corner], triangles[:, (corner + 1) % 3] - triangles[:, corner]
        along = np.clip(((point - start) * side).sum(2) / np.maximum((side**2).sum(1), np.finfo(float).tiny), 0, 1)
        best = np.minimum(best, np.linalg.norm(point - start - along[..., None] * side, axis=2))
    return best
