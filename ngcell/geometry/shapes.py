"""Faces that a user drew, as one mesh of separate bodies.

The faces are never glued: where two bodies touch, each has its own vertices. Those that touch at rest are meshed
together, all others apart (`ngcell.geometry.groups`).
Elements are curved with the order of the displacement, so that a reference position is a displacement like any
other.

Which boundaries may touch another body follows from how the bodies enclose each other. The *outline* of a body is
a wall. A *hole* is a wall if another body lies in it; a hole that encloses no body is none: what is outside cannot
get in. Supports do not matter: a body may be pressed against a boundary that is held. Boundaries that share a name
are walls together.

Edges without a name are given one, ``<body>_outline`` or ``<body>_hole<number>``, with holes counted in the order
of the face's edges.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import netgen.meshing
import numpy as np
from netgen import occ
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.boundaries import named_bodies
from ngcell.geometry.groups import mesh_bodies
from ngcell.geometry.near import components
from ngcell.scene.entries import check_unique_names
from ngcell.scene.mesh import Refinement

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Height above the plane z = 0, as a share of a face's perimeter, that counts as round-off.
_FLAT = 1e-6


@dataclass(frozen=True, eq=False)
class _Loop:
    """A closed boundary of a body: which body, which of Netgen's edges, and its segments, shape (n, 2, 2)."""

    body: int
    members: frozenset[int]
    segments: Array

    @property
    def diagonal(self) -> float:
        """Diagonal of the bounding box [length]."""
        return float(np.linalg.norm(np.ptp(self.segments.reshape(-1, 2), axis=0)))

    def encloses(self, points: Array) -> bool:
        """Return whether any point, shape (n, 2), is inside: a ray from it crosses an odd number of segments."""
        start, end = self.segments[:, 0], self.segments[:, 1]
        x, y = points[:, :1], points[:, 1:]
        crosses = (start[:, 1] > y) != (end[:, 1] > y)
        rise = np.where(start[:, 1] == end[:, 1], 1.0, end[:, 1] - start[:, 1])
        at = start[:, 0] + (y - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
        return bool(((crosses & (x < at)).sum(1) % 2).any())


def mesh_shapes(
    shapes: Sequence[Any],
    names: Sequence[str],
    *,
    order: int,
    size: float | None = None,
    untouched: Collection[str] = (),
    refinements: Sequence[Refinement] = (),
) -> BodyMesh:
    """Return the mesh of the bodies that the faces outline.

    Parameters
    ----------
    shapes : sequence of netgen.occ shapes
        One planar face each, in the plane z = 0, or one solid each [length]; they are left unchanged.
    names : sequence of str
        Name of each body.
    order : int
        Order of the curved elements, >= 1: that of the displacement.
    size : float, optional
        Largest length of an element's edge [length]; by default half of each body's own thickness. Where the
        shapes have a smaller ``maxh``, that counts.
    untouched : collection of str
        Boundaries that are no walls, wherever they lie.
    refinements : sequence of Refinement
        Where elements are smaller.

    Returns
    -------
    BodyMesh
        Its `length` is half of the diagonal of the smallest body's bounding box; its `thickness` the smallest
        area of a body over half of its perimeter, which for a circular ring is the thickness of its wall.

    Raises
    ------
    GeometryError
        If a shape is no planar face, if shapes share an edge, or if Netgen cannot mesh them.
    """
    check_unique_names(names)
    are_solids = {name: _is_solid(shape, name) for shape, name in zip(shapes, names, strict=True)}
    if any(are_solids.values()):
        if not all(are_solids.values()):
            flat = min(name for name, is_solid in are_solids.items() if not is_solid)
            raise GeometryError(f"body {flat}: its shape is no solid, others are; allowed: all faces or all solids")
        if refinements:
            raise GeometryError("refinements; allowed: in the plane (solids and their faces have a `maxh`)")
        from ngcell.geometry.solids import mesh_solids

        return mesh_solids(shapes, names, order=order, size=size, untouched=untouched)
    faces = [_face(shape, name) for shape, name in zip(shapes, names, strict=True)]
    thicknesses = [2 * abs(face.mass) / sum(edge.mass for edge in face.edges) for face in faces]
    mesh = mesh_bodies(faces, names, thicknesses, size, lambda largest: _meshing(largest, refinements))
    loops = _loops(mesh)
    elements = mesh.Elements2D().NumPy()
    body = np.asarray(elements["index"], dtype=np.int64) - 1
    centres = mesh.Coordinates()[elements["nodes"][:, :3] - 1].mean(1)[:, :2]
    return named_bodies(
        mesh, loops, names, body, centres=centres, order=order, thicknesses=thicknesses, untouched=untouched
    )


def check_boundaries(bodies: BodyMesh, wanted: Sequence[str], *, wanted_by: str = "support") -> None:
    """Check that a mesh has the boundaries that supports or loads ask for.

    Raises
    ------
    GeometryError
        If one of them is missing.
    """
    known = sorted(set(bodies.mesh.GetBoundaries()))
    for name in wanted:
        if name not in known:
            near = get_close_matches(name, known, 1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise GeometryError(f"{wanted_by} {name}: no such boundary{hint}; allowed: {', '.join(known)}")


def _is_solid(shape: Any, name: str) -> bool:
    if not isinstance(shape, occ.TopoDS_Shape):
        raise GeometryError(f"body {name}: its shape is {shape!r}; allowed: a face or a solid made with netgen.occ")
    return bool(len(shape.solids))


def _face(shape: occ.TopoDS_Shape, name: str) -> occ.Face:
    """Return the only face of a shape."""
    if len(shape.faces) != 1:
        raise GeometryError(f"body {name}: its shape has {len(shape.faces)} faces; allowed: one face a body")
    face = shape.faces[0]
    # A bounding box would do, but for the fixed tolerance that it is padded with.
    heights = [vertex.p.z for vertex in face.vertices] + [part.center.z for part in (face, *face.edges)]
    if max(map(abs, heights)) > _FLAT * sum(edge.mass for edge in face.edges):
        raise GeometryError(
            f"body {name}: its face reaches from z = {min(heights):g} to {max(heights):g}; allowed: the plane z = 0"
        )
    return face


def _meshing(size: float, refinements: Sequence[Refinement]) -> netgen.meshing.MeshingParameters:
    """Return the sizes of elements; Netgen restricts them at points, so a circle is covered with points."""
    meshing = netgen.meshing.MeshingParameters(maxh=size)
    for circle in refinements:
        steps = np.arange(-circle.within, circle.within + circle.size, circle.size)
        offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        for x, y in offsets[np.linalg.norm(offsets, axis=1) <= circle.within] + circle.at:
            meshing.RestrictH(float(x), float(y), 0.0, circle.size)
    return meshing


def _loops(mesh: netgen.meshing.Mesh) -> list[_Loop]:
    """Return the closed boundaries of all bodies, in the order of their first edges."""
    points = mesh.Coordinates()
    segments = mesh.Elements1D().NumPy()
    ends = segments["nodes"][:, :2].astype(np.int64) - 1
    edge = segments["index"].astype(np.int64)
    loop = components(len(points), *ends.T)[ends[:, 0]]
    triangles = mesh.Elements2D().NumPy()
    body_of_point = np.zeros(len(points), dtype=np.int64)
    body_of_point[triangles["nodes"][:, :3] - 1] = triangles["index"][:, None] - 1
    members = [np.flatnonzero(loop == number) for number in np.unique(loop)]
    members.sort(key=lambda own: edge[own].min())
    return [
        _Loop(int(body_of_point[ends[own[0], 0]]), frozenset(edge[own].tolist()), points[ends[own], :2])
        for own in members
    ]
