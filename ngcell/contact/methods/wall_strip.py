"""A mesh of nothing but the walls, for NGSolve to search: one triangle behind each edge, and regions by colour.

NGSolve's contact boundary searches between two regions of a mesh and takes the nearest point of the other one. So that
no point is paired with its own body, or loses one neighbour to another where three meet, bodies that come near each
other have different colours, and each colour is a region: a few contact boundaries do for any number of bodies. The
mesh of bodies has regions of its own, for supports and loads; this one is made from walls alone, and made anew when
bodies of one colour come near each other.

It holds every wall twice: as a whole, to be found, and as short edges around the quadrature points of the walls, to be
integrated over with one point in the middle of each. NGSolve offers Gauss rules only; the tip of a sharp corner, which
presses first and deepest, would sink in between their points.
"""

from __future__ import annotations

import netgen.meshing
import ngsolve
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.sampling import sampled

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Length of a short edge, as a share of its wall.
SHORT = 0.1


def coloured(body_count: int, one: Index, two: Index) -> Index:
    """Return a colour of each body, shape (bodies,), such that `one` and `two` always differ: the first one free."""
    near: list[set[int]] = [set() for _ in range(body_count)]
    for a, b in zip(one.tolist(), two.tolist(), strict=True):
        near[a].add(b)
        near[b].add(a)
    colours = np.full(body_count, -1)
    for body in range(body_count):
        taken = {int(colours[other]) for other in near[body]}
        colours[body] = next(colour for colour in range(body_count) if colour not in taken)
    return colours


class WallStrip:
    """The mesh, its spaces, and how they follow from the unknowns of bodies.

    Edges are straight, on the chords of walls at rest: first all walls, then their quadrature points.

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    colours : array of int, shape (bodies,)
        Colours of bodies.

    Attributes
    ----------
    mesh : ngsolve.Mesh
        Its boundaries are ``wall0``, ``wall1``, ... and ``point0``, ``point1``, ... by colour.
    vector, scalar : ngsolve.VectorH1, ngsolve.H1
        Positions relative to the chords, and one component of them.
    facet : array of int, shape (edges,)
        Wall of each edge.
    colour_count : int
        Number of colours.
    lengths : array of float, shape (edges,)
        Lengths of edges [length].
    """

    def __init__(self, walls: EdgeSurface, colours: Index) -> None:
        self._walls, self.colour_count = walls, int(colours.max()) + 1
        points = walls.quadrature
        self.facet = np.concatenate([np.arange(walls.facet_count), points.facet])
        middle = np.concatenate([np.full(walls.facet_count, 0.5), points.xi])
        self._width = np.where(np.arange(len(middle)) < walls.facet_count, 1.0, SHORT)
        self._first = middle - self._width / 2
        chord = walls.rest[:, -1] - walls.rest[:, 0]
        self.lengths = self._width * np.linalg.norm(chord, axis=1)[self.facet]
        start = walls.rest[self.facet, 0] + self._first[:, None] * chord[self.facet]
        end = start + self._width[:, None] * chord[self.facet]
        region = colours[walls.body[self.facet]] + self.colour_count * (np.arange(len(middle)) >= walls.facet_count)
        normal = walls.chord_normals(walls.rest)[self.facet]
        self.mesh = ngsolve.Mesh(
            _mesh(np.stack([start, end], axis=1), normal, walls.side[self.facet], region, self._names)
        )
        self.vector, self.scalar = (make(self.mesh, order=walls.basis.order) for make in (ngsolve.VectorH1, ngsolve.H1))
        self._sample(walls)

    @property
    def _names(self) -> list[str]:
        return [f"{kind}{colour}" for kind in ("wall", "point") for colour in range(self.colour_count)]

    def _sample(self, walls: EdgeSurface) -> None:
        """Find the unknowns of edges, and how they follow from values at the nodes of walls."""
        elements = list(self.mesh.Boundaries(".*").Elements())
        dofs, nodal = sampled(self.scalar, elements, walls.basis)
        # Which end has the coordinate 0, of the element and of the wall: point 3 e of the mesh is the start of edge e.
        first = dofs[np.arange(len(elements)), np.abs(nodal[:, 0]).argmax(1)]
        order = np.argsort(first // 3)
        inverse = np.linalg.inv(nodal)
        backward = first % 3 == 1
        inverse[backward] = inverse[backward][:, :, ::-1]
        nodes = self._first[:, None] + self._width[:, None] * walls.basis.nodes
        self._dofs, self._from_walls = dofs[order], inverse[order] @ walls.basis.values(nodes)

    def relative(self, nodes: Array) -> Array:
        """Return deformed nodes of walls, shape (facets, nodes, 2), relative to those on the chords at rest."""
        chord = self._walls.rest[:, -1] - self._walls.rest[:, 0]
        along = self._walls.basis.nodes[None, :, None] * chord[:, None]
        return np.asarray(nodes - self._walls.rest[:, :1] - along)

    def put(self, field: ngsolve.GridFunction, nodes: Array) -> None:
        """Let a vector field have these values at the walls' nodes, shape (facets, nodes, 2)."""
        values = field.vec.FV().NumPy().reshape(2, -1)
        values[:, self._dofs] = np.einsum("eij,ejd->dei", self._from_walls, nodes[self.facet])

    def linear(self, start: Array, end: Array) -> ngsolve.GridFunction:
        """Return a scalar field that is linear on each edge, from values at its start and end, shape (edges,)."""
        field = ngsolve.GridFunction(self.scalar)
        field.vec.FV().NumPy()[: 3 * len(start)] = np.stack([start, end, (start + end) / 2], axis=1).ravel()
        return field

    def map(self, columns: int) -> sparse.csr_array:
        """Return the derivatives of the unknowns of `vector` by those of bodies, shape (strip's, 2 * columns)."""
        blocks = self._from_walls @ self._walls.nodal[self.facet]
        rows = np.repeat(self._dofs, blocks.shape[2], axis=1).ravel()
        across = np.tile(self._walls.dofs[self.facet], (1, blocks.shape[1])).ravel()
        one = sparse.csr_array((blocks.ravel(), (rows, across)), shape=(self.scalar.ndof, columns))
        return sparse.block_diag([one, one], format="csr")


def _mesh(ends: Array, normal: Array, side: Array, region: Index, names: list[str]) -> netgen.meshing.Mesh:
    """Return the mesh: points 3 e and 3 e + 1 are the ends of edge e, point 3 e + 2 lies behind it."""
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)[:, None]
    points = np.concatenate([ends, (ends.mean(1) - length / 2 * normal)[:, None]], axis=1).reshape(-1, 2)
    # Netgen's edges have their body on the left.
    corner = 3 * np.arange(len(ends))[:, None] + np.where(side[:, None] > 0, (0, 1, 2), (1, 0, 2))
    mesh = netgen.meshing.Mesh(dim=2)
    mesh.AddPoints(np.column_stack([points, np.zeros(len(points))]))
    strip = mesh.AddRegion("strip", dim=2)
    mesh.AddElements(dim=2, index=strip, data=np.ascontiguousarray(corner, dtype=np.int32), base=0)
    for number, name in enumerate(names):
        mine = np.ascontiguousarray(corner[region == number, :2], dtype=np.int32)
        mesh.AddElements(dim=1, index=mesh.AddRegion(name, dim=1), data=mine, base=0)
    return mesh
