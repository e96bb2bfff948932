"""Prismatic cells: the plane through all cells, swept along z, as hexahedra written straight into a Netgen mesh.

Ends of cells are the regions `UPPER_END` and `LOWER_END`. Nothing touches them. A wall of the section is a
wall of the prism. Cells are hollow from end to end, or closed by end walls of one element each; the lumen of a closed
cell has the inner faces of its end walls, too.

Layers of prisms are stacked along z and share no node. Where one stands on another, the ends of both are walls, in the
region `BETWEEN`: end walls of closed cells, and of hollow ones the rims, with what fills them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import ngsolve
import numpy as np
from netgen.meshing import FaceDescriptor, Mesh
from numpy.typing import NDArray

from ngcell.geometry.bodies import BETWEEN, FILLING, LOWER_END, UPPER_END, BodyMesh
from ngcell.geometry.rounded import Rounded
from ngcell.geometry.sections import Section, along_walls, int32

Index = NDArray[np.int64]


def prism_mesh(*sections: Section, height: float, slices: int, end_wall: float | None = None) -> BodyMesh:
    """Return the mesh of all cells, which are numbered layer by layer.

    Parameters
    ----------
    *sections : Section
        The plane through the cells of each layer, the lowest first at z = 0; with caps where there are end walls. They
        differ in the regions of lumens only.
    height : float
        Height of the prisms of a layer [length], > 0.
    slices : int
        Elements along it, between end walls, >= 1.
    end_wall : float, optional
        Thickness of the end walls [length], > 0 and less than half of the height; by default there are none.
    """
    section, layers = sections[0], len(sections)
    heights, inner = np.linspace(0, height, slices + 1), range(slices)
    if end_wall is not None:
        between = np.linspace(end_wall, height - end_wall, slices + 1)
        heights, inner = np.concatenate([[0.0], between, [height]]), range(1, slices + 1)
    last, count = len(heights) - 1, len(section.points)
    cells: list[Index] = []
    fillings: list[Index] = []
    faces: dict[str, list[Index]] = defaultdict(list)
    for layer, mine in enumerate(sections):
        first = layer * count * (last + 1)
        for name, elements in _solids(mine, inner, last):
            (fillings if name == FILLING else cells).append(elements + first)
        for name, elements in _faces(mine, inner, last):
            is_outer = (name, layer) in ((LOWER_END, 0), (UPPER_END, layers - 1))
            faces[BETWEEN if name in (LOWER_END, UPPER_END) and not is_outer else name].append(elements + first)
    solids = [(f"cell{number}", elements) for number, elements in enumerate(cells)]
    solids += [(FILLING, np.concatenate(fillings))] if fillings else []
    used = np.unique(np.concatenate([elements.ravel() for _, elements in solids]))
    level = (height * np.arange(layers)[:, None] + heights).ravel()
    points = np.column_stack([np.tile(section.points, (len(level), 1)), np.repeat(level, count)])[used]
    mesh = Mesh()
    mesh.dim = 3
    mesh.AddPoints(np.ascontiguousarray(points))
    for number, (name, elements) in enumerate(solids, start=1):
        mesh.SetMaterial(number, name)
        mesh.AddElements(dim=3, index=number, data=int32(np.searchsorted(used, elements)), base=0)
    for name, parts in faces.items():
        # A descriptor with a domain on its inner side tells NGSolve which way is out.
        number = mesh.GetNFaceDescriptors() + 1
        descriptor = FaceDescriptor(surfnr=number, domin=1, domout=0, bc=number)
        descriptor.bcname = name
        index = mesh.Add(descriptor)
        mesh.AddElements(dim=2, index=index, data=int32(np.searchsorted(used, np.concatenate(parts))), base=0)
    thickness = min(section.wall, end_wall or section.wall)
    walls = section.wall_names if layers == 1 else f"{section.wall_names}|{BETWEEN}"
    counts = [len(elements) for _, elements in solids]
    is_end_wall = None
    if section.caps is not None:
        rings = [len(quads) * last for name, quads in section.regions if name != FILLING] * layers
        inner_count = sum(counts) - sum(counts[: len(rings)])
        ends = [np.arange(count) >= ring for count, ring in zip(counts, rings, strict=False)]
        is_end_wall = np.concatenate([*ends, np.zeros(inner_count, dtype=bool)])
    return section.body_mesh(
        mesh, counts, thickness, layers=layers, wall_names=walls, is_end_wall=is_end_wall,
        rounded=_rounded(section, counts, layers, last),
    )  # fmt: skip


def along_and_up(bodies: BodyMesh) -> NDArray[np.float64]:
    """Return two unit vectors for each element of prisms, shape (elements, 6), that directions in it are told by.

    In walls around cells they are the direction along the wall and that of the axis. In end walls they are the
    direction around the axis of the cell, and at the upper end that towards it, at the lower end that away from it.
    """
    along = along_walls(bodies.mesh)
    upward = np.tile([0.0, 0.0, 1.0], (len(along), 1))
    if bodies.is_end_wall is not None:
        points = np.array([vertex.point for vertex in bodies.mesh.vertices])
        elements = bodies.mesh.Elements(ngsolve.VOL)
        middle = points[[[vertex.nr for vertex in element.vertices] for element in elements]].mean(1)
        body, end = bodies.body_of_element, bodies.is_end_wall
        # Both ends of a cell are alike, and each is symmetric about the axis.
        count = np.bincount(body[end])
        centre = np.column_stack([np.bincount(body[end], middle[end, at]) / count for at in range(3)])
        outward = middle[end] - centre[body[end]]
        rise, outward[:, 2] = outward[:, 2].copy(), 0.0
        outward /= np.linalg.norm(outward, axis=1)[:, None]
        along[end] = np.cross([0.0, 0.0, 1.0], outward)
        upward[end] = -np.sign(rise)[:, None] * outward
    return np.column_stack([along, upward])


def _solids(section: Section, inner: Sequence[int], last: int) -> list[tuple[str, Index]]:
    """Return the hexahedra of each region; those of end walls belong to their cells."""
    count, solids = len(section.points), []
    for number, (name, quads) in enumerate(section.regions):
        parts = [_swept(quads, count, inner if name == FILLING else range(last))]
        if section.caps is not None and name != FILLING:
            parts.append(_swept(section.caps[number], count, (0, last - 1)))
        solids.append((name, np.concatenate(parts)))
    return solids


def _rounded(section: Section, counts: Sequence[int], layers: int, last: int) -> Rounded | None:
    """Return the hexahedra that follow arcs; regions of all cells, layer by layer, have so many elements."""
    if section.rounded is None:
        return None
    quads = np.cumsum([len(quads) for name, quads in section.regions if name != FILLING])
    cell = np.searchsorted(quads, section.rounded.element, side="right")
    within = section.rounded.element - np.concatenate([[0], quads])[cell]
    first = (np.cumsum(counts) - counts)[np.arange(layers) * len(quads) + cell[:, None]]
    slices = within[:, None, None] * last + np.arange(last)
    return section.rounded.repeated((first[..., None] + slices).reshape(len(cell), -1))


def _faces(section: Section, inner: Sequence[int], last: int) -> list[tuple[str, Index]]:
    """Return the boundary faces of each region, anticlockwise as seen from outside."""
    count, faces = len(section.points), []
    for name, edges in section.edges:
        slices = inner if name in section.lumens else range(last)
        parts = [_swept(edges, count, slices)[:, [0, 1, 3, 2]]]
        if section.caps is not None and name in section.lumens:
            caps = np.concatenate([section.caps[cell] for cell in section.lumens[name]])
            parts += [caps + count, caps[:, ::-1] + count * (last - 1)]
        faces.append((name, np.concatenate(parts)))
    ends = [quads for name, quads in section.regions if name != FILLING or section.caps is None]
    ends += section.caps or []
    end = np.concatenate(ends)
    return [*faces, (UPPER_END, end + count * last), (LOWER_END, end[:, ::-1])]


def _swept(numbers: Index, count: int, slices: Sequence[int]) -> Index:
    """Return prisms over polygons, slice after slice of each; bottom corners first."""
    low = numbers[:, None] + count * np.array(slices)[None, :, None]
    return np.asarray(np.concatenate([low, low + count], axis=2).reshape(-1, 2 * numbers.shape[1]))
