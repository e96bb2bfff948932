"""A planar mesh of quadrilaterals as one layer of quadratic hexahedra, each of 20 nodes.

An element of order p becomes n x n quadratic ones, with n = p/2 rounded up, whose nodes lie on the curved element. The
layer is as thick as the thinnest wall, and plane strain is left to supports: no node moves across it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.near import components, near_pairs

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Nodes of a body nearer to each other than this share of the extent are one.
_SAME = 1e-9
#: Corners of NGSolve's reference quadrilateral.
_CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))


@dataclass(frozen=True, eq=False)
class Layer:
    """Nodes and elements; numbers of nodes start at 0.

    Attributes
    ----------
    nodes : array of float, shape (nodes, 3)
        Places at rest [length].
    elements : array of int, shape (elements, 20)
        Nodes of each element.
    parent : array of int, shape (elements,)
        Element of the planar mesh that each is part of.
    faces : list of array of int, each of shape (n, 8)
        Lateral faces on each boundary edge of the planar mesh, outwards.
    thickness : float
        Thickness of the layer [length].
    """

    nodes: Array
    elements: Index
    parent: Index
    faces: list[Index]
    thickness: float

    def on(self, edges: Index) -> Index:
        """Return the nodes on boundary edges, in order."""
        return np.unique(np.concatenate([self.faces[edge].ravel() for edge in edges]))


@dataclass(frozen=True)
class _Patch:
    """The lattice of one quadrilateral: numbers of its nodes."""

    parts: int
    node: dict[tuple[int, int], int]

    def quadratic(self) -> Iterator[list[int]]:
        """Yield corners, then middles of sides, of each quadratic element."""
        for i in range(0, 2 * self.parts, 2):
            for j in range(0, 2 * self.parts, 2):
                corners = ((i, j), (i + 2, j), (i + 2, j + 2), (i, j + 2))
                middles = ((i + 1, j), (i + 2, j + 1), (i + 1, j + 2), (i, j + 1))
                yield [self.node[place] for place in (*corners, *middles)]

    def side(self, one: int, two: int) -> list[int]:
        """Return the nodes along the side between two corners."""
        (x0, y0), (x1, y1), count = _CORNERS[one], _CORNERS[two], 2 * self.parts
        return [self.node[x0 * (count - k) + x1 * k, y0 * (count - k) + y1 * k] for k in range(count + 1)]


def layer_of(bodies: BodyMesh, order: int) -> Layer:
    """Return the layer of a planar mesh whose displacements have this order."""
    mesh, parts = bodies.mesh, -(-order // 2)
    patches: list[_Patch] = []
    places: list[Array] = []
    body: list[int] = []
    for element, owner in zip(mesh.Elements(ngsolve.VOL), bodies.body_of_element, strict=True):
        patch, found = _patch(mesh, element, parts, len(body))
        patches.append(patch)
        places += found
        body += [int(owner)] * len(found)
    node, flat = _merged(np.array(places), np.array(body))
    rings = np.array([_counter_clockwise(node[ring], flat) for patch in patches for ring in patch.quadratic()])
    parent = np.repeat(np.arange(len(patches)), parts * parts)
    return _extruded(flat, rings, parent, _sides(mesh, patches, node, flat), float(bodies.thickness))


def _patch(mesh: ngsolve.Mesh, element: ngsolve.comp.Ngs_Element, parts: int, first: int) -> tuple[_Patch, list[Array]]:
    lattice = list(product(range(2 * parts + 1), range(2 * parts + 1)))
    transformation = mesh.GetTrafo(element)
    places = [np.array(transformation(i / (2 * parts), j / (2 * parts)).point) for i, j in lattice]
    return _Patch(parts, {place: first + number for number, place in enumerate(lattice)}), places


def _merged(places: Array, body: Index) -> tuple[Index, Array]:
    """Return the number of each place among those that differ, or are of different bodies, and these places."""
    one, two = near_pairs(places, _SAME * float(np.ptp(places, axis=0).max()))
    same = body[one] == body[two]
    number = components(len(places), one[same], two[same])
    _, first = np.unique(number, return_index=True)
    return number, places[first]


def _counter_clockwise(ring: Index, flat: Array) -> Index:
    """Return corners and middles of sides in counter-clockwise order."""
    x, y = flat[ring[:4]].T
    if (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() > 0:
        return ring
    return ring[[3, 2, 1, 0, 6, 5, 4, 7]]


def _sides(mesh: ngsolve.Mesh, patches: list[_Patch], node: Index, flat: Array) -> list[Index]:
    """Return the nodes along each boundary edge, with its body on the left."""
    sides = []
    for edge in mesh.Elements(ngsolve.BND):
        owner = mesh[edge.edges[0]].elements[0]
        vertices = [vertex.nr for vertex in mesh[owner].vertices]
        one, two = (vertices.index(vertex.nr) for vertex in edge.vertices)
        if (two - one) % len(vertices) != 1:
            one, two = two, one
        along = node[patches[owner.nr].side(one, two)]
        centre = np.mean([mesh[vertex].point for vertex in mesh[owner].vertices], axis=0)
        (dx, dy), (ax, ay) = flat[along[-1]] - flat[along[0]], centre - flat[along[0]]
        sides.append(along if dx * ay - dy * ax > 0 else along[::-1])
    return sides


def _extruded(flat: Array, rings: Index, parent: Index, sides: list[Index], thickness: float) -> Layer:
    """Return the layer over planar quadratic elements: nodes below, above, and half-way up over corners."""
    used, corners = np.unique(rings), np.unique(rings[:, :4])
    below, half_way = np.full(len(flat), -1), np.full(len(flat), -1)
    below[used] = np.arange(len(used))
    half_way[corners] = 2 * len(used) + np.arange(len(corners))
    above = below + len(used)
    heights = np.repeat([0.0, thickness, thickness / 2], [len(used), len(used), len(corners)])
    nodes = np.column_stack([flat[np.concatenate([used, used, corners])], heights])
    ends, middles = rings[:, :4], rings[:, 4:]
    elements = np.column_stack([below[ends], above[ends], below[middles], above[middles], half_way[ends]])
    return Layer(nodes, elements, parent, [_faces(side, below, above, half_way) for side in sides], thickness)


def _faces(side: Index, below: Index, above: Index, half_way: Index) -> Index:
    """Return quadrilaterals of eight nodes along a side with the body on its left: seen from outside."""
    start, middle, end = side[:-2:2], side[1::2], side[2::2]
    corners = [below[start], below[end], above[end], above[start]]
    return np.column_stack([*corners, below[middle], half_way[end], above[middle], half_way[start]])
