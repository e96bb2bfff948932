"""Surfaces in the plane: boundary edges, with one coordinate ``xi`` in [0, 1] along each.

The outward normal of an edge is its tangent turned by -90 degrees times `side`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.polynomials import Lagrange
from ngcell.contact.surface.sampling import measured, sampled
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.bodies import BodyMesh
from ngcell.mechanics.lobatto import lobatto

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Area of an equilateral triangle over the square of its side.
_TRIANGLE = np.sqrt(3) / 4


@dataclass(frozen=True, eq=False)
class EdgeSurface(Surface):
    """Boundary edges of bodies in the plane; attributes as for `Surface`."""

    basis: Lagrange

    @property
    def directions(self) -> tuple[int]:
        """The first derivative."""
        return (1,)

    def measure(self, *tangents: Array) -> Array:
        """Return the length of the tangent."""
        (tangent,) = tangents
        return np.asarray(np.linalg.norm(tangent, axis=-1))

    def chord_normals(self, nodes: Array) -> Array:
        """Return the outward unit normals of the chords, shape (edges, 2), at deformed nodes."""
        chord = nodes[:, -1] - nodes[:, 0]
        normal = np.column_stack([chord[:, 1], -chord[:, 0]]) * self.side[:, None]
        return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])

    @cached_property
    def is_loose_end(self) -> NDArray[np.bool_]:
        """Whether the surface ends at the start (0) and at the end (1) of an edge, shape (edges, 2)."""
        return np.asarray(np.bincount(self.vertices.ravel())[self.vertices] < 2)

    def exterior_angle_at(self, nodes: Array) -> Array:
        """Return the angle by which the outline turns at both ends of each edge, shape (edges, 2)."""
        slope = np.einsum("ki,eid->ekd", self.basis.values(np.array([0.0, 1.0]), 1), nodes)
        normal = np.stack([slope[..., 1], -slope[..., 0]], axis=-1) * self.side[:, None, None]
        normal = (normal / np.linalg.norm(normal, axis=-1, keepdims=True)).reshape(-1, 2)
        inward = (slope * np.array([1.0, -1.0])[:, None]).reshape(-1, 2)
        order = np.argsort(self.vertices.ravel(), kind="stable")
        same = np.flatnonzero(np.diff(self.vertices.ravel()[order]) == 0)
        one, two = order[same], order[same + 1]
        across = normal[one, 0] * normal[two, 1] - normal[one, 1] * normal[two, 0]
        angle = np.arctan2(np.abs(across), np.einsum("pd,pd->p", normal[one], normal[two]))
        angle = np.where(np.einsum("pd,pd->p", normal[one], inward[two]) > 0, -angle, angle)
        exterior_angle = np.zeros(len(normal))
        exterior_angle[one] = exterior_angle[two] = angle
        return exterior_angle.reshape(-1, 2)


def find_edges(bodies: BodyMesh, scalar_space: ngsolve.H1, rest: Array) -> EdgeSurface:
    """Collect the walls of bodies in the plane; parameters as for `ngcell.contact.surface.find.find_surface`."""
    mesh, basis = bodies.mesh, Lagrange(scalar_space.globalorder)
    elements = list(mesh.Boundaries(bodies.wall_names).Elements())
    dofs, nodal = sampled(scalar_space, elements, basis)
    behind = np.array([mesh[element.edges[0]].elements[0].nr for element in elements], dtype=np.int64)
    nodes = np.einsum("eij,dej->eid", nodal, rest[:, dofs])
    # The tip of a sharp corner presses first and deepest; between Gauss points it would sink into the wall opposite.
    quadrature_points, share = lobatto(basis.order + 2)
    speed = np.linalg.norm(np.einsum("pi,eid->epd", basis.values(quadrature_points, 1), nodes), axis=2)
    length = (share * speed).sum(1)
    area, centre, is_triangle = measured(mesh, behind)
    chord, outward = nodes[:, -1] - nodes[:, 0], (nodes[:, 0] + nodes[:, -1]) / 2 - centre
    return EdgeSurface(
        body=bodies.body_of_element[behind],
        dofs=dofs,
        nodal=nodal,
        side=np.sign(chord[:, 1] * outward[:, 0] - chord[:, 0] * outward[:, 1]),
        basis=basis,
        quadrature_points=quadrature_points,
        weights=share * speed,
        depth=np.where(is_triangle, _TRIANGLE * length, area / length),
        rest=nodes,
        thickness=bodies.thickness_of_body,
    )
