"""The lumens of cells as quadrilaterals that share the nodes of their walls.

A hexagon is three quadrangles that meet in its centre, where these are convex; each takes the wall's nodes along two of
its sides. In a regular one they are rhombi. Any other lumen is triangulated by Netgen between every second node of its
wall, and each triangle is three quadrilaterals around its centre, with the nodes between as middles of its sides.
"""

from __future__ import annotations

import numpy as np
from netgen import meshing, occ
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.boundaries import NETGEN_ERRORS
from ngcell.geometry.lattice import WALLS

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Corners of the hexagon that a quadrangle has opposite to the centre.
_TIPS = (1, 3, 5)
#: Netgen's largest size over the longest edge around a lumen, so that it divides none; how fast sizes grow.
_UNDIVIDED, _GROWTH = 1.01, 0.3
#: Distance as a share of the longest edge below which two nodes are one.
_SAME = 1e-7
#: Smallest sine of an angle of a quadrangle: flatter or sharper ones, and those that are not convex, are not meshed.
_SMALLEST_SINE = 0.1


def are_three_quadrangles(corners: Array) -> NDArray[np.bool_]:
    """Return which hexagons three convex quadrangles fill, shape (cells,); corners, counter-clockwise, (cells, 6, 2).
    """
    tips = np.array(_TIPS)
    centre = np.broadcast_to(corners.mean(1)[:, None], (len(corners), len(tips), 2))
    around = [corners[:, tips], corners[:, (tips + 1) % WALLS], centre, corners[:, tips - 1]]
    return np.asarray((smallest_sines(np.stack(around, axis=2)) > _SMALLEST_SINE).all(1))


def smallest_sines(quads: Array) -> Array:
    """Return the smallest sine of the angles of each quadrilateral, shape (...,); corners counter-clockwise, (..., 4,
    2). It is negative where one is not convex, or folded."""
    ahead = np.roll(quads, -1, axis=-2) - quads
    behind = np.roll(ahead, 1, axis=-2)
    area = behind[..., 0] * ahead[..., 1] - behind[..., 1] * ahead[..., 0]
    length = np.linalg.norm(ahead, axis=-1) * np.linalg.norm(behind, axis=-1)
    return np.asarray((area / np.maximum(length, np.finfo(float).tiny)).min(-1))


def lumen_quads(outlines: Array) -> tuple[Array, Index]:
    """Return the nodes inside each lumen and the quadrilaterals that fill it, the same in all.

    Parameters
    ----------
    outlines : array of float, shape (cells, 6 n, 2)
        Nodes along the inner wall of each cell, counter-clockwise, each n-th one a corner [length].

    Returns
    -------
    points : array of float, shape (cells, 3 n (n - 1) + 1, 2)
        Nodes inside [length].
    quads : array of int, shape (3 n**2, 4)
        Corners, counter-clockwise: numbers up to ``6 n`` are nodes of the outline, further ones those inside.
    """
    edges = outlines.shape[1] // WALLS
    number, first = _numbers(edges)
    quads = np.stack([number[:, :-1, :-1], number[:, :-1, 1:], number[:, 1:, 1:], number[:, 1:, :-1]], axis=-1)
    nodes = np.stack([_quadrangle(outlines, corner, edges) for corner in _TIPS], axis=1)
    return nodes.reshape(len(outlines), -1, 2)[:, first], quads.reshape(-1, 4)


def _numbers(edges: int) -> tuple[Index, Index]:
    """Return the number of each node of the three quadrangles, (3, n + 1, n + 1), and the first node of each number
    that is none of the outline.

    Nodes are told apart in a regular hexagon, by whole multiples of its corners 0 and 2.
    """
    steps = np.arange(edges + 1)
    back, forth = np.meshgrid(edges - steps, edges - steps, indexing="ij")
    corner = np.array([(1, 0), (1, 1), (0, 1), (-1, 0), (-1, -1), (0, -1)])
    ahead = np.roll(corner, -1, axis=0) - corner
    outline = edges * corner[:, None] + ahead[:, None] * steps[:-1, None]
    quadrangles = [
        forth[..., None] * corner[tip - 1] + back[..., None] * corner[(tip + 1) % WALLS] for tip in _TIPS
    ]
    places = np.concatenate([outline.reshape(-1, 2), np.reshape(quadrangles, (-1, 2))])
    _, first, number = np.unique(places, axis=0, return_index=True, return_inverse=True)
    # Number distinct places in the order of their first appearance, so that the outline keeps its numbers.
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    count = WALLS * edges
    return rank[number.ravel()][count:].reshape(3, edges + 1, edges + 1), np.sort(first)[count:] - count


def _quadrangle(outlines: Array, corner: int, edges: int) -> Array:
    """Return the nodes of the quadrangle at a corner of each cell: backwards and forwards along the wall, shape
    (cells, n + 1, n + 1, 2).

    Nodes stand at shares of the way to the next corners: those of the wall at the wall, and the means of all sides at
    the lines that quadrangles share.
    """
    steps = np.arange(edges + 1)
    at, count = corner * edges, outlines.shape[1]
    back, forth = outlines[:, at - steps], outlines[:, (at + steps) % count]
    tip, centre = back[:, :1], outlines[:, ::edges].mean(1)[:, None, None]
    own = [np.linalg.norm(way - tip, axis=2) / np.linalg.norm(way[:, -1:] - tip, axis=2) for way in (back, forth)]
    corners = outlines[:, ::edges, None]
    side = np.linalg.norm(outlines.reshape(len(outlines), WALLS, edges, 2) - corners, axis=3)
    side /= np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=3)
    mean = np.column_stack([side.mean(1), np.ones(len(side))])
    one = own[0][:, :, None] * (1 - mean[:, None]) + mean[:, :, None] * mean[:, None]
    two = own[1][:, None] * (1 - mean[:, :, None]) + mean[:, None] * mean[:, :, None]
    one, two = one[..., None], two[..., None]
    ends = tip[:, :, None], back[:, -1][:, None, None], forth[:, -1][:, None, None]
    return np.asarray(
        (1 - one) * (1 - two) * ends[0] + one * (1 - two) * ends[1] + (1 - one) * two * ends[2] + one * two * centre
    )


def any_lumen_quads(outline: Array) -> tuple[Array, Index]:
    """Return the nodes inside a lumen of any shape and the quadrilaterals that fill it.

    Parameters
    ----------
    outline : array of float, shape (2 n, 2)
        Nodes along the inner wall, counter-clockwise; every corner is one with an even number [length].

    Returns
    -------
    points : array of float, shape (points, 2)
        Nodes inside [length].
    quads : array of int, shape (quads, 4)
        Corners, counter-clockwise: numbers up to ``2 n`` are nodes of the outline, further ones those inside.

    Raises
    ------
    GeometryError
        If Netgen cannot mesh it.
    """
    places, triangles = _triangulated(outline[::2])
    count = len(outline) // 2
    side = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    sides, number = np.unique(side, axis=0, return_inverse=True)
    on_wall = np.sort(np.column_stack([np.arange(count), (np.arange(count) + 1) % count]), axis=1)
    known = np.full(len(sides), -1)
    known[np.searchsorted(sides @ [len(places), 1], on_wall @ [len(places), 1])] = 2 * np.arange(count) + 1
    # Nodes inside: those of triangles, middles of their sides, and their centres.
    inner = np.flatnonzero(known < 0)
    node = np.concatenate([2 * np.arange(count), 2 * count + np.arange(len(places) - count)])
    first = 2 * count + len(places) - count
    known[inner] = first + np.arange(len(inner))
    centre = first + len(inner) + np.arange(len(triangles))
    middle, corner = known[number.ravel()].reshape(-1, 3), node[triangles]
    quads = [np.column_stack([corner[:, k], middle[:, k], centre, middle[:, k - 1]]) for k in range(3)]
    points = [places[count:], places[sides[inner]].mean(1)]
    # Of three middles, not of corners: those on the wall lie off the chord where the wall is round.
    points.append(np.concatenate([outline, *points])[middle].mean(1))
    return np.concatenate(points), np.concatenate(quads)


def _triangulated(outline: Array) -> tuple[Array, Index]:
    """Return places and triangles of a polygon, counter-clockwise; its corners come first, and no side is divided."""
    corners = [occ.Pnt(x, y, 0) for x, y in outline]
    wire = occ.Wire([occ.Segment(*ends) for ends in zip(corners, [*corners[1:], corners[0]], strict=True)])
    longest = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).max()
    how = meshing.MeshingParameters(maxh=_UNDIVIDED * longest, grading=_GROWTH, segmentsperedge=0.01)
    try:
        mesh = occ.OCCGeometry(occ.Face(wire), dim=2).GenerateMesh(mp=how)
    except NETGEN_ERRORS as error:
        raise GeometryError(f"Netgen cannot mesh a lumen about {outline.mean(0)} ({error})") from error
    places = np.asarray(mesh.Coordinates()[:, :2])
    nearest = np.linalg.norm(places[:, None] - outline, axis=2)
    if len(mesh.Elements1D()) != len(outline) or nearest.min(0).max() > _SAME * longest:
        raise GeometryError(f"Netgen divides the wall of a lumen about {outline.mean(0)}; allowed: hollow cells")
    order = np.concatenate([nearest.argmin(0), np.setdiff1d(np.arange(len(places)), nearest.argmin(0))])
    triangles = np.argsort(order)[mesh.Elements2D().NumPy()["nodes"][:, :3].astype(np.int64) - 1]
    places = places[order]
    one, two = (places[triangles[:, k]] - places[triangles[:, 0]] for k in (1, 2))
    clockwise = one[:, 0] * two[:, 1] < one[:, 1] * two[:, 0]
    triangles[clockwise] = triangles[clockwise, ::-1]
    return places, triangles
