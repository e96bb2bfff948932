"""Where walls of two bodies face each other in three dimensions: polygons in which two facets lie over each other.

The corners of the secondary facet are projected along the normal of the primary one onto the plane through its corners,
and the one polygon is clipped by the sides of the other (Sutherland & Hodgman 1974, doi:10.1145/360767.360802). Shape
functions of both facets are smooth on what is left, and polygons of neighbouring facets have common sides: flat walls
are covered once, whatever the meshes, which is the condition of the patch test. Sides count as straight: those of
curved facets bend little in the plane, and a rule across them is that much less exact.

A polygon falls into quadrilaterals with a common corner, the last one possibly a triangle, with a Gauss rule on each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.options import DEFAULT_OPTIONS
from ngcell.contact.pairing.closest_on_facets import closest_points
from ngcell.contact.pairing.near import Reach, facing, reach_between
from ngcell.contact.pairing.pairs import ContactPairs, feet
from ngcell.contact.surface.facets import FacetSurface

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of a facet's size by which corners may lie beyond a side and still count as on it, and share of its area below
#: which a polygon is left out.
_ON_SIDE, _SLIVER = 1e-10, 1e-9
_INVERSE_STEPS = 6


@dataclass(frozen=True, eq=False)
class IntersectionPolygons:
    """Polygons in which facets lie over other facets; all arrays have one entry a polygon.

    Attributes
    ----------
    primary, secondary : array of int
        The facet that is integrated over, and the one it faces.
    plane : array of float, shape (n, corners, 2)
        Corners of the primary facet in its plane [length].
    polygon : array of float, shape (n, most corners, 2)
        Corners of the polygon, anticlockwise, the last one repeated where there are fewer.
    """

    primary: Index
    secondary: Index
    plane: Array
    polygon: Array


def find_intersections(
    walls: FacetSurface, nodes: Array, primary: Index, secondary: Index, limit: float = DEFAULT_OPTIONS.facing
) -> IntersectionPolygons:
    """Return the polygons of pairs of facets at deformed nodes, shape (facets, nodes, 3) [length].

    Those whose normals multiply to `limit` or more do not face each other, and have none.
    """
    opposed = facing(walls, nodes, primary, secondary, limit)
    primary, secondary = primary[opposed], secondary[opposed]
    corner = nodes[:, walls.basis.corner_nodes]
    frame = _frames(corner, walls.chord_normals(nodes))[primary]
    origin = corner[primary, :1]
    plane, polygon = (np.einsum("pcd,pad->pca", corner[facets] - origin, frame) for facets in (primary, secondary))
    clip, polygon = _anticlockwise(plane), _anticlockwise(polygon)
    size = np.sqrt(_area(clip))
    for side in range(clip.shape[1]):
        polygon = _clipped(polygon, clip[:, side], clip[:, (side + 1) % clip.shape[1]], _ON_SIDE * size)
    kept = _area(polygon) > _SLIVER * size**2
    return IntersectionPolygons(primary[kept], secondary[kept], plane[kept], polygon[kept])


def intersection_pairs(
    walls: FacetSurface, nodes: Array, intersections: IntersectionPolygons, reach: Reach
) -> ContactPairs:
    """Return the Gauss points of all polygons that come nearer than `reach` [length], with the closest points there."""
    place, share, piece = _points(intersections.polygon, walls.basis.order + 2)
    primary, secondary = intersections.primary[piece], intersections.secondary[piece]
    own, shrunk = _coordinates(walls, intersections.plane[piece], place)
    weight = share / shrunk * walls.rest_measure(primary, own)
    xi, distance = closest_points(walls, nodes, secondary, walls.places(primary, own, nodes))
    nearest = np.full(len(intersections.primary), np.inf)
    np.minimum.at(nearest, piece, distance)
    near = np.flatnonzero(nearest[piece] < reach_between(walls, reach, primary, secondary))
    near = near[np.argsort(primary[near], kind="stable")]
    return feet(primary[near], own[near], weight[near], secondary[near], xi[near])


def _frames(corner: Array, normal: Array) -> Array:
    """Return two unit vectors in the plane of each facet, shape (facets, 2, 3); normal is their cross product."""
    one = corner[:, 1] - corner[:, 0]
    one = one - np.einsum("ed,ed->e", one, normal)[:, None] * normal
    one /= np.linalg.norm(one, axis=1)[:, None]
    return np.stack([one, np.cross(normal, one)], axis=1)


def _area(polygon: Array) -> Array:
    """Return the areas of polygons, positive where they are anticlockwise."""
    ahead = np.roll(polygon, -1, axis=1)
    return np.asarray((polygon[..., 0] * ahead[..., 1] - polygon[..., 1] * ahead[..., 0]).sum(1) / 2)


def _anticlockwise(polygon: Array) -> Array:
    return np.where(_area(polygon)[:, None, None] < 0, polygon[:, ::-1], polygon)


def _clipped(polygon: Array, start: Array, end: Array, tolerance: Array) -> Array:
    """Return what of convex polygons lies to the left of lines, with room for a corner more; nothing is a point."""
    along = end - start
    along = along / np.linalg.norm(along, axis=1)[:, None]
    away = polygon - start[:, None]
    height = along[:, None, 0] * away[..., 1] - along[:, None, 1] * away[..., 0]
    ahead, rise = np.roll(polygon, -1, axis=1), np.roll(height, -1, axis=1)
    inside = np.asarray(height >= -tolerance[:, None])
    crosses: NDArray[np.bool_] = np.not_equal(inside, np.roll(inside, -1, axis=1))
    share = np.clip(np.divide(height, height - rise, out=np.zeros_like(height), where=crosses), 0, 1)
    crossing = polygon + share[..., None] * (ahead - polygon)
    count, most = len(polygon), polygon.shape[1]
    corners = np.stack([polygon, crossing], axis=2).reshape(count, 2 * most, 2)
    taken = np.stack([inside, crosses], axis=2).reshape(count, 2 * most)
    order = np.argsort(~taken, axis=1, kind="stable")
    number = np.minimum(np.arange(most + 1), np.maximum(taken.sum(1) - 1, 0)[:, None])
    kept = np.take_along_axis(corners, np.take_along_axis(order, number, axis=1)[..., None], axis=1)
    return np.where(np.any(taken, axis=1)[:, None, None], kept, kept[:, :1])


def _points(polygon: Array, count: int) -> tuple[Array, Array, Index]:
    """Return Gauss points of polygons, `count` squared on each quadrilateral, their weights, and their polygon."""
    most = polygon.shape[1]
    first = np.arange(1, most - 1, 2)
    fan = np.column_stack([0 * first, first, first + 1, np.minimum(first + 2, most - 1)])
    quad = polygon[:, fan].reshape(-1, 4, 2)
    piece = np.repeat(np.arange(len(polygon)), len(fan))
    solid = np.flatnonzero(_area(quad) > _SLIVER * _area(polygon)[piece])
    quad, piece = quad[solid], piece[solid]
    at, share = np.polynomial.legendre.leggauss(count)
    x, y = (axis.ravel() for axis in np.meshgrid((at + 1) / 2, (at + 1) / 2, indexing="ij"))
    place, jacobian = _bilinear(np.repeat(quad, len(x), axis=0), np.tile(np.column_stack([x, y]), (len(quad), 1)))
    weight = np.tile(np.outer(share, share).ravel() / 4, len(quad)) * np.linalg.det(jacobian)
    return place, weight, np.repeat(piece, len(x))


def _coordinates(walls: FacetSurface, plane: Array, place: Array) -> tuple[Array, Array]:
    """Return the coordinates of points in facets with these corners, (n, 2), and the area for a unit of coordinates."""
    xi = np.tile(walls.basis.centre, (len(place), 1))
    map_ = _bilinear if plane.shape[1] == 4 else _affine
    for _ in range(_INVERSE_STEPS if plane.shape[1] == 4 else 1):
        value, jacobian = map_(plane, xi)
        xi = xi + np.linalg.solve(jacobian, (place - value)[..., None])[..., 0]
    return xi, np.abs(np.linalg.det(map_(plane, xi)[1]))


def _bilinear(corner: Array, xi: Array) -> tuple[Array, Array]:
    """Return points of quadrilaterals, (n, 2), and their derivatives by the coordinates, (n, 2, 2)."""
    x, y = xi.T
    shape = np.stack([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], axis=1)
    slope = np.stack([np.stack([y - 1, 1 - y, y, -y], axis=1), np.stack([x - 1, -x, x, 1 - x], axis=1)], axis=2)
    return np.einsum("pc,pcd->pd", shape, corner), np.einsum("pca,pcd->pda", slope, corner)


def _affine(corner: Array, xi: Array) -> tuple[Array, Array]:
    """Return the same of triangles."""
    jacobian = np.stack([corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]], axis=2)
    return corner[:, 0] + np.einsum("pda,pa->pd", jacobian, xi), jacobian
