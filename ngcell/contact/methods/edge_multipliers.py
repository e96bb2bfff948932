"""Bernstein polynomials along edges, their numbers, and the points of edges that are constrained one by one."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.surface import SurfacePoints
from ngcell.geometry.near import components

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Coordinates of the points between vertices that are constrained.
_QUARTERS = np.array([0.25, 0.5, 0.75])


@dataclass(frozen=True, eq=False)
class EdgeFunctions:
    """Bernstein polynomials of degree `degree` on [0, 1]."""

    degree: int

    def values(self, xi: Array) -> Array:
        """Return the functions at `xi`, shape (*xi.shape, degree + 1)."""
        xi = np.asarray(xi)[..., None]
        power = np.arange(self.degree + 1)
        binomial = np.array([comb(self.degree, k) for k in power])
        return np.asarray(binomial * xi**power * (1 - xi) ** (self.degree - power))

    def slopes(self, xi: Array) -> Array:
        """Return the derivatives of the functions, shape (*xi.shape, degree + 1)."""
        lower = EdgeFunctions(self.degree - 1).values(xi)
        ends = [(0, 0)] * (lower.ndim - 1)
        return np.asarray(self.degree * (np.pad(lower, [*ends, (1, 0)]) - np.pad(lower, [*ends, (0, 1)])))

    def numbered(self, walls: EdgeSurface, sharp: NDArray[np.bool_]) -> Index:
        """Return numbers for the functions on each edge, shape (edges, degree + 1).

        At a vertex one function is shared by the edges of a smooth joint. At a sharp corner, `sharp` of shape (edges,
        2), walls end: there the last function of an edge joins the next one.
        """
        own = np.arange(walls.facet_count * (self.degree + 1)).reshape(walls.facet_count, -1)
        smooth = ~sharp
        function = np.concatenate([own[:, 0][smooth[:, 0]], own[:, -1][smooth[:, 1]]])
        vertex = np.concatenate([walls.vertices[smooth[:, 0], 0], walls.vertices[smooth[:, 1], 1]])
        at_corner = np.concatenate([own[:, 0][sharp[:, 0]], own[:, -1][sharp[:, 1]]])
        beside = np.concatenate([own[:, 1][sharp[:, 0]], own[:, -2][sharp[:, 1]]])
        links = np.concatenate([function, at_corner]), np.concatenate([own.size + vertex, beside])
        component = components(own.size + int(walls.vertices.max()) + 1, *links)
        _, number = np.unique(component[: own.size], return_inverse=True)
        return np.asarray(number.reshape(own.shape), dtype=np.int64)


def constrained_on_edges(walls: EdgeSurface) -> SurfacePoints:
    """Return the vertices, each once, and the quarters of all edges."""
    _, first = np.unique(walls.vertices.ravel(), return_index=True)
    edge, end = np.divmod(first, 2)
    edge = np.concatenate([edge, np.repeat(np.arange(walls.facet_count), len(_QUARTERS))])
    xi = np.concatenate([end, np.tile(_QUARTERS, walls.facet_count)])
    order = np.lexsort((xi, edge))
    return SurfacePoints(edge[order], xi[order], np.zeros(len(order)))
