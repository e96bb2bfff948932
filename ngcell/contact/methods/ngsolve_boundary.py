"""The penalty energy by `ngsolve.ContactBoundary`: NGSolve searches, integrates and differentiates.

For a point on one wall and its closest point on another, with ``a`` from the latter to the former, and the deformed
tangent ``t`` and outward normal ``n`` of the secondary wall, the energy is that of the penalty on the gap ``a . n``. It
is written in reference quantities with the *secondary* normal, which moves with the wall: at a closest point ``a`` is
parallel to it, so that the force with frozen pairs is that of the energy whose pairs are found anew. The same holds for
the tangent with the curvature correction of `ngcell.contact.gap.edge_gap`. Where the closest point is no foot of a
normal but a joint of two walls, the gap is the distance to it; points outside bear nothing.

`ContactBoundary.normal`, the primary side's at the last update, would make forces that no energy has.
"""

from __future__ import annotations

from itertools import permutations
from typing import Any

import ngsolve
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.methods.wall_strip import WallStrip
from ngcell.contact.pairing.closest_on_edges import BLUNT, END_TOLERANCE
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.mechanics.space import csr_matrix

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of 1 that ``1 - k g`` is kept above; see `ngcell.contact.gap.edge_gap`.
_LEAST = 0.1


class BoundaryEnergy:
    """Contact boundaries of all colours with the penalty energy between them.

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    strip : WallStrip
        The mesh that NGSolve searches.
    stiffness : array of float, shape (facets,)
        Penalty stiffness of each facet [stress / length]; a pair takes the softer one.
    reach : float
        Distance up to which walls are paired [length].
    """

    def __init__(self, walls: EdgeSurface, strip: WallStrip, stiffness: Array, reach: float) -> None:
        self._walls, self._strip, self._reach = walls, strip, reach
        self._state, self._bend = (ngsolve.GridFunction(strip.vector) for _ in range(2))
        self._corner = ngsolve.GridFunction(strip.scalar)
        self._map: sparse.csr_array | None = None
        self._form = ngsolve.BilinearForm(strip.vector)
        energy = self._energy(_Gap(strip, self._state, self._bend, self._corner), stiffness)
        self._boundaries = [self._boundary(one, two) for one, two in permutations(range(strip.colour_count), 2)]
        for boundary in self._boundaries:
            boundary.AddEnergy(energy)

    def _boundary(self, one: int, two: int) -> ngsolve.ContactBoundary:
        boundaries = self._strip.mesh.Boundaries
        return ngsolve.ContactBoundary(boundaries(f"point{one}"), boundaries(f"wall{two}"))

    def _energy(self, gap: _Gap, stiffness: Array) -> Any:
        """Return the energy per length of a short edge: of each pass half."""
        strip, points = self._strip, self._walls.quadrature
        own = stiffness[strip.facet]
        mine = strip.linear(own, own)
        softer = ngsolve.IfPos(mine - mine.Other(), mine.Other(), mine)
        weight = np.concatenate([np.zeros(self._walls.facet_count), points.weight]) / strip.lengths
        return (strip.linear(weight, weight) * softer / 4 * gap.squared).Compile()

    def find(self, positions: Array) -> None:
        """Let NGSolve find the closest points at positions given as unknowns of bodies, shape (2, scalar unknowns)."""
        nodes = self._walls.nodes(positions)
        self._strip.put(self._state, self._strip.relative(nodes))
        bend = np.einsum("ki,eid->ekd", self._walls.basis.values(self._walls.basis.nodes, 2), nodes)
        self._strip.put(self._bend, bend / self._strip.lengths[: len(nodes), None, None] ** 2)
        self._corner.vec.data = self._strip.linear(*_corners(self._walls, nodes)[self._strip.facet].T).vec
        self._form.DeleteSpecialElements()
        for boundary in self._boundaries:
            # Regions of two colours have no body in common: nothing is gained by asking for opposed normals, and
            # energy would jump where a corner slides past another.
            boundary.Update(self._state, self._form, intorder=1, maxdist=self._reach, both_sides=True)

    def map(self, columns: int) -> sparse.csr_array:
        """Return the derivatives of the strip's unknowns by those of bodies, shape (strip's, 2 * columns)."""
        if self._map is None or self._map.shape[1] != 2 * columns:
            self._map = self._strip.map(columns)
        return self._map

    def energy(self) -> float:
        """Return the energy of the pairs that were found last."""
        return float(self._form.Energy(self._state.vec))

    def gradient(self) -> Array:
        """Return its derivatives by the strip's unknowns."""
        force = self._state.vec.CreateVector()
        self._form.Apply(self._state.vec, force)
        return np.array(force.FV().NumPy())

    def tangent(self) -> sparse.csr_array:
        """Return its second derivatives by the strip's unknowns."""
        self._form.AssembleLinearization(self._state.vec)
        return csr_matrix(self._form.mat)


class _Gap:
    """The gap of a pair, as an expression in the displacement of both sides.

    Parameters
    ----------
    strip : WallStrip
        The mesh.
    state, bend : ngsolve.GridFunction
        Positions where pairs were found, and their second derivatives along the chords.
    corner : ngsolve.GridFunction
        What the ends of walls are, as `_corners` tells it.
    """

    def __init__(
        self, strip: WallStrip, state: ngsolve.GridFunction, bend: ngsolve.GridFunction, corner: ngsolve.GridFunction
    ) -> None:
        trial, normal = strip.vector.TrialFunction(), ngsolve.specialcf.normal(2)
        place, along = ngsolve.CF((ngsolve.x, ngsolve.y)), ngsolve.CF((-normal[1], normal[0])).Other()
        self._offset = place + trial - place.Other() - trial.Other()
        self._tangent = along + ngsolve.Grad(trial).Trace().Other() * along
        self._offset_found = place + state - place.Other() - state.Other()
        self._tangent_found = along + ngsolve.Grad(state).Other() * along
        self._bend, self._corner = bend.Other(), corner.Other()
        self._length = strip.linear(strip.lengths, strip.lengths).Other()
        whole = np.ones_like(strip.lengths)
        self._along_wall = strip.linear(0 * whole, whole).Other()

    @property
    def squared(self) -> Any:
        """The square of the gap where it is closed, else 0."""
        height = _height(self._offset_found, self._tangent_found)
        slide = _size(self._offset_found * self._tangent_found) / ngsolve.Norm(self._tangent_found)
        beyond = ngsolve.IfPos(-0.5 - self._corner, slide, 0)
        at_corner = ngsolve.IfPos(-height - beyond, self._offset * self._offset, 0)
        at_corner = ngsolve.IfPos(self._corner - 0.5, 0, at_corner)
        gap = _height(self._offset, self._tangent) - self._correction / 2 * (self._offset * self._tangent) ** 2
        at_foot = ngsolve.IfPos(gap, 0, gap * gap)
        inside = ngsolve.IfPos(self._along_wall * (1 - self._along_wall) - END_TOLERANCE, 1, 0)
        return ngsolve.IfPos(slide - END_TOLERANCE * self._length - inside * self._length, at_corner, at_foot)

    @property
    def _correction(self) -> Any:
        """The curvature correction, frozen where the pair was found."""
        speed2 = self._tangent_found * self._tangent_found
        curvature = _height(self._bend, self._tangent_found) / speed2
        rest = 1 - curvature * _height(self._offset_found, self._tangent_found)
        return curvature / speed2 / ngsolve.IfPos(rest - _LEAST, rest, _LEAST)


def _corners(walls: EdgeSurface, nodes: Array) -> Array:
    """Return what the ends of walls are, shape (facets, 2): 1 if only points outside of the body can be nearest to it.

    Such are convex corners. The end of a surface is -1: points that lie further aside than deep have slid past it. It
    is 0 at other joints, whose side decides.
    """
    corner = np.where(walls.exterior_angle_at(nodes) > BLUNT, 1.0, 0.0)
    return np.where(walls.is_loose_end, -1.0, corner)


def _size(value: Any) -> Any:
    return ngsolve.IfPos(value, value, -value)


def _height(vector: Any, tangent: Any) -> Any:
    """Return the component of a vector along the outward normal of a tangent that has its body on the left."""
    return (vector[0] * tangent[1] - vector[1] * tangent[0]) / ngsolve.Norm(tangent)
