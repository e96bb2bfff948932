"""Prismatic cells: the plane through all cells, swept along z, as hexahedra written straight into a Netgen mesh.

Ends of cells are the regions `FRONT`, at the upper end, and `BACK`. They are walls of no other cell, and what is in a
plane section stays what it is: a wall of the section is a wall of the prism.
"""

from __future__ import annotations

import numpy as np
from netgen.meshing import FaceDescriptor, Mesh
from numpy.typing import NDArray

from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.rings import Section, int32

Index = NDArray[np.int64]

FRONT, BACK = "front", "back"


def prism_mesh(section: Section, *, height: float, slices: int) -> BodyMesh:
    """Return the mesh of all cells.

    Parameters
    ----------
    section : Section
        The plane through them, at z = 0.
    height : float
        Height of the prisms [length], > 0.
    slices : int
        Elements along it, >= 1.
    """
    count = len(section.points)
    heights = np.linspace(0, height, slices + 1)
    points = np.column_stack([np.tile(section.points, (slices + 1, 1)), np.repeat(heights, count)])
    mesh = Mesh()
    mesh.dim = 3
    mesh.AddPoints(np.ascontiguousarray(points))
    for number, (name, quads) in enumerate(section.regions, start=1):
        mesh.SetMaterial(number, name)
        mesh.AddElements(dim=3, index=number, data=int32(_swept(quads, count, slices)), base=0)
    for name, edges in section.edges:
        _add_faces(mesh, name, _swept(edges, count, slices)[:, [0, 1, 3, 2]])
    ends = np.concatenate([quads for _, quads in section.regions])
    _add_faces(mesh, FRONT, ends + count * slices)
    _add_faces(mesh, BACK, ends[:, ::-1])
    return section.body_mesh(mesh, slices)


def _swept(numbers: Index, count: int, slices: int) -> Index:
    """Return prisms over polygons, slice after slice of each; bottom corners first."""
    low = numbers[:, None] + count * np.arange(slices)[None, :, None]
    return np.asarray(np.concatenate([low, low + count], axis=2).reshape(-1, 2 * numbers.shape[1]))


def _add_faces(mesh: Mesh, name: str, faces: Index) -> None:
    # A descriptor with a domain on its inner side tells NGSolve which way is out.
    number = mesh.GetNFaceDescriptors() + 1
    descriptor = FaceDescriptor(surfnr=number, domin=1, domout=0, bc=number)
    descriptor.bcname = name
    index = mesh.Add(descriptor)
    mesh.AddElements(dim=2, index=index, data=int32(faces), base=0)
