"""Walls in three dimensions: boundary faces as arrays, with shape functions as polynomials in two coordinates.

Everything of `ngcell.contact.surface.walls` holds, with a face in place of an edge and two coordinates ``xi`` in the unit
triangle or the unit square. The outward normal of a face is the cross product of its tangents times `side`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.polynomials import lobatto
from ngcell.contact.surface.walls import Walls
from ngcell.errors import GeometryError
from ngcell.geometry.bodies import BETWEEN, BodyMesh

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_CORNERS = {
    3: np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]),
    4: np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]),
}
#: Share of a face by which it is continued where walls end.
_CONTINUED = 0.25
#: Volume over area of a regular tetrahedron, for each root of the area of a side.
_TETRAHEDRON = np.sqrt(4 / np.sqrt(3)) * np.sqrt(2 / 3) / 3


@dataclass(frozen=True, eq=False)
class FaceBasis:
    """Lagrange polynomials at equidistant nodes of the unit triangle or square, and their derivatives.

    Attributes
    ----------
    order : int
        Polynomial order, in each coordinate or, on triangles, in all.
    corner_count : {3, 4}
        Whether faces are triangles or quadrilaterals.
    """

    order: int
    corner_count: int

    @cached_property
    def corners(self) -> Array:
        """Corners of the unit face, anticlockwise, shape (corners, 2)."""
        return _CORNERS[self.corner_count]

    @property
    def centre(self) -> Array:
        """Its centre, shape (2,)."""
        return np.asarray(self.corners.mean(0))

    @cached_property
    def _powers(self) -> Index:
        index = np.array(list(np.ndindex(self.order + 1, self.order + 1)))
        return index[index.sum(1) <= self.order] if self.corner_count == 3 else index

    @cached_property
    def nodes(self) -> Array:
        """Nodes, shape (nodes, 2)."""
        return self._powers / self.order

    @cached_property
    def corner_nodes(self) -> Index:
        """Nodes at the corners, shape (corners,)."""
        apart = np.abs(self.corners[:, None] - self.nodes).sum(2)
        return np.asarray(apart.argmin(1))

    @cached_property
    def _to_monomials(self) -> Array:
        return np.linalg.inv((self.nodes[:, None] ** self._powers).prod(2))

    def values(self, xi: Array, derivative: tuple[int, int] = (0, 0)) -> Array:
        """Return a partial derivative of all polynomials at `xi`, (*shape, 2); shape (*shape, nodes)."""
        factors = []
        for axis, degree in enumerate(derivative):
            power = self._powers[:, axis]
            factor = np.ones(len(power))
            for step in range(degree):
                factor = factor * (power - step)
            factors.append(_powers_of(xi[..., axis], self.order)[..., np.maximum(power - degree, 0)] * factor)
        return np.asarray((factors[0] * factors[1]) @ self._to_monomials)

    @cached_property
    def rule(self) -> tuple[Array, Array]:
        """Points and weights of the quadrature on the unit face.

        Squares are walls of prisms, with the second coordinate along the axis. Around the cell they take the rule on
        edges, which has points on the corner lines; along the axis that of Gauss, which is as exact. It has no points
        on seams between elements: there facing meshes would meet point on seam, and where walls sagitta, a seam is a
        groove in which points are caught: the direction of the push flips within a width of an overlap times an angle.

        A triangle takes three quadrilaterals that meet in its centre, each with the rule on edges: corners and sides
        are among its points. Shape functions of the wall opposite have kinks where its faces end, which no rule of
        this wall knows of: the more points, the less pressures scatter between meshes that do not match.
        """
        if self.corner_count == 4:
            at, share = lobatto(self.order + 2)
            legendre, weights = np.polynomial.legendre.leggauss(self.order + 1)
            return _product((at, share), ((legendre + 1) / 2, weights / 2))
        at, share = lobatto(self.order + 2)
        points, weights = [], []
        for corner in range(3):
            here, ahead, behind = (self.corners[(corner + step) % 3] for step in range(3))
            quad = [here, (here + ahead) / 2, self.centre, (here + behind) / 2]
            x, y = (axis.ravel() for axis in np.meshgrid(at, at, indexing="ij"))
            shape = np.stack([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y])
            by_x = np.stack([y - 1, 1 - y, y, -y]).T @ quad
            by_y = np.stack([x - 1, -x, x, 1 - x]).T @ quad
            points.append(shape.T @ quad)
            weights.append(np.outer(share, share).ravel() * (by_x[:, 0] * by_y[:, 1] - by_x[:, 1] * by_y[:, 0]))
        return _merged(np.concatenate(points), np.concatenate(weights))

    @property
    def level_rule(self) -> tuple[Array, Array]:
        """Points and weights for squares that are ends of prisms: the rule of Gauss in both directions.

        Seams run in both directions there, and rims of one layer lie on those of the next, where directions of the push
        would flip. It has as many points as the rule on edges: with one less, corners of a layer that has slid sink
        into the other by 2 % of the wall; with these, by less than 0.5 %.
        """
        legendre, weights = np.polynomial.legendre.leggauss(self.order + 2)
        return _product(*[((legendre + 1) / 2, weights / 2)] * 2)


def find_faces(bodies: BodyMesh, scalar_space: ngsolve.H1, rest: Array) -> Walls:
    """Collect the walls of solid bodies; parameters as for `ngcell.contact.walls.find_walls`.

    Raises
    ------
    GeometryError
        If walls are of triangles and of quadrilaterals.
    """
    mesh, order = bodies.mesh, scalar_space.globalorder
    elements = list(mesh.Boundaries(bodies.wall_names).Elements())
    counts = {len(element.vertices) for element in elements} or {3}
    if len(counts) > 1:
        raise GeometryError("walls are of triangles and of quadrilaterals; allowed: one kind of faces")
    basis = FaceBasis(order, counts.pop())
    size = len(basis.nodes)
    dofs = np.array([scalar_space.GetDofNrs(element) for element in elements], dtype=np.int64).reshape(-1, size)
    nodal = np.array([_sampled_shapes(scalar_space, element, basis) for element in elements]).reshape(-1, size, size)
    behind = np.array([mesh[element.faces[0]].elements[0].nr for element in elements], dtype=np.int64)
    nodes = np.einsum("eij,dej->eid", nodal, rest[:, dofs])
    quadrature_points, share = _rules(basis, np.array([element.mat == BETWEEN for element in elements], dtype=bool))
    tangents = [basis.values(quadrature_points, derivative) @ nodes for derivative in ((1, 0), (0, 1))]
    weights = share * np.linalg.norm(np.cross(*tangents), axis=2)
    area, depth = weights.sum(1), np.zeros(len(elements))
    volume = ngsolve.Integrate(ngsolve.CF(1), mesh, element_wise=True).NumPy()[behind]
    inside = [mesh[ngsolve.ElementId(ngsolve.VOL, int(number))] for number in behind]
    is_tetrahedron = np.array([len(element.vertices) == 4 for element in inside], dtype=bool)
    depth = np.where(is_tetrahedron, _TETRAHEDRON * np.sqrt(area), volume / area)
    centre = np.array([np.mean([mesh[vertex].point for vertex in element.vertices], axis=0) for element in inside])
    walls = Walls(
        body=bodies.body_of_element[behind],
        dofs=dofs,
        nodal=nodal,
        side=np.ones(len(elements)),
        basis=basis,
        quadrature_points=quadrature_points,
        weights=weights,
        depth=depth,
        rest=nodes,
    )
    outward = walls.middles(nodes) - centre.reshape(-1, 3)
    walls.side[:] = np.sign(np.einsum("ed,ed->e", walls.chord_normals(nodes), outward))
    return walls


def loose_sides(walls: Walls) -> NDArray[np.bool_]:
    """Return which sides of each face no other wall shares, shape (faces, corners); side k follows corner k."""
    vertex = vertices(walls)
    ends = np.sort(np.stack([vertex, np.roll(vertex, -1, axis=1)], axis=-1), axis=-1)
    _, number, count = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True, return_counts=True)
    return np.asarray((count[number.ravel()] == 1).reshape(vertex.shape))


def vertices(walls: Walls) -> Index:
    """Return the scalar unknowns of the vertices at the corners of each face, shape (faces, corners)."""
    values = np.einsum("eki,ei->ek", walls.nodal[:, walls.basis.corner_nodes], walls.dofs)
    return np.asarray(values.round().astype(np.int64))


def domains(walls: Walls) -> Array:
    """Return the corners of the coordinates that are searched on each face, shape (faces, corners, 2).

    They are those of the unit face, but where walls end, as at the ends of prisms, the face is continued by a share of
    itself: bodies whose ends do not quite match press on each other up to there, and a point that slides past an end by
    little neither drops out of contact at once nor changes the direction that it is pushed in.
    """
    corners = walls.basis.corners
    count = len(corners)
    ahead = np.roll(corners, -1, axis=0) - corners
    outward = np.column_stack([ahead[:, 1], -ahead[:, 0]]) / np.linalg.norm(ahead, axis=1)[:, None]
    level = np.einsum("cd,cd->c", outward, corners)
    choices = np.array(list(np.ndindex(*(2,) * count)))
    moved = level + _CONTINUED * choices
    # Each corner is where the sides before and after it meet.
    pairs = np.stack([np.roll(outward, 1, axis=0), outward], axis=1)
    levels = np.stack([np.roll(moved, 1, axis=1), moved], axis=2)
    table = np.linalg.solve(pairs[None], levels[..., None])[..., 0]
    return np.asarray(table[walls.loose_sides @ (2 ** np.arange(count)[::-1])])


def _sampled_shapes(space: ngsolve.H1, element: ngsolve.comp.Ngs_Element, basis: FaceBasis) -> Array:
    shape = space.GetFE(ngsolve.ElementId(ngsolve.BND, element.nr)).CalcShape
    return np.array([np.asarray(shape(*node)).ravel() for node in basis.nodes])


def _rules(basis: FaceBasis, is_level: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return points, and weights of shape (faces, points): those of the rule of each face, 0 at those of the other."""
    points, share = basis.rule
    if not is_level.any():
        return points, np.tile(share, (len(is_level), 1))
    others, level_share = basis.level_rule
    nowhere = np.zeros(len(share)), np.zeros(len(level_share))
    both = np.concatenate([share, nowhere[1]]), np.concatenate([nowhere[0], level_share])
    return np.concatenate([points, others]), np.where(is_level[:, None], both[1], both[0])


def _product(one: tuple[Array, Array], two: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return the rule on the unit square of two rules on [0, 1], each points and weights."""
    points = np.stack(np.meshgrid(one[0], two[0], indexing="ij"), axis=-1).reshape(-1, 2)
    return points, np.outer(one[1], two[1]).ravel()


def _powers_of(x: Array, most: int) -> Array:
    powers = [np.ones_like(x)]
    for _ in range(most):
        powers.append(powers[-1] * x)
    return np.stack(powers, axis=-1)


def _merged(points: Array, weights: Array) -> tuple[Array, Array]:
    """Return distinct points with the sums of their weights."""
    _, first, number = np.unique(points.round(12), axis=0, return_index=True, return_inverse=True)
    return points[first], np.bincount(number.ravel(), weights)
