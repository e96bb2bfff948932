"""The space of the contact pressure: continuous along a wall, and never negative where its coefficients are not.

On each edge the pressure is a polynomial of degree ``max(1, order - 1)`` in Bernstein form, continuous from edge to
edge and broken at sharp corners, where a wall ends. It is a subspace of the traces of displacements of that order,
hence stable beside them for any mesh of the other body; its degree keeps the order of the displacement; and Bernstein
polynomials are positive and add up to one, so ``coefficients >= 0`` makes the pressure itself >= 0, and a uniform
pressure is one of them. At a sharp corner the last two functions are one: where other walls or a support hold the
corner, a trace has one free value less there, and a multiplier of its own for that end would be determined by nothing.

In three dimensions the same holds on faces: products of Bernstein polynomials on quadrilaterals, those of the triangle on
triangles, broken at sharp sides.
"""

from __future__ import annotations

from functools import cached_property
from math import comb, factorial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.walls import Walls
from ngcell.geometry.near import components

if TYPE_CHECKING:
    from ngcell.contact.surface.facets import FaceBasis

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Angle in radians from which on a corner of an outline is sharp: between that of a coarse arc's edges and a hexagon's.
SHARP = np.radians(45)


class MultiplierSpace:
    """Bernstein polynomials along the walls.

    Parameters
    ----------
    walls : Walls
        The walls.

    Attributes
    ----------
    degree : int
        Degree on each edge.
    row : array of int, shape (edges, degree + 1)
        Number of each edge's functions.
    weight : array of float, shape (size,)
        Integral of each function over the walls at rest [length].
    """

    def __init__(self, walls: Walls) -> None:
        self.degree = max(1, walls.basis.order - 1)
        self._walls = walls
        self.row = self._numbered()
        shares = np.einsum("ep,pb->eb", walls.weights, self.values(walls.quadrature_points))
        self.weight = np.bincount(self.row.ravel(), shares.ravel())

    @property
    def size(self) -> int:
        """Number of functions."""
        return len(self.weight)

    def values(self, xi: Array) -> Array:
        """Return the functions of an edge at `xi`, shape (*xi.shape, degree + 1)."""
        if self._walls.dimension == 3:
            return self._values_on_faces(xi)
        return self._along(xi)

    def _along(self, xi: Array) -> Array:
        xi = np.asarray(xi)[..., None]
        power = np.arange(self.degree + 1)
        binomial = np.array([comb(self.degree, k) for k in power])
        return binomial * xi**power * (1 - xi) ** (self.degree - power)

    @cached_property
    def _lattice(self) -> FaceBasis:
        """In three dimensions: where the functions of a face are largest, or nearly so."""
        from ngcell.contact.surface.facets import FaceBasis

        return FaceBasis(self.degree, self._walls.basis.corner_count)

    def _values_on_faces(self, xi: Array) -> Array:
        """Return the functions of a face at `xi`, (*shape, 2); shape (*shape, functions)."""
        x, y = np.asarray(xi)[..., 0], np.asarray(xi)[..., 1]
        one, two = (self._lattice.nodes * self.degree).round().astype(int).T
        if self._lattice.corner_count == 4:
            return np.asarray(self._along(x)[..., one] * self._along(y)[..., two])
        rest = self.degree - one - two
        repeats = [[factorial(power) for power in powers] for powers in (one, two, rest)]
        x, y = x[..., None], y[..., None]
        return np.asarray(factorial(self.degree) / np.prod(repeats, axis=0) * x**one * y**two * (1 - x - y) ** rest)

    def _numbered(self) -> Index:
        if self._walls.dimension == 2:
            return _numbered(self._walls, self.degree)
        from ngcell.contact.surface.joints import numbered

        return numbered(self._walls, self._lattice, np.abs(self._walls.exterior_angle) >= SHARP)


def _numbered(walls: Walls, degree: int) -> Index:
    """Number the functions: at a vertex one is shared by the edges of a smooth joint, or joins the next at a corner."""
    edges = walls.edge_count
    own = np.arange(edges * (degree + 1)).reshape(edges, degree + 1)
    smooth = np.abs(walls.exterior_angle) < SHARP
    first, last = own[:, 0][smooth[:, 0]], own[:, -1][smooth[:, 1]]
    vertex = np.concatenate([walls.ends[smooth[:, 0], 0], walls.ends[smooth[:, 1], 1]])
    function = np.concatenate([first, last])
    sharp = np.abs(walls.exterior_angle) >= SHARP
    at_corner = np.concatenate([own[:, 0][sharp[:, 0]], own[:, -1][sharp[:, 1]]])
    beside = np.concatenate([own[:, 1][sharp[:, 0]], own[:, -2][sharp[:, 1]]])
    links = np.concatenate([function, at_corner]), np.concatenate([own.size + vertex, beside])
    component = components(own.size + int(walls.ends.max()) + 1, *links)
    _, number = np.unique(component[: own.size], return_inverse=True)
    return np.asarray(number.reshape(edges, degree + 1), dtype=np.int64)


def constrained_points(walls: Walls) -> tuple[Index, Array]:
    """Return the vertices, each once, and the quarters of all edges, as edges and coordinates on them."""
    if walls.dimension == 3:
        return _constrained_on_faces(walls)
    _, first = np.unique(walls.ends.ravel(), return_index=True)
    edge, end = np.divmod(first, 2)
    quarters = np.array([0.25, 0.5, 0.75])
    edge = np.concatenate([edge, np.repeat(np.arange(walls.edge_count), len(quarters))])
    xi = np.concatenate([end, np.tile(quarters, walls.edge_count)])
    order = np.lexsort((xi, edge))
    return edge[order], xi[order]


def _constrained_on_faces(walls: Walls) -> tuple[Index, Array]:
    """Return the points of faces whose coordinates are quarters; those on shared sides once."""
    from ngcell.contact.surface.facets import FaceBasis
    from ngcell.contact.surface.joints import lattice_places

    lattice = FaceBasis(4, walls.basis.corner_count)
    place = lattice_places(walls, lattice).reshape(-1, 3)
    edge, number = np.divmod(np.arange(len(place)), len(lattice.nodes))
    digits = np.round(place / (1e-7 * np.abs(place).max()))
    _, first = np.unique(np.column_stack([walls.body[edge], digits]), axis=0, return_index=True)
    first = np.sort(first)
    return edge[first], lattice.nodes[number[first]]


def sagitta(walls: Walls, nodes: Array) -> Array:
    """Return how far an outline rises from its edges' chords [length], by its exterior angle at joints smooth at rest.

    Polygons that stand for touching arcs overlap by as much. Shape (edges,); `nodes` has shape (edges, order + 1, 2).
    """
    length = walls.sizes_at(nodes)
    smooth = np.where(np.abs(walls.exterior_angle) < SHARP, np.abs(walls.exterior_angle_at(nodes)), 0.0)
    return np.asarray(length * smooth.max(1) / 4)
