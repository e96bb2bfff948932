"""Solids that a user drew, as one mesh of separate bodies of tetrahedra: the counterpart of `ngcell.geometry.shapes`.

The solids are never glued: where two bodies touch, each has its own vertices. Those that touch at rest are meshed
together, all others apart. The rules for walls are those of planar faces, with shells in place of loops: the outer
shell of a body is a wall, and that of a hole is one if another body lies in it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import netgen.meshing
import numpy as np
from netgen import occ
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.boundaries import named_bodies
from ngcell.geometry.enclosure import winding_numbers
from ngcell.geometry.groups import mesh_bodies
from ngcell.geometry.near import components

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Shell:
    """A closed boundary of a body: which body, which of Netgen's faces, and its triangles, shape (n, 3, 3)."""

    body: int
    members: frozenset[int]
    triangles: Array

    @property
    def diagonal(self) -> float:
        """Diagonal of the bounding box [length]."""
        return float(np.linalg.norm(np.ptp(self.triangles.reshape(-1, 3), axis=0)))

    def encloses(self, points: Array) -> bool:
        """Return whether any point, shape (n, 3), is inside."""
        return bool((np.abs(winding_numbers(points, self.triangles)) > 0.5).any())


def mesh_solids(
    shapes: Sequence[occ.TopoDS_Shape],
    names: Sequence[str],
    *,
    order: int,
    size: float | None = None,
    untouched: Collection[str] = (),
) -> BodyMesh:
    """Return the mesh of the bodies that are solids; parameters and result as for `ngcell.geometry.shapes.mesh_shapes`.

    The `thickness` is the smallest volume of a body over half of its surface.

    Raises
    ------
    GeometryError
        If a shape is no single solid, if shapes share a face, or if Netgen cannot mesh them.
    """
    solids = [_solid(shape, name) for shape, name in zip(shapes, names, strict=True)]
    thicknesses = [2 * abs(solid.mass) / sum(face.mass for face in solid.faces) for solid in solids]
    mesh = mesh_bodies(solids, names, thicknesses, size, _meshing)
    shells = _shells(mesh)
    elements = mesh.Elements3D().NumPy()
    body = np.asarray(elements["index"], dtype=np.int64) - 1
    centres = mesh.Coordinates()[elements["nodes"][:, :4] - 1].mean(1)
    return named_bodies(
        mesh, shells, names, body, centres=centres, order=order, thicknesses=thicknesses, untouched=untouched
    )


def _solid(shape: occ.TopoDS_Shape, name: str) -> occ.Solid:
    if len(shape.solids) != 1:
        raise GeometryError(f"body {name}: its shape has {len(shape.solids)} solids; allowed: one solid a body")
    return shape.solids[0]


def _meshing(size: float) -> netgen.meshing.MeshingParameters:
    """Return sizes of elements; Netgen's threads wait for each other a hundred times longer than a small mesh takes,
    and number points by chance."""
    return netgen.meshing.MeshingParameters(maxh=size, parallel_meshing=False)


def _shells(mesh: netgen.meshing.Mesh) -> list[_Shell]:
    """Return the closed boundaries of all bodies, in the order of their first faces."""
    points, elements, surface = mesh.Coordinates(), mesh.Elements3D().NumPy(), mesh.Elements2D().NumPy()
    body_of_point = np.zeros(len(points), dtype=np.int64)
    body_of_point[elements["nodes"][:, :4] - 1] = elements["index"][:, None] - 1
    corners = surface["nodes"][:, :3].astype(np.int64) - 1
    face = surface["index"].astype(np.int64)
    around = corners.ravel(), np.roll(corners, 1, axis=1).ravel()
    shell = components(len(points), *around)[corners[:, 0]]
    members = [np.flatnonzero(shell == number) for number in np.unique(shell)]
    members.sort(key=lambda own: face[own].min())
    return [
        _Shell(int(body_of_point[corners[own[0], 0]]), frozenset(face[own].tolist()), points[corners[own]])
        for own in members
    ]
