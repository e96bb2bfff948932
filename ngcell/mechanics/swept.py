"""What a boundary under pressure sweeps as it moves: an area in the plane, a volume in three dimensions.

The pressure's potential is the pressure times that. A boundary that moves from X to X + u in a straight line sweeps

    integral of u . (N + cof(F) N) / 2                              in the plane,
    integral of u . (N + (cof(F) N - N - cof(G) N) / 2 + cof(G) N / 3)     in three dimensions,    F = I + G, G = grad
    u,

with N the outward normal at rest; ``cof(F) N`` needs derivatives along the boundary only. The variation of this is the
force ``cof(F) N`` plus a term at the boundary's rim that is linear in ``u x du``, so it vanishes where

- there is no rim, or what follows is under the same pressure;
- the rim is held: du = 0 there, even if its support moves;
- it slides along a straight line, or in three dimensions in a plane, that stays in place.

At sliding rims the term presses against the support; it is taken out of the forces, so that supports bear what the
pressure hands to them.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.errors import CaseError
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of the largest pressure below which a difference of pressures is round-off.
_ROUND_OFF = 1e-12
#: Share of the extent by which a rim may be off a plane.
_FLAT = 1e-9


class SweptArea:
    """Areas that lines in the plane sweep.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    pressures : mapping of str to float
        Pressure on each boundary region [stress].
    """

    def __init__(self, space: DisplacementSpace, pressures: Mapping[str, float]) -> None:
        self._space = space
        edges = _directed_edges(space.mesh)
        self.outward = _outward_signs(space.mesh, edges)
        self._ends = _ends(space, edges, pressures)

    def swept(self, displacement: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        """Return the area swept for each reference length."""
        along, normal = ngsolve.Grad(displacement).Trace(), ngsolve.specialcf.normal(2)
        turned_x = along[1, 1] * normal[0] - along[1, 0] * normal[1]
        turned_y = along[0, 0] * normal[1] - along[0, 1] * normal[0]
        return displacement[0] * (normal[0] + turned_x / 2) + displacement[1] * (normal[1] + turned_y / 2)

    def at_rims(self, displacement: Array, factor: float) -> Array:
        """Return ``-p/2 [u x du]`` of all lines as nodal forces [stress * length], shape (unknowns,)."""
        u_x, u_y = displacement.reshape(2, -1)
        return np.asarray(factor / 2 * np.concatenate([self._ends * u_y, -self._ends * u_x]))

    def check(self, motion: PrescribedMotion) -> None:
        """Raise CaseError if an end of a line may move freely."""
        moved = motion.imposed(np.zeros(self._space.unknowns), 1.0).reshape(motion.fixed.shape)
        is_held = motion.fixed.all(0)
        slides_along_what_stays = motion.fixed.any(0) & (moved == 0).all(0)
        for end in np.flatnonzero((self._ends != 0) & ~is_held & ~slides_along_what_stays):
            x, y = self._space.rest[:, end]
            raise CaseError(
                f"pressure: its line ends at ({x:.6g}, {y:.6g}), which may move freely; allowed: an end that is held, "
                "or that slides along a support which stays in place (a Traction may end anywhere)"
            )


class SweptVolume:
    """Volumes that surfaces in three dimensions sweep; parameters as for `SweptArea`."""

    def __init__(self, space: DisplacementSpace, pressures: Mapping[str, float]) -> None:
        self._space, self._pressures = space, pressures
        self.outward = _outward_faces(space.mesh)
        self._rim = _rim(space, pressures)

    def swept(self, displacement: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        """Return the volume swept for each reference area."""
        along, normal = ngsolve.Grad(displacement).Trace(), ngsolve.specialcf.normal(3)
        turned, bent = ngsolve.Cof(ngsolve.Id(3) + along) * normal, ngsolve.Cof(along) * normal
        return displacement * (normal / 2 + turned / 2 - bent / 6)

    def at_rims(self, displacement: Array, factor: float) -> Array:
        """Return minus the term of all rims as nodal forces [stress * length**2], shape (unknowns,)."""
        if not len(self._rim):
            return np.zeros(self._space.unknowns)
        at = self._space.function(displacement)
        slope = at.vec.CreateVector()
        self._potential.Apply(at.vec, slope)
        return np.asarray(factor * (self._force(at) - slope.FV().NumPy()))

    def check(self, motion: PrescribedMotion) -> None:
        """Raise CaseError if a rim may move freely."""
        moved = motion.imposed(np.zeros(self._space.unknowns), 1.0).reshape(motion.fixed.shape)
        stays = motion.fixed & (moved == 0)
        flat = _FLAT * np.ptp(self._space.bodies.extent)
        for edge in self._rim:
            mesh_edge = self._space.mesh[ngsolve.NodeId(ngsolve.EDGE, int(edge))]
            ends = [vertex.nr for vertex in mesh_edge.vertices]
            unknowns = ends + list(self._space.scalar.GetDofNrs(mesh_edge))
            in_plane = np.ptp(self._space.rest[:, ends], axis=1) <= flat
            if motion.fixed[:, unknowns].all() or (stays[:, unknowns].all(1) & in_plane).any():
                continue
            x, y, z = self._space.rest[:, ends].mean(1)
            raise CaseError(
                f"pressure: its surface ends at ({x:.6g}, {y:.6g}, {z:.6g}), where it may move freely; allowed: a rim "
                "that is held, or that slides in a plane x, y or z = const. whose support stays in place (a Traction "
                "may end anywhere)"
            )

    @cached_property
    def _potential(self) -> ngsolve.BilinearForm:
        form = ngsolve.BilinearForm(self._space.vector, symmetric=True)
        trial = self._space.vector.TrialFunction()
        for region, pressure in self._pressures.items():
            where = ngsolve.ds(definedon=self._space.mesh.Boundaries(region))
            form += ngsolve.Variation(pressure * self.outward * self.swept(trial) * where)
        return form

    def _force(self, at: ngsolve.GridFunction) -> Array:
        form, test = ngsolve.LinearForm(self._space.vector), self._space.vector.TestFunction()
        along, normal = ngsolve.Grad(at), ngsolve.specialcf.normal(3)
        turned = ngsolve.Cof(ngsolve.Id(3) + along) * normal
        for region, pressure in self._pressures.items():
            where = ngsolve.ds(definedon=self._space.mesh.Boundaries(region))
            form += pressure * self.outward * (turned * test.Trace()) * where
        form.Assemble()
        return np.array(form.vec.FV().NumPy())


def swept_by(space: DisplacementSpace, pressures: Mapping[str, float]) -> SweptArea | SweptVolume:
    """Return what the boundaries under pressure sweep."""
    return SweptArea(space, pressures) if space.dimension == 2 else SweptVolume(space, pressures)


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
    return _signs(mesh, along_y * flux_x - along_x * flux_y)


def _outward_faces(mesh: ngsolve.Mesh) -> ngsolve.GridFunction:
    """Return the sign that turns NGSolve's normal of each boundary face out of the body."""
    points = np.array([vertex.point for vertex in mesh.vertices])
    normal = ngsolve.specialcf.normal(3)
    flux = np.array([ngsolve.Integrate(normal[axis], mesh, ngsolve.BND, element_wise=True) for axis in range(3)])
    outward = []
    for face in mesh.Elements(ngsolve.BND):
        inside = mesh[mesh[face.faces[0]].elements[0]]
        centres = [points[[vertex.nr for vertex in element.vertices]].mean(0) for element in (face, inside)]
        outward.append(centres[0] - centres[1])
    return _signs(mesh, np.einsum("dn,nd->n", flux, np.array(outward)))


def _signs(mesh: ngsolve.Mesh, numbers: Array) -> ngsolve.GridFunction:
    """Return a function of the signs of numbers of all boundary elements."""
    signs = ngsolve.GridFunction(ngsolve.SurfaceL2(mesh, order=0))
    for element, sign in zip(mesh.Elements(ngsolve.BND), np.sign(numbers), strict=True):
        signs.vec[signs.space.GetDofNrs(element)[0]] = float(sign)
    return signs


def _ends(space: DisplacementSpace, edges: Index, pressures: Mapping[str, float]) -> Array:
    """Return at each scalar unknown the pressures on lines that end there minus those on lines that start there."""
    boundary = space.mesh.Elements(ngsolve.BND)
    on_edge = np.array([pressures.get(edge.mat, 0.0) for edge in boundary])
    tail, head = edges.T
    ends = np.bincount(head, on_edge, space.size) - np.bincount(tail, on_edge, space.size)
    return np.where(np.abs(ends) > _ROUND_OFF * np.abs(on_edge).max(), ends, 0.0)


def _rim(space: DisplacementSpace, pressures: Mapping[str, float]) -> Index:
    """Return the mesh edges where faces under different pressures meet."""
    mesh = space.mesh
    low, high = np.full(mesh.nedge, np.inf), np.full(mesh.nedge, -np.inf)
    for face in mesh.Elements(ngsolve.BND):
        edges, pressure = [edge.nr for edge in face.edges], pressures.get(face.mat, 0.0)
        low[edges], high[edges] = np.minimum(low[edges], pressure), np.maximum(high[edges], pressure)
    largest = max(map(abs, pressures.values()), default=0.0)
    return np.flatnonzero(np.isfinite(low) & (high - low > _ROUND_OFF * largest))
