"""The surfaces that may touch, as arrays: facets, their unknowns, and shape functions as polynomials.

A facet is a boundary edge in the plane (`ngcell.contact.surface.edges`) and a boundary face in three dimensions
(`ngcell.contact.surface.facets`). What both share is here, and the dimension is asked once, where a surface is made
(`ngcell.contact.surface.find`); pairing, gap and methods choose their algorithms by the class of the surface.

NGSolve's shape functions on a facet depend on its orientation, with signs from order 3 on. They are sampled once at
equidistant points, so that everything else works with Lagrange polynomials in the facet's own coordinates ``xi`` and
needs to know nothing of NGSolve.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Basis(Protocol):
    """Lagrange polynomials on the reference facet."""

    @property
    def order(self) -> int:
        """Polynomial order."""

    @property
    def centre(self) -> Array:
        """Middle of the reference facet, as coordinates."""

    @property
    def nodes(self) -> Array:
        """Lagrange nodes, as coordinates."""

    @property
    def corner_nodes(self) -> Index:
        """Nodes at the corners, in order."""

    def values(self, xi: Array, derivative: Any = ..., /) -> Array:
        """Return a derivative of all polynomials at `xi`, one of `Surface.directions`; by default their values."""

    def in_parts(self, points: Array, parts: int) -> tuple[Array, Index]:
        """Return points of the reference facet as they lie in each of the equal parts that its sides are divided into.

        Points that two parts share are one: the distinct points, and the number of each point of each part.
        """


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points on facets, sorted by facet.

    Attributes
    ----------
    facet : array of int, shape (n,)
        Facet of each point.
    xi : array of float, shape (n,), on faces (n, 2)
        Coordinates on it.
    weight : array of float, shape (n,)
        Quadrature weight times reference length [length], on faces area [length**2].
    """

    facet: Index
    xi: Array
    weight: Array

    @property
    def used(self) -> SurfacePoints:
        """The points without those of weight 0, for which the rule of their facet has no use."""
        used = self.weight != 0
        return SurfacePoints(self.facet[used], self.xi[used], self.weight[used])


def chosen_points(one: SurfacePoints, other: SurfacePoints, of_one: NDArray[np.bool_]) -> SurfacePoints:
    """Return the points of one rule on facets where `of_one` is true, shape (facets,), and of another elsewhere."""
    kept = [(points, is_mine[points.facet]) for points, is_mine in ((one, of_one), (other, ~of_one))]
    facet, xi, weight = (
        np.concatenate([getattr(points, name)[mine] for points, mine in kept]) for name in ("facet", "xi", "weight")
    )
    order = np.argsort(facet, kind="stable")
    return SurfacePoints(facet[order], xi[order], weight[order])


@dataclass(frozen=True, eq=False)
class Surface(ABC):
    """Boundary facets that may touch another body, and the quadrature points on them.

    Attributes
    ----------
    body : array of int, shape (facets,)
        Body that each facet bounds.
    dofs : array of int, shape (facets, nodes)
        Scalar unknowns of each facet.
    nodal : array of float, shape (facets, nodes, nodes)
        Values of the unknowns' shape functions at the Lagrange nodes.
    side : array of float, shape (facets,)
        +1 or -1, the factor that turns the normal which follows from the tangents into the outward one.
    basis : Basis
        Polynomials on a facet.
    quadrature_points : array of float, shape (points,), on faces (points, 2)
        Quadrature points of a facet in `xi`.
    weights : array of float, shape (facets, points)
        Quadrature weights times reference length [length], on faces area [length**2].
    depth : array of float, shape (facets,)
        Volume over area (in the plane area over length) of the element behind the facet [length], the scale of the
        penalty stiffness. A simplex counts as regular: its shape, an accident of the mesh, would make the stiffness
        jump along the wall.
    rest : array of float, shape (facets, nodes, dimension)
        Reference positions of the Lagrange nodes [length].
    thickness : array of float, shape (bodies,)
        Thickness of each body [length].
    """

    body: Index
    dofs: Index
    nodal: Array
    side: Array
    basis: Basis
    quadrature_points: Array
    weights: Array
    depth: Array
    rest: Array
    thickness: Array

    @property
    @abstractmethod
    def directions(self) -> tuple[Any, ...]:
        """What the tangents are derivatives by, as `basis.values` takes it."""

    @abstractmethod
    def measure(self, *tangents: Array) -> Array:
        """Return the length of the tangent, or the area that both tangents span, over the last axis."""

    @abstractmethod
    def chord_normals(self, nodes: Array) -> Array:
        """Return the outward unit normals of the flat facets through the corners, shape (facets, dimension).

        `nodes` are deformed positions of shape (facets, nodes, dimension) [length].
        """

    @abstractmethod
    def exterior_angle_at(self, nodes: Array) -> Array:
        """Return `exterior_angle` at deformed nodes of shape (facets, nodes, dimension)."""

    def may_touch(self, one: Index, two: Index) -> NDArray[np.bool_]:
        """Return whether contact acts between facets of each pair, both (pairs,): between those of different bodies."""
        return np.asarray(self.body[one] != self.body[two])

    @property
    def part(self) -> Index:
        """Part of the surface that each facet belongs to, shape (facets,): a point has a gap to each part in reach.

        Parts are the surfaces of bodies.
        """
        return self.body

    def chosen(self, facets: Index) -> Self:
        """Return the surface of these facets alone."""
        of_facets = ("body", "dofs", "nodal", "side", "weights", "depth", "rest")
        return replace(self, **{name: getattr(self, name)[facets] for name in of_facets})

    @property
    def facet_count(self) -> int:
        """Number of facets."""
        return len(self.body)

    @property
    def dimension(self) -> int:
        """Number of components of a position."""
        return int(self.rest.shape[2])

    @cached_property
    def sizes(self) -> Array:
        """Shortest distances of neighbouring corners at rest [length], shape (facets,)."""
        return self.sizes_at(self.rest)

    def sizes_at(self, nodes: Array) -> Array:
        """Return the same at nodes of shape (facets, nodes, dimension)."""
        corner = nodes[:, self.basis.corner_nodes]
        return np.asarray(np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).min(1))

    def nodes(self, unknowns: Array) -> Array:
        """Return the field with these unknowns, shape (dimension, scalar unknowns), at the nodes of all facets."""
        return np.asarray(np.einsum("eij,dej->eid", self.nodal, unknowns[:, self.dofs]))

    def divided(self, parts: int) -> SurfacePoints:
        """Return the quadrature points of the rule that takes each of equal parts of a facet as a facet.

        Edges, and sides of faces, have so many parts.
        """
        share = self.weights / self.stretch(self.rest, self.quadrature_points)
        xi, number = self.basis.in_parts(self.quadrature_points, parts)
        copies = len(number) // len(self.quadrature_points)
        weights = np.zeros((len(xi), self.facet_count))
        np.add.at(weights, number, np.tile(share.T / copies, (copies, 1)))
        return self.on_each_facet(xi, weights.T * self.stretch(self.rest, xi)).used

    def trace(self, facet: Index, xi: Array, *derivative: Any) -> Array:
        """Return the factors of the unknowns ``dofs[facet]`` in the field at `xi`, or in a derivative by `directions`.

        Shape (points, nodes).
        """
        return np.asarray(np.einsum("pi,pij->pj", self.basis.values(xi, *derivative), self.nodal[facet]))

    def places(self, facet: Index, xi: Array, nodes: Array) -> Array:
        """Return the positions of points on facets, (points, dimension), at nodes (facets, nodes, dimension)."""
        return np.asarray(np.einsum("pi,pid->pd", self.basis.values(xi), nodes[facet]))

    def tangents(self, facet: Index, xi: Array, nodes: Array) -> list[Array]:
        """Return the tangents at points on facets, each (points, dimension), at nodes (facets, nodes, dimension)."""
        return [np.einsum("pi,pid->pd", self.basis.values(xi, by), nodes[facet]) for by in self.directions]

    def rest_measure(self, facet: Index, xi: Array) -> Array:
        """Return the reference length, on faces area, that a unit of coordinates has at points on facets."""
        return self.measure(*self.tangents(facet, xi, self.rest))

    def stretch(self, nodes: Array, xi: Array) -> Array:
        """Return the same at deformed nodes and at the same points `xi` of all facets, shape (facets, points)."""
        return self.measure(*(np.einsum("ki,eid->ekd", self.basis.values(xi, by), nodes) for by in self.directions))

    def on_each_facet(self, xi: Array, weights: Array) -> SurfacePoints:
        """Return the same points on all facets; `weights` has shape (facets, points)."""
        facet = np.repeat(np.arange(self.facet_count), len(xi))
        return SurfacePoints(facet, np.tile(xi, (self.facet_count,) + (1,) * (xi.ndim - 1)), weights.ravel())

    @cached_property
    def quadrature(self) -> SurfacePoints:
        """All quadrature points that the facets' rules use."""
        return self.on_each_facet(self.quadrature_points, self.weights).used

    @cached_property
    def quadrature_values(self) -> Array:
        """Lagrange polynomials at the quadrature points, shape (points, nodes)."""
        return self.basis.values(self.quadrature_points)

    @cached_property
    def vertices(self) -> Index:
        """Scalar unknowns of the vertices at the corners of each facet, shape (facets, corners)."""
        values = np.einsum("eki,ei->ek", self.nodal[:, self.basis.corner_nodes], self.dofs)
        return np.asarray(values.round().astype(np.int64))

    @cached_property
    def exterior_angle(self) -> Array:
        """Angle by which the surface turns where facets meet, at rest [rad]: positive at convex corners, 0 at its rim.

        Shape (facets, 2), at the start and at the end of each edge; of a 3-D surface (facets, corners), at each side.
        """
        return self.exterior_angle_at(self.rest)

    def centres(self, nodes: Array) -> Array:
        """Return the positions of the facets' centres, shape (facets, dimension)."""
        return np.asarray(self.basis.values(self.basis.centre[None])[0] @ nodes)

    def middles(self, nodes: Array) -> Array:
        """Return the means of the facets' corners, shape (facets, dimension)."""
        return np.asarray(nodes[:, self.basis.corner_nodes].mean(1))

    def touches(self, columns: int) -> sparse.csr_array:
        """Return which scalar unknowns each facet has, shape (facets, columns)."""
        count, width = self.dofs.shape
        pointer = width * np.arange(count + 1)
        return sparse.csr_array((np.ones(count * width), self.dofs.ravel(), pointer), shape=(count, columns))
