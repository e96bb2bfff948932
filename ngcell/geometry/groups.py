"""Bodies as one Netgen mesh, in which those that touch nothing do not change each other.

Netgen's sizes come from a tree of boxes over all that is meshed together: a further body, however far away, moves
its boxes, and with them the elements of all others. So bodies that touch at rest are meshed together, which makes
elements on both sides of a contact alike in size, and apart from all others. Then bodies are put side by side, with the
geometry of all shapes, in which edges and faces are numbered one shape after the other, so that elements can be curved.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from netgen import meshing, occ
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.boundaries import NETGEN_ERRORS
from ngcell.geometry.near import components
from ngcell.geometry.sections import int32
from ngcell.geometry.sizes import sizes

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Distance as a share of the thinner body's thickness below which two bodies touch at rest.
_TOUCHING = 1e-6
_KIND = {2: ("face", "an edge"), 3: ("solid", "a face")}


@dataclass(frozen=True)
class _Range:
    """Which of a geometry's edges and faces are a body's: how many come before them, and how many there are."""

    body: int
    edges: int
    faces: int
    face_count: int


@dataclass(frozen=True, eq=False)
class _Group:
    """Bodies that touch at rest, and their mesh."""

    members: list[int]
    mesh: meshing.Mesh


def mesh_bodies(
    shapes: Sequence[occ.TopoDS_Shape],
    names: Sequence[str],
    thicknesses: Sequence[float],
    size: float | None,
    parameters: Callable[[float], meshing.MeshingParameters],
) -> meshing.Mesh:
    """Return one mesh of all bodies; elements carry the numbers of their bodies, from 1 on.

    Parameters
    ----------
    shapes : sequence of netgen.occ shapes
        One face or solid each; a smaller ``maxh`` of theirs counts.
    names : sequence of str
        Names of the bodies.
    thicknesses : sequence of float
        Thickness of each body [length].
    size : float or None
        Largest length of an element's edge [length]; by default each body has its own.
    parameters : function
        Returns Netgen's parameters for that length.

    Raises
    ------
    GeometryError
        If two bodies have a common edge or face, or Netgen cannot mesh them.
    """
    dimension = 3 if shapes[0].solids else 2
    whole, each = _geometry(shapes, dimension), [_geometry([shape], dimension) for shape in shapes]
    if len(whole.edges) < sum(len(one.edges) for one in each) or len(whole.faces) < sum(len(one.faces) for one in each):
        kind, part = _KIND[dimension]
        raise GeometryError(
            f"bodies {', '.join(names)}: two of them are the same {kind} or share {part}; allowed: shapes of "
            f"their own, which may touch (do not Glue them, and Move a copy instead of repeating a {kind})"
        )
    numbers, groups = _groups(shapes, thicknesses), []
    for number in np.unique(numbers):
        members = np.flatnonzero(numbers == number).tolist()
        mine, named = [shapes[member] for member in members], [names[member] for member in members]
        with sizes(mine, [thicknesses[member] for member in members], size) as largest:
            groups.append(_Group(members, _meshed(_geometry(mine, dimension), named, parameters(largest))))
    return groups[0].mesh if len(groups) == 1 else _side_by_side(groups, whole, each)


def _geometry(shapes: Sequence[occ.TopoDS_Shape], dimension: int) -> occ.OCCGeometry:
    return occ.OCCGeometry(occ.Compound(list(shapes)), dim=dimension)


def _groups(shapes: Sequence[occ.TopoDS_Shape], thicknesses: Sequence[float]) -> Index:
    """Return the number of each body's group: of those that touch at rest, directly or through others."""
    corners = np.array([[list(corner) for corner in shape.bounding_box] for shape in shapes])
    near = _TOUCHING * np.minimum.outer(thicknesses, thicknesses)
    beyond = (corners[:, None, 0] - corners[None, :, 1]).max(2)
    one, two = np.nonzero(np.tril(np.maximum(beyond, beyond.T) <= near, -1))
    distances = np.array([shapes[a].Distance(shapes[b]) for a, b in zip(one.tolist(), two.tolist(), strict=True)])
    touch = distances <= near[one, two]
    return components(len(shapes), one[touch], two[touch])


def _meshed(geometry: occ.OCCGeometry, names: Sequence[str], how: meshing.MeshingParameters) -> meshing.Mesh:
    try:
        return geometry.GenerateMesh(mp=how)
    except NETGEN_ERRORS as error:
        raise GeometryError(f"bodies {', '.join(names)}: Netgen cannot mesh them ({error})") from error


def _side_by_side(groups: Sequence[_Group], whole: occ.OCCGeometry, each: Sequence[occ.OCCGeometry]) -> meshing.Mesh:
    """Return one mesh of all bodies, with the geometry of all; `each` has that of one."""
    mesh = meshing.Mesh(dim=groups[0].mesh.dim)
    points: list[Array] = []
    mesh.SetGeometry(whole)
    sources = {
        member: (group.mesh, mine)
        for group in groups
        for member, mine in zip(group.members, _ranges([each[member] for member in group.members]), strict=True)
    }
    for body, goal in enumerate(_ranges(each)):
        points.append(_append(mesh, *sources[body], goal, sum(len(part) for part in points)))
    # Adding elements, Netgen moved points to where it believes their surfaces to be.
    mesh.Coordinates()[:] = np.concatenate(points)
    return mesh


def _ranges(geometries: Sequence[occ.OCCGeometry]) -> list[_Range]:
    """Return where edges and faces of each geometry are in that of all."""
    ranges, edges, faces = [], 0, 0
    for body, geometry in enumerate(geometries):
        ranges.append(_Range(body, edges, faces, len(geometry.faces)))
        edges, faces = edges + len(geometry.edges), faces + len(geometry.faces)
    return ranges


def _append(mesh: meshing.Mesh, source: meshing.Mesh, mine: _Range, goal: _Range, point_count: int) -> Array:
    """Append a body to a mesh of so many points, and return its points, shape (points of the body, dimension)."""
    bulk = source.Elements3D().NumPy() if source.dim == 3 else source.Elements2D().NumPy()
    used = np.unique(bulk["nodes"][bulk["index"] == mine.body + 1, : source.dim + 1])
    points = np.ascontiguousarray(source.Coordinates()[used - 1])
    mesh.AddPoints(points)
    faces = {mine.faces + number: goal.faces + number for number in range(1, mine.face_count + 1)}
    for number in faces:
        mesh.Add(_moved_face(source.FaceDescriptors()[number - 1], goal, faces[number]))
    edges = {}
    for number, edge in enumerate(source.EdgeDescriptors(), start=1):
        if edge.fdindex in faces:
            edges[number] = mesh.Add(_moved_edge(edge, goal, edge.edgenr - mine.edges + goal.edges, faces))
    regions = {1: (source.Elements1D(), edges), 2: (source.Elements2D(), faces)}
    if source.dim == 3:
        regions[3] = (source.Elements3D(), {mine.body + 1: goal.body + 1})
    for dimension, (elements, indices) in sorted(regions.items(), reverse=True):
        _add(mesh, dimension, elements.NumPy(), indices, lambda nodes: np.searchsorted(used, nodes) + point_count)
    return points


def _moved_face(face: meshing.FaceDescriptor, goal: _Range, number: int) -> meshing.FaceDescriptor:
    inside, outside = (goal.body + 1 if domain else 0 for domain in (face.domin, face.domout))
    moved = meshing.FaceDescriptor(surfnr=number, domin=inside, domout=outside, bc=number)
    moved.bcname = face.bcname
    return moved


def _moved_edge(
    edge: meshing.EdgeDescriptor, goal: _Range, number: int, faces: Mapping[int, int]
) -> meshing.EdgeDescriptor:
    moved = meshing.EdgeDescriptor()
    moved.edgenr, moved.name, moved.fdindex = number, edge.name, faces[edge.fdindex]
    moved.surfnr = tuple(faces.get(surface, surface) for surface in edge.surfnr)
    moved.domin, moved.domout = (goal.body + 1 if domain else 0 for domain in (edge.domin, edge.domout))
    return moved


def _add(
    mesh: meshing.Mesh,
    dimension: int,
    elements: NDArray[np.void],
    indices: Mapping[int, int],
    numbered: Callable[[Index], Index],
) -> None:
    """Append simplices, those of one index after the other."""
    for index, other in indices.items():
        nodes = elements["nodes"][elements["index"] == index, : dimension + 1]
        data = int32(numbered(nodes))
        mesh.AddElements(dim=dimension, index=other, data=data, base=0, project_geometry=dimension < 3)
