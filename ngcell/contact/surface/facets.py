"""Surfaces in three dimensions: boundary faces, with two coordinates ``xi`` in the unit triangle or the unit square.

The outward normal of a facet is the cross product of its tangents times `side`. Side k of a facet runs from its corner
k to the next one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.facet_basis import FacetBasis
from ngcell.contact.surface.joints import Joints, find_joints
from ngcell.contact.surface.sampling import measured, sampled
from ngcell.contact.surface.surface import Surface
from ngcell.errors import GeometryError
from ngcell.geometry.bodies import BETWEEN, BodyMesh

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of a facet by which it is continued where walls end.
_CONTINUED = 0.25
#: Volume over area of a regular tetrahedron, for each root of the area of a side.
_TETRAHEDRON = np.sqrt(4 / np.sqrt(3)) * np.sqrt(2 / 3) / 3


@dataclass(frozen=True, eq=False)
class FacetSurface(Surface):
    """Boundary faces of solid bodies; attributes as for `Surface`."""

    basis: FacetBasis

    @property
    def directions(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """The first derivatives by both coordinates."""
        return (1, 0), (0, 1)

    def measure(self, *tangents: Array) -> Array:
        """Return the area that the tangents span."""
        one, two = tangents
        return np.asarray(np.linalg.norm(np.cross(one, two), axis=-1))

    def chord_normals(self, nodes: Array) -> Array:
        """Return the outward unit normals of the planes through the corners, (facets, 3), at deformed nodes.

        That of a quadrilateral is normal to its diagonals.
        """
        corner = np.moveaxis(nodes[:, self.basis.corner_nodes], 1, 0)
        normal = np.cross(corner[2] - corner[0], corner[-1] - corner[1]) * self.side[:, None]
        return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])

    @cached_property
    def joints(self) -> Joints:
        """All sides that two facets share."""
        return find_joints(self.vertices)

    @cached_property
    def is_loose_side(self) -> NDArray[np.bool_]:
        """Whether the surface ends at a side, which no other facet shares then, shape (facets, corners)."""
        is_loose = np.ones(self.vertices.shape, dtype=bool)
        is_loose[self.joints.facet, self.joints.side] = False
        return is_loose

    def exterior_angle_at(self, nodes: Array) -> Array:
        """Return the angle by which the surface turns in the middle of each side, shape (facets, corners)."""
        basis, joints, normals, inwards = self.basis, self.joints, [], []
        middle = (basis.corners + np.roll(basis.corners, -1, axis=0)) / 2
        for facet, side in zip(joints.facet.T, joints.side.T, strict=True):
            one, two = self.tangents(facet, middle[side], nodes)
            normal = np.cross(one, two) * self.side[facet, None]
            normals.append(normal / np.linalg.norm(normal, axis=1)[:, None])
            inwards.append(self.centres(nodes[facet]) - self.places(facet, middle[side], nodes))
        angle = np.arccos(np.clip(np.einsum("pd,pd->p", *normals), -1, 1))
        angle = np.where(np.einsum("pd,pd->p", normals[0], inwards[1]) > 0, -angle, angle)
        exterior_angle = np.zeros((self.facet_count, len(middle)))
        exterior_angle[joints.facet, joints.side] = angle[:, None]
        return exterior_angle

    @cached_property
    def domains(self) -> Array:
        """Corners of the coordinates that are searched on each facet, shape (facets, corners, 2).

        They are those of the unit facet, but where walls end, as at the ends of prisms, the facet is continued by a
        share of itself: bodies whose ends do not quite match press on each other up to there, and a point that slides
        a little past an end neither drops out of contact at once nor changes the direction of its contact force.
        """
        corners = self.basis.corners
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
        return np.asarray(table[self.is_loose_side @ (2 ** np.arange(count)[::-1])])


def find_facets(bodies: BodyMesh, scalar_space: ngsolve.H1, rest: Array) -> FacetSurface:
    """Collect the walls of solid bodies; parameters and errors as for `ngcell.contact.surface.find.find_surface`."""
    mesh, elements = bodies.mesh, list(bodies.mesh.Boundaries(bodies.wall_names).Elements())
    basis = FacetBasis(scalar_space.globalorder, _corner_count(elements))
    dofs, nodal = sampled(scalar_space, elements, basis)
    behind = np.array([mesh[element.faces[0]].elements[0].nr for element in elements], dtype=np.int64)
    nodes = np.einsum("eij,dej->eid", nodal, rest[:, dofs])
    is_level = np.array([element.mat == BETWEEN for element in elements], dtype=bool)
    quadrature_points, share = _rules(basis, is_level)
    tangents = [basis.values(quadrature_points, by) @ nodes for by in ((1, 0), (0, 1))]
    weights = share * np.linalg.norm(np.cross(*tangents), axis=2)
    area = weights.sum(1)
    volume, centre, is_tetrahedron = measured(mesh, behind)
    surface = FacetSurface(
        body=bodies.body_of_element[behind],
        dofs=dofs,
        nodal=nodal,
        side=np.ones(len(elements)),
        basis=basis,
        quadrature_points=quadrature_points,
        weights=weights,
        depth=np.where(is_tetrahedron, _TETRAHEDRON * np.sqrt(area), volume / area),
        rest=nodes,
        thickness=bodies.thickness_of_body,
    )
    outward = surface.middles(nodes) - centre
    surface.side[:] = np.sign(np.einsum("ed,ed->e", surface.chord_normals(nodes), outward))
    return surface


def _corner_count(elements: list[ngsolve.comp.Ngs_Element]) -> int:
    counts = {len(element.vertices) for element in elements} or {3}
    if len(counts) > 1:
        raise GeometryError("walls are of triangles and of quadrilaterals; allowed: one kind of faces")
    return counts.pop()


def _rules(basis: FacetBasis, is_level: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return points, and weights (facets, points): those of the rule of each facet, 0 at points of the other rule."""
    points, share = basis.rule
    if not is_level.any():
        return points, np.tile(share, (len(is_level), 1))
    others, level_share = basis.level_rule
    nowhere = np.zeros(len(share)), np.zeros(len(level_share))
    both = np.concatenate([share, nowhere[1]]), np.concatenate([nowhere[0], level_share])
    return np.concatenate([points, others]), np.where(is_level[:, None], both[1], both[0])
