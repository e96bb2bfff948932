"""The walls that may touch, as arrays: edges, their unknowns, and shape functions as polynomials.

NGSolve's shape functions on an edge depend on the orientation of the edge, with signs from order 3 on. They are
sampled once at equidistant points, so that everything below works with Lagrange polynomials in the edge's own
coordinate ``xi`` in [0, 1] and needs to know nothing of NGSolve. Signs: the outward normal of an edge is its tangent
turned by -90 degrees times `side`.

In three dimensions a wall is a boundary face, with two coordinates and two tangents; it is called an edge here all the same, and
what differs is in `ngcell.contact.surface.facets`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import ngsolve
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.surface.polynomials import Lagrange, lobatto
from ngcell.geometry.bodies import BodyMesh

if TYPE_CHECKING:
    from ngcell.contact.surface.facets import FaceBasis

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class WallPoints:
    """Points on wall edges, sorted by edge.

    Attributes
    ----------
    edge : array of int, shape (n,)
        Edge of each point.
    xi : array of float, shape (n,), in three dimensions (n, 2)
        Coordinate along it, in [0, 1].
    weight : array of float, shape (n,)
        Quadrature weight times reference length [length], in three dimensions area.
    """

    edge: Index
    xi: Array
    weight: Array


@dataclass(frozen=True, eq=False)
class Walls:
    """Boundary edges, in three dimensions faces, that may touch another body, and the quadrature points on them.

    Attributes
    ----------
    body : array of int, shape (edges,)
        Body that each edge bounds.
    dofs : array of int, shape (edges, order + 1)
        Scalar unknowns of each edge.
    nodal : array of float, shape (edges, order + 1, order + 1)
        Values of the unknowns' shape functions at the Lagrange nodes.
    side : array of float, shape (edges,)
        +1 or -1, so that the outward normal is ``side * (t_y, -t_x) / |t|``.
    basis : Lagrange
        Polynomials along an edge.
    quadrature points : array of float, shape (points,)
        Quadrature points of an edge in `xi`.
    weights : array of float, shape (edges, points)
        Quadrature weights times reference length [length].
    depth : array of float, shape (edges,)
        Area over length of the element behind the edge [length], the scale of the penalty stiffness. A triangle counts
        as equilateral: its shape, an accident of the mesh, would make the stiffness jump along the wall.
    rest : array of float, shape (edges, order + 1, 2)
        Reference positions of the Lagrange nodes [length].
    """

    body: Index
    dofs: Index
    nodal: Array
    side: Array
    basis: Lagrange | FaceBasis
    quadrature_points: Array
    weights: Array
    depth: Array
    rest: Array

    @property
    def edge_count(self) -> int:
        """Number of edges."""
        return len(self.body)

    @property
    def dimension(self) -> int:
        """Space dimension."""
        return int(self.rest.shape[2])

    @property
    def directions(self) -> tuple[int | tuple[int, int], ...]:
        """What the tangents are derivatives by, as `basis.values` takes it."""
        return (1,) if self.dimension == 2 else ((1, 0), (0, 1))

    @cached_property
    def sizes(self) -> Array:
        """Lengths of the chords at rest, in three dimensions of the shortest sides, shape (edges,)."""
        return self.sizes_at(self.rest)

    def sizes_at(self, nodes: Array) -> Array:
        """Return the same at nodes of shape (edges, order + 1, 2)."""
        if self.dimension == 2:
            return np.asarray(np.linalg.norm(nodes[:, -1] - nodes[:, 0], axis=1))
        corner = nodes[:, self.basis.corner_nodes]
        return np.asarray(np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).min(1))

    def nodes(self, unknowns: Array) -> Array:
        """Return the field with these unknowns, shape (2, scalar unknowns), at the nodes: (edges, order + 1, 2)."""
        return np.einsum("eij,dej->eid", self.nodal, unknowns[:, self.dofs])

    def trace(self, edge: Index, xi: Array, derivative: int | tuple[int, int] | None = None) -> Array:
        """Return the factors of the unknowns ``dofs[edge]`` at `xi`; shape (points, order + 1)."""
        values = self.basis.values(xi) if derivative is None else self.basis.values(xi, derivative)
        return np.einsum("pi,pij->pj", values, self.nodal[edge])

    @cached_property
    def quadrature(self) -> WallPoints:
        """All quadrature points; those that an edge's rule has no use for, of weight 0, are left out."""
        edges, count = self.edge_count, len(self.quadrature_points)
        edge, xi = (
            np.repeat(np.arange(edges), count),
            np.tile(self.quadrature_points, (edges,) + (1,) * (self.dimension - 2)),
        )
        weight = self.weights.ravel()
        used = weight != 0
        return WallPoints(edge[used], xi[used], weight[used])

    def halved(self) -> WallPoints:
        """Return the quadrature points of the rule that takes each half of an edge as an edge."""
        first, share = lobatto(len(self.quadrature_points))
        xi = np.concatenate([first / 2, 0.5 + first[1:] / 2])
        share = np.concatenate([share, np.zeros(len(share) - 1)]) + np.concatenate([np.zeros(len(share) - 1), share])
        weights = share / 2 * self.stretch(self.rest, xi)
        return WallPoints(np.repeat(np.arange(self.edge_count), len(xi)), np.tile(xi, self.edge_count), weights.ravel())

    @cached_property
    def ends(self) -> Index:
        """Scalar unknowns of the vertices at the start and at the end of each edge, shape (edges, 2)."""
        ends = np.einsum("eki,ei->ek", self.nodal[:, [0, -1], :2], self.dofs[:, :2])
        return np.asarray(ends.round().astype(np.int64))

    @cached_property
    def is_loose_end(self) -> NDArray[np.bool_]:
        """Whether the outline of the body ends at the start (0) and at the end (1) of an edge, shape (edges, 2)."""
        return np.asarray(np.bincount(self.ends.ravel())[self.ends] < 2)

    @cached_property
    def exterior_angle(self) -> Array:
        """Angle by which the outline turns at the start and at the end of each edge at rest, shape (edges, 2).

        In radians, positive at convex corners; 0 where the outline ends. In three dimensions at each side, shape (edges, corners).
        """
        return self.exterior_angle_at(self.rest)

    def exterior_angle_at(self, nodes: Array) -> Array:
        """Return the same at nodes of shape (edges, order + 1, 2)."""
        if self.dimension == 3:
            from ngcell.contact.surface.joints import exterior_angle_at

            return exterior_angle_at(self, nodes)
        slope = np.einsum("ki,eid->ekd", self.basis.values(np.array([0.0, 1.0]), 1), nodes)
        normal = np.stack([slope[..., 1], -slope[..., 0]], axis=-1) * self.side[:, None, None]
        normal = (normal / np.linalg.norm(normal, axis=-1, keepdims=True)).reshape(-1, 2)
        inward = (slope * np.array([1.0, -1.0])[:, None]).reshape(-1, 2)
        order = np.argsort(self.ends.ravel(), kind="stable")
        same = np.flatnonzero(np.diff(self.ends.ravel()[order]) == 0)
        one, two = order[same], order[same + 1]
        across = normal[one, 0] * normal[two, 1] - normal[one, 1] * normal[two, 0]
        angle = np.arctan2(np.abs(across), np.einsum("pd,pd->p", normal[one], normal[two]))
        angle = np.where(np.einsum("pd,pd->p", normal[one], inward[two]) > 0, -angle, angle)
        exterior_angle = np.zeros(len(normal))
        exterior_angle[one] = exterior_angle[two] = angle
        return exterior_angle.reshape(-1, 2)

    def places(self, edge: Index, xi: Array, nodes: Array) -> Array:
        """Return the positions of points on edges, shape (points, 2), at nodes of shape (edges, order + 1, 2)."""
        return np.asarray(np.einsum("pi,pid->pd", self.basis.values(xi), nodes[edge]))

    def touches(self, columns: int) -> sparse.csr_array:
        """Return which scalar unknowns each edge has, shape (edges, columns)."""
        count, width = self.dofs.shape
        pointer = width * np.arange(count + 1)
        return sparse.csr_array((np.ones(count * width), self.dofs.ravel(), pointer), shape=(count, columns))

    def middles(self, nodes: Array) -> Array:
        """Return the middles of the chords, in three dimensions of the corners, shape (edges, dimension), at deformed nodes."""
        if self.dimension == 2:
            return (nodes[:, 0] + nodes[:, -1]) / 2
        return np.asarray(nodes[:, self.basis.corner_nodes].mean(1))

    def chord_normals(self, nodes: Array) -> Array:
        """Return the outward unit normals of the chords, shape (edges, dimension), at deformed nodes.

        In three dimensions those of the plane through the corners, of a quadrilateral that of its diagonals.
        """
        if self.dimension == 2:
            chord = nodes[:, -1] - nodes[:, 0]
            normal = np.column_stack([chord[:, 1], -chord[:, 0]]) * self.side[:, None]
        else:
            corner = np.moveaxis(nodes[:, self.basis.corner_nodes], 1, 0)
            normal = np.cross(corner[2] - corner[0], corner[-1] - corner[1]) * self.side[:, None]
        return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])

    @cached_property
    def loose_sides(self) -> NDArray[np.bool_]:
        """In three dimensions: which sides of each face no other wall shares, shape (faces, corners)."""
        from ngcell.contact.surface.facets import loose_sides

        return loose_sides(self)

    @cached_property
    def domains(self) -> Array:
        """In three dimensions: corners of the polygon of coordinates of each face, shape (faces, corners, 2)."""
        from ngcell.contact.surface.facets import domains

        return domains(self)

    def stretch(self, nodes: Array, xi: Array) -> Array:
        """Return the length of the tangent, in three dimensions the area between both, at points `xi` of all edges."""
        if self.dimension == 2:
            return np.asarray(np.linalg.norm(np.einsum("ki,eid->ekd", self.basis.values(xi, 1), nodes), axis=2))
        tangents = [np.einsum("ki,eid->ekd", self.basis.values(xi, along), nodes) for along in ((1, 0), (0, 1))]
        return np.asarray(np.linalg.norm(np.cross(*tangents), axis=2))

    @cached_property
    def quadrature_values(self) -> Array:
        """Lagrange polynomials at the quadrature points, shape (points, order + 1)."""
        return self.basis.values(self.quadrature_points)


def find_walls(bodies: BodyMesh, scalar_space: ngsolve.H1, rest: Array) -> Walls:
    """Collect the walls of all bodies.

    Parameters
    ----------
    bodies : BodyMesh
        The mesh; its `wall_names` say which boundaries are walls.
    scalar_space : ngsolve.H1
        Space of one displacement component.
    rest : array of float, shape (dimension, scalar unknowns)
        Reference coordinates as unknowns of that space.
    """
    if bodies.dimension == 3:
        from ngcell.contact.surface.facets import find_faces

        return find_faces(bodies, scalar_space, rest)
    mesh, order = bodies.mesh, scalar_space.globalorder
    basis = Lagrange(order)
    elements = list(mesh.Boundaries(bodies.wall_names).Elements())
    dofs = np.array([scalar_space.GetDofNrs(element) for element in elements], dtype=np.int64)
    nodal = np.array([_sampled_shapes(scalar_space, element, basis) for element in elements])
    behind = np.array([mesh[element.edges[0]].elements[0].nr for element in elements])
    nodes = np.einsum("eij,dej->eid", nodal, rest[:, dofs])
    quadrature_points, share = lobatto(order + 2)
    speed = np.linalg.norm(np.einsum("pi,eid->epd", basis.values(quadrature_points, 1), nodes), axis=2)
    length = (share * speed).sum(1)
    area, centre = _areas_and_centres(mesh, behind)
    tangent = nodes[:, -1] - nodes[:, 0]
    outward = (nodes[:, 0] + nodes[:, -1]) / 2 - centre
    turned = tangent[:, 1] * outward[:, 0] - tangent[:, 0] * outward[:, 1]
    return Walls(
        body=bodies.body_of_element[behind],
        dofs=dofs,
        nodal=nodal,
        side=np.sign(turned),
        basis=basis,
        quadrature_points=quadrature_points,
        weights=share * speed,
        depth=np.where(_are_triangles(mesh, behind), np.sqrt(3) / 4 * length, area / length),
        rest=nodes,
    )


def _sampled_shapes(space: ngsolve.H1, element: ngsolve.comp.Ngs_Element, basis: Lagrange) -> Array:
    shape = space.GetFE(ngsolve.ElementId(ngsolve.BND, element.nr)).CalcShape
    return np.array([np.asarray(shape(xi)).ravel() for xi in basis.nodes])


def _are_triangles(mesh: ngsolve.Mesh, numbers: Index) -> NDArray[np.bool_]:
    return np.array([len(mesh[ngsolve.ElementId(ngsolve.VOL, int(number))].vertices) == 3 for number in numbers])


def _areas_and_centres(mesh: ngsolve.Mesh, numbers: Index) -> tuple[Array, Array]:
    area = ngsolve.Integrate(ngsolve.CF(1), mesh, element_wise=True).NumPy()[numbers]
    elements = (mesh[ngsolve.ElementId(ngsolve.VOL, int(number))] for number in numbers)
    centre = [np.mean([mesh[vertex].point for vertex in element.vertices], axis=0) for element in elements]
    return area, np.array(centre)
