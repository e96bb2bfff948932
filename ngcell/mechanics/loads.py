"""Loads on boundaries and in bodies, which grow in proportion to the load factor, as energies.

A *traction* t for each reference length has the potential ``-integral of t . u``, and so has a *body force* for each
reference area.

A *pressure* p > 0 pushes on the body as it deforms. With the outward normal N at rest, its force for each reference
length is ``-p cof(F) N``, and its potential is p times the area that the loaded line sweeps,

    p integral of u . (N + cof(F) N) / 2,        cof(F) N = N + cof(grad u) N.

In the plane ``cof(F) N`` needs derivatives along the line only. Along the line, with the body on the left, the
variation of this potential is the force of the pressure plus ``p/2 [u x du]`` at the ends of the line. So it is the
potential of a pressure where

- the line is closed, or its ends meet lines under the same pressure;
- the end is held: du = 0 there, even if its support moves;
- the end slides along a straight support that stays in place: u and du are parallel there.

A pressure on a line with a free end has no potential at all, and is refused. At sliding ends the term pushes against
the support; it is taken out of the forces, so that supports bear what the pressure hands to them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property

import ngsolve
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.errors import CaseError
from ngcell.mechanics.space import DisplacementSpace, csr_matrix
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.scene import BodyForce, Pressure, Traction

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Load = Pressure | Traction | BodyForce

#: Share of the largest pressure below which a difference of pressures is round-off.
_ROUND_OFF = 1e-12
#: Degrees that integrals of loads get besides those of displacements where loads depend on the place.
_EXTRA_DEGREES = 6


class BoundaryLoads:
    """All loads of a planar scene: their potential, its gradient and its tangent.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    loads : sequence of Pressure, Traction or BodyForce
        The loads; those on the same boundary or body add up.
    motion : PrescribedMotion
        The supports, which hold the ends of lines under pressure.
    in_full : bool
        Whether loads act in full at every load factor above 0, instead of growing with it.

    Attributes
    ----------
    factor : ngsolve.Parameter
        The load factor that energies made with `terms` are taken at.

    Raises
    ------
    CaseError
        If a line under pressure has an end that no support holds, or that slides along a support that moves.
    """

    def __init__(
        self, space: DisplacementSpace, loads: Sequence[Load], motion: PrescribedMotion, *, in_full: bool = False
    ) -> None:
        self._space = space
        self._in_full = in_full
        self._loads = tuple(loads)
        self.factor = ngsolve.Parameter(0.0)
        edges = _directed_edges(space.bodies.mesh)
        self._outward = _outward_signs(space.bodies.mesh, edges)
        self._ends = _ends(space, edges, self._loads)
        _check_ends(space, self._ends, motion)

    def apply(self, load_factor: float) -> None:
        """Set the load factor of all energies that were made with `terms`."""
        self.factor.Set(self.share(load_factor))

    def share(self, load_factor: float) -> float:
        """Return the share of the loads that acts at a load factor."""
        return float(load_factor > 0) if self._in_full else load_factor

    def terms(self, displacement: ngsolve.CoefficientFunction) -> list[ngsolve.comp.SumOfIntegrals]:
        """Return the potential at `factor`, whatever it will be, as integrals over boundaries and bodies."""
        return [self.factor * self._density(load, displacement) * self._measure(load) for load in self._loads]

    def potential(self, displacement: Array, load_factor: float | None = None) -> float:
        """Return the potential [stress * length**2] at a load factor, by default the one applied; zero at rest."""
        with self._at(load_factor):
            return float(self._form.Energy(self._space.function(displacement).vec))

    def gradient(self, displacement: Array, load_factor: float | None = None) -> Array:
        """Return minus the nodal forces of the loads [stress * length], shape (unknowns,).

        At unknowns that are free this is the gradient of the potential.
        """
        at = self._space.function(displacement).vec
        slope = at.CreateVector()
        with self._at(load_factor):
            self._form.Apply(at, slope)
            return np.asarray(slope.FV().NumPy() + self.at_ends(displacement))

    def tangent(self, displacement: Array, load_factor: float | None = None) -> sparse.csr_array:
        """Return the second derivative of the potential [stress], shape (unknowns, unknowns)."""
        with self._at(load_factor):
            self._form.AssembleLinearization(self._space.function(displacement).vec)
        return csr_matrix(self._form.mat)

    def at_ends(self, displacement: Array) -> Array:
        """Return ``-p/2 [u x du]`` of all lines as nodal forces [stress * length], shape (unknowns,).

        It has to be added to the gradient of `terms`.
        """
        u_x, u_y = displacement.reshape(2, -1)
        return np.asarray(self.factor.Get() / 2 * np.concatenate([self._ends * u_y, -self._ends * u_x]))

    @contextmanager
    def _at(self, load_factor: float | None) -> Iterator[None]:
        """Take another load factor for a while."""
        applied = self.factor.Get()
        if load_factor is not None:
            self.apply(load_factor)
        yield
        self.factor.Set(applied)

    @cached_property
    def _form(self) -> ngsolve.BilinearForm:
        form = ngsolve.BilinearForm(self._space.vector, symmetric=True)
        for term in self.terms(self._space.vector.TrialFunction()):
            form += ngsolve.Variation(term)
        return form

    def _density(self, load: Load, displacement: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        """Return the potential for each reference length or area at load factor 1."""
        if not isinstance(load, Pressure):
            along_x, along_y = load.vector(ngsolve.x, ngsolve.y) if callable(load.vector) else load.vector
            return -(along_x * displacement[0] + along_y * displacement[1])
        along, normal = ngsolve.Grad(displacement).Trace(), ngsolve.specialcf.normal(2)
        turned_x = along[1, 1] * normal[0] - along[1, 0] * normal[1]
        turned_y = along[0, 0] * normal[1] - along[0, 1] * normal[0]
        swept = displacement[0] * (normal[0] + turned_x / 2) + displacement[1] * (normal[1] + turned_y / 2)
        return load.value * self._outward * swept

    def _measure(self, load: Load) -> ngsolve.comp.DifferentialSymbol:
        """Return what the potential is integrated over."""
        mesh, extra = self._space.bodies.mesh, 0
        if not isinstance(load, Pressure) and callable(load.vector):
            extra = _EXTRA_DEGREES
        if isinstance(load, BodyForce):
            return ngsolve.dx(definedon=mesh.Materials(load.body), bonus_intorder=extra)
        return ngsolve.ds(definedon=mesh.Boundaries(load.boundary), bonus_intorder=extra)


def _directed_edges(mesh: ngsolve.Mesh) -> Index:
    """Return the vertices of each boundary edge, shape (edges, 2), in the order that has the body on the left."""
    points = np.array([vertex.point for vertex in mesh.vertices])
    edges = []
    for edge in mesh.Elements(ngsolve.BND):
        tail, head = (vertex.nr for vertex in edge.vertices)
        inside = mesh[mesh[edge.edges[0]].elements[0]]
        inward = points[[vertex.nr for vertex in inside.vertices]].mean(0) - points[tail]
        along = points[head] - points[tail]
        edges.append((tail, head) if along[0] * inward[1] > along[1] * inward[0] else (head, tail))
    return np.array(edges)


def _outward_signs(mesh: ngsolve.Mesh, edges: Index) -> ngsolve.GridFunction:
    """Return the sign that turns NGSolve's normal of each boundary edge out of the body."""
    points = np.array([vertex.point for vertex in mesh.vertices])
    normal = ngsolve.specialcf.normal(2)
    flux_x, flux_y = (
        np.array(ngsolve.Integrate(normal[axis], mesh, ngsolve.BND, element_wise=True)) for axis in range(2)
    )
    along_x, along_y = (points[edges[:, 1]] - points[edges[:, 0]]).T
    signs = ngsolve.GridFunction(ngsolve.SurfaceL2(mesh, order=0))
    for edge, sign in zip(mesh.Elements(ngsolve.BND), np.sign(along_y * flux_x - along_x * flux_y), strict=True):
        signs.vec[signs.space.GetDofNrs(edge)[0]] = float(sign)
    return signs


def _ends(space: DisplacementSpace, edges: Index, loads: Sequence[Load]) -> Array:
    """Return at each scalar unknown the pressures on lines that end there minus those on lines that start there."""
    pressure = dict.fromkeys(space.bodies.mesh.GetBoundaries(), 0.0)
    for load in loads:
        if isinstance(load, Pressure):
            pressure[load.boundary] += load.value
    on_edge = np.array([pressure[edge.mat] for edge in space.bodies.mesh.Elements(ngsolve.BND)])
    tail, head = edges.T
    ends = np.bincount(head, on_edge, space.size) - np.bincount(tail, on_edge, space.size)
    return np.where(np.abs(ends) > _ROUND_OFF * np.abs(on_edge).max(), ends, 0.0)


def _check_ends(space: DisplacementSpace, ends: Array, motion: PrescribedMotion) -> None:
    moved = motion.imposed(np.zeros(space.unknowns), 1.0).reshape(motion.fixed.shape)
    is_held = motion.fixed.all(0)
    slides_along_what_stays = motion.fixed.any(0) & (moved == 0).all(0)
    for end in np.flatnonzero((ends != 0) & ~is_held & ~slides_along_what_stays):
        x, y = space.rest[:, end]
        raise CaseError(
            f"pressure: its line ends at ({x:.6g}, {y:.6g}), which may move freely; allowed: an end that is held, or "
            "that slides along a support which stays in place (a Traction may end anywhere)"
        )
