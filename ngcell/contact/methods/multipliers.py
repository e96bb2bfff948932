"""The space of the contact pressure: continuous along a wall, and never negative where its coefficients are not.

On each facet the pressure is a polynomial of degree ``max(1, order - 1)`` in Bernstein form, continuous from facet to
facet and broken at sharp corners, where a wall ends. It is a subspace of the traces of displacements of that order,
hence stable beside them for any mesh of the other body; its degree keeps the order of the displacement; and Bernstein
polynomials are positive and add up to one, so ``coefficients >= 0`` makes the pressure itself >= 0, and a uniform
pressure is one of them. At a sharp corner the last two functions are one: where other walls or a support hold the
corner, a trace has one free value less there, and a multiplier of its own for that end would be determined by nothing.

On faces the functions are products of Bernstein polynomials, on triangles those of the triangle, and sharp sides break
the pressure as sharp corners do.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.edge_multipliers import EdgeFunctions, constrained_on_edges
from ngcell.contact.methods.facet_multipliers import FacetFunctions, constrained_on_facets
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.facets import FacetSurface
from ngcell.contact.surface.surface import Surface, SurfacePoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Angle in radians from which on a corner of an outline is sharp: between that of a coarse arc's edges and a hexagon's.
SHARP = np.radians(45)


class Functions(Protocol):
    """The functions on a facet."""

    def values(self, xi: Array) -> Array:
        """Return the functions at coordinates `xi`, along a further last axis."""

    def numbered(self, walls: Any, sharp: NDArray[np.bool_], /) -> Index:
        """Return numbers for the functions on each facet of a surface whose joints are sharp or not."""


class MultiplierSpace:
    """Bernstein polynomials along the walls.

    Parameters
    ----------
    walls : Surface
        The walls.

    Attributes
    ----------
    degree : int
        Degree on each facet.
    row : array of int, shape (facets, functions)
        Number of each facet's functions.
    weight : array of float, shape (size,)
        Integral of each function over the walls at rest [length], on faces [length**2].
    """

    def __init__(self, walls: Surface) -> None:
        self.degree = max(1, walls.basis.order - 1)
        self._functions = functions_on(walls, self.degree)
        self.row = self._functions.numbered(walls, np.abs(walls.exterior_angle) >= SHARP)
        shares = np.einsum("ep,pb->eb", walls.weights, self.values(walls.quadrature_points))
        self.weight: Array = np.bincount(self.row.ravel(), shares.ravel()).astype(float)

    @property
    def size(self) -> int:
        """Number of functions."""
        return len(self.weight)

    def values(self, xi: Array) -> Array:
        """Return the functions of a facet at coordinates `xi`, shape (points, functions)."""
        return self._functions.values(xi)


@singledispatch
def functions_on(walls: Surface, degree: int) -> Functions:
    """Return the functions of this degree on a facet of the walls."""
    raise NotImplementedError(type(walls))


@functions_on.register
def _(walls: EdgeSurface, degree: int) -> Functions:
    return EdgeFunctions(degree)


@functions_on.register
def _(walls: FacetSurface, degree: int) -> Functions:
    return FacetFunctions(degree, walls.basis.corner_count)


@singledispatch
def constrained_points(walls: Surface) -> SurfacePoints:
    """Return the points that may not sink in: vertices and quarters of all facets, each once, without weights."""
    raise NotImplementedError(type(walls))


constrained_points.register(EdgeSurface, constrained_on_edges)
constrained_points.register(FacetSurface, constrained_on_facets)


def sagitta(walls: Surface, nodes: Array) -> Array:
    """Return how far a surface rises from its chords [length], by its exterior angle at joints smooth at rest.

    Polygons that stand for touching arcs overlap by as much. Shape (facets,); `nodes` has shape (facets, nodes,
    dimension).
    """
    smooth = np.where(np.abs(walls.exterior_angle) < SHARP, np.abs(walls.exterior_angle_at(nodes)), 0.0)
    return np.asarray(walls.sizes_at(nodes) * smooth.max(1) / 4)
