"""Solids that a user drew, as one mesh of separate bodies of tetrahedra: the counterpart of `ngcell.geometry.shapes`.

The solids go to Netgen side by side and are never glued: where two bodies touch, each has its own vertices. The rules
for walls are those of planar faces, with shells in place of loops: the outer shell of a body is a wall, and that of a
hole is one if another body lies in it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import netgen.meshing
import ngsolve
import numpy as np
from netgen import occ
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.enclosure import winding_numbers
from ngcell.geometry.near import components
from ngcell.scene.bodies import PLAIN_NAME

Array = NDArray[np.float64]

#: Default size of elements as a share of the smallest thickness.
_SIZE = 0.5


@dataclass(frozen=True, eq=False)
class _Shell:
    """A closed boundary of a body: which body, which of Netgen's faces, and its triangles, shape (n, 3, 3)."""

    body: int
    faces: frozenset[int]
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
    thickness = min(2 * abs(solid.mass) / sum(face.mass for face in solid.faces) for solid in solids)
    mesh = _netgen_mesh(solids, names, _SIZE * thickness if size is None else size)
    shells = _shells(mesh)
    walls = _name_boundaries(mesh, shells, names) - set(untouched)
    body = np.asarray(mesh.Elements3D().NumPy()["index"], dtype=np.int64) - 1
    for number, name in enumerate(names):
        mesh.SetMaterial(number + 1, name)
    return BodyMesh(
        mesh=ngsolve.Mesh(mesh).Curve(order),
        body_of_element=body,
        body_names=tuple(names),
        wall_names="|".join(sorted(walls)),
        length=min(shell.diagonal for shell in _outlines(shells).values()) / 2,
        thickness=thickness,
    )


def _solid(shape: occ.TopoDS_Shape, name: str) -> occ.Solid:
    if len(shape.solids) != 1:
        raise GeometryError(f"body {name}: its shape has {len(shape.solids)} solids; allowed: one solid a body")
    return shape.solids[0]


def _netgen_mesh(solids: Sequence[occ.Solid], names: Sequence[str], size: float) -> netgen.meshing.Mesh:
    # Netgen's threads wait for each other a hundred times longer than a small mesh takes, and number points by chance.
    meshing = netgen.meshing.MeshingParameters(maxh=size, parallel_meshing=False)
    try:
        mesh = occ.OCCGeometry(occ.Compound(list(solids)), dim=3).GenerateMesh(mp=meshing)
    except Exception as error:  # noqa: BLE001 - Netgen raises its own and standard exceptions alike
        raise GeometryError(f"bodies {', '.join(names)}: Netgen cannot mesh them ({error})") from error
    if not _are_apart(mesh, len(solids)):
        raise GeometryError(
            f"bodies {', '.join(names)}: two of them are the same solid or share a face; allowed: shapes of "
            "their own, which may touch (do not Glue them, and Move a copy instead of repeating a solid)"
        )
    return mesh


def _are_apart(mesh: netgen.meshing.Mesh, bodies: int) -> bool:
    """Return whether all bodies have elements, and no point is used by two of them."""
    elements = mesh.Elements3D().NumPy()
    corners = np.column_stack([elements["nodes"][:, :4].ravel(), np.repeat(elements["index"], 4)])
    owners = np.unique(corners, axis=0)
    return len(np.unique(owners[:, 0])) == len(owners) and len(np.unique(owners[:, 1])) == bodies


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


def _outlines(shells: Sequence[_Shell]) -> dict[int, _Shell]:
    """Return the outer shell of each body: its largest."""
    return {shell.body: shell for shell in sorted(shells, key=lambda shell: shell.diagonal)}


def _name_boundaries(mesh: netgen.meshing.Mesh, shells: Sequence[_Shell], names: Sequence[str]) -> set[str]:
    """Name the faces that have no name, and return the names of walls."""
    elements = mesh.Elements3D().NumPy()
    centres = mesh.Coordinates()[elements["nodes"][:, :4] - 1].mean(1)
    outlines, holes, walls = _outlines(shells), [0] * len(names), set()
    for shell in shells:
        kind, is_wall = "outline", True
        if shell is not outlines[shell.body]:
            kind = f"hole{holes[shell.body]}"
            is_wall = shell.encloses(centres[elements["index"] - 1 != shell.body])
            holes[shell.body] += 1
        for face in shell.faces:
            name = _named(mesh, face, f"{names[shell.body]}_{kind}")
            walls |= {name} if is_wall else set()
    return walls


def _named(mesh: netgen.meshing.Mesh, face: int, otherwise: str) -> str:
    """Return the name of a face, after giving it one if it had none."""
    name = str(mesh.GetBCName(face - 1))
    if name == "default":
        mesh.SetBCName(face - 1, otherwise)
        return otherwise
    if not PLAIN_NAME.fullmatch(name):
        raise GeometryError(f"face name {name!r}; allowed: letters, digits, _ and -")
    return name
