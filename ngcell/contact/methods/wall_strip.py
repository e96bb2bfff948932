"""A mesh of nothing but the walls: one triangle behind each edge, whose regions are colours of bodies.

NGSolve's contact boundary searches between two regions of a mesh and takes the nearest point of the other one. So that
no point is paired with its own body, or loses one neighbour to another where three meet, bodies that come near each
other have different colours, and each colour is a region: a few contact boundaries do for any number of bodies. The
mesh of bodies has regions of its own, for supports and loads; this one is made from walls alone, and made anew when
bodies of one colour come near each other.
"""

from __future__ import annotations

from functools import cached_property

import netgen.meshing
import ngsolve
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.sampling import sampled

Array = NDArray[np.float64]
Index = NDArray[np.int64]


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

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    colours : array of int, shape (bodies,)
        Colours of bodies.

    Attributes
    ----------
    mesh : ngsolve.Mesh
        Straight edges on the chords of walls at rest, each with a triangle of its own; boundaries ``colour0``, ...
    vector, scalar : ngsolve.VectorH1, ngsolve.H1
        Positions relative to the chords, and one component of them.
    facet : array of int, shape (edges,)
        Wall of each boundary element.
    backward : array of bool, shape (edges,)
        Whether its coordinate runs against that of the wall.
    """

    def __init__(self, walls: EdgeSurface, colours: Index) -> None:
        self._walls, self._colours = walls, colours
        self.mesh = ngsolve.Mesh(_triangles(walls, colours))
        order = walls.basis.order
        self.vector, self.scalar = ngsolve.VectorH1(self.mesh, order=order), ngsolve.H1(self.mesh, order=order)
        elements = list(self.mesh.Boundaries(".*").Elements())
        self._ends = np.array([[vertex.nr for vertex in element.vertices] for element in elements])
        self.facet = self._ends[:, 0] // 3
        self._dofs, self.nodal = sampled(self.scalar, elements, walls.basis)
        # Which end has the coordinate 0, of the element and of the wall: point 3 f of the mesh is the wall's start.
        first = self._dofs[np.arange(len(elements)), np.abs(self.nodal[:, 0]).argmax(1)]
        self.backward = first % 3 == 1
        self._inverse = np.linalg.inv(self.nodal)
        self._inverse[self.backward] = self._inverse[self.backward][:, :, ::-1]

    @property
    def colour_count(self) -> int:
        """Number of colours."""
        return int(self._colours.max()) + 1

    @cached_property
    def lengths(self) -> Array:
        """Lengths of the chords at rest [length], shape (facets,)."""
        return np.asarray(np.linalg.norm(self._chord, axis=1))

    @property
    def _chord(self) -> Array:
        return np.asarray(self._walls.rest[:, -1] - self._walls.rest[:, 0])

    def relative(self, nodes: Array) -> Array:
        """Return deformed nodes of walls, shape (facets, nodes, 2), relative to those on the chords at rest."""
        along = self._walls.basis.nodes[None, :, None] * self._chord[:, None]
        return np.asarray(nodes - self._walls.rest[:, :1] - along)

    def field(self) -> ngsolve.GridFunction:
        """Return a vector field, zero so far."""
        return ngsolve.GridFunction(self.vector)

    def put(self, field: ngsolve.GridFunction, nodes: Array) -> None:
        """Let a vector field have these values at the walls' nodes, shape (facets, nodes, 2)."""
        local = np.einsum("eij,ejd->die", self._inverse, nodes[self.facet])
        values = field.vec.FV().NumPy().reshape(2, -1)
        values[:, self._dofs] = local.transpose(0, 2, 1)

    def linear(self, ends: Array) -> ngsolve.GridFunction:
        """Return a scalar field that is linear on each wall, from values at its start and end, shape (facets, 2)."""
        field = ngsolve.GridFunction(self.scalar)
        start, end = ends.T
        field.vec.FV().NumPy()[: 3 * len(ends)] = np.stack([start, end, (start + end) / 2], axis=1).ravel()
        return field

    def map(self, columns: int) -> sparse.csr_array:
        """Return the derivatives of the unknowns of `vector` by those of bodies, shape (strip's, 2 * columns)."""
        blocks = self._inverse @ self._walls.nodal[self.facet]
        rows = np.repeat(self._dofs, blocks.shape[2], axis=1).ravel()
        across = np.tile(self._walls.dofs[self.facet], (1, blocks.shape[1])).ravel()
        one = sparse.csr_array((blocks.ravel(), (rows, across)), shape=(self.scalar.ndof, columns))
        return sparse.block_diag([one, one], format="csr")


def _triangles(walls: EdgeSurface, colours: Index) -> netgen.meshing.Mesh:
    """Return the mesh: points 3 f and 3 f + 1 are the ends of wall f, 3 f + 2 lies behind it."""
    start, end = walls.rest[:, 0], walls.rest[:, -1]
    behind = (start + end) / 2 - np.linalg.norm(end - start, axis=1)[:, None] / 2 * walls.chord_normals(walls.rest)
    points = np.stack([start, end, behind], axis=1).reshape(-1, 2)
    # Netgen's edges have their body on the left.
    corner = 3 * np.arange(walls.facet_count)[:, None] + np.where(walls.side[:, None] > 0, (0, 1, 2), (1, 0, 2))
    mesh = netgen.meshing.Mesh(dim=2)
    mesh.AddPoints(np.column_stack([points, np.zeros(len(points))]))
    region = mesh.AddRegion("strip", dim=2)
    mesh.AddElements(dim=2, index=region, data=np.ascontiguousarray(corner, dtype=np.int32), base=0)
    for colour in range(int(colours.max()) + 1):
        mine = np.ascontiguousarray(corner[colours[walls.body] == colour, :2], dtype=np.int32)
        mesh.AddElements(dim=1, index=mesh.AddRegion(f"colour{colour}", dim=1), data=mine, base=0)
    return mesh
