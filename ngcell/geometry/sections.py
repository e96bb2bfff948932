"""The plane through all cells, as rings of quadrilaterals written straight into a Netgen mesh.

Coincident walls have coincident but separate nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ngsolve
import numpy as np
from netgen.meshing import Mesh
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.bodies import FILLING, LUMEN, BodyMesh
from ngcell.geometry.filling import any_lumen_quads, are_three_quadrangles, lumen_quads, smallest_sines
from ngcell.geometry.lattice import WALLS
from ngcell.geometry.outlines import Outlines
from ngcell.geometry.rings import Rings, sweep
from ngcell.geometry.rounded import Rounded

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Section:
    """The plane through all cells: points, quadrilaterals and edges, each of a region.

    Attributes
    ----------
    points : array of float, shape (points, 2)
        Nodes, cell by cell [length].
    regions : list of (str, array of int, shape (n, 4))
        Material regions: each cell, and what fills lumens.
    edges : list of (str, array of int, shape (n, 2))
        Boundary regions: lumens and walls.
    wall_names : str
        Regular expression of the walls.
    cell_count : int
        Number of cells.
    length : float
        The scale of a cell [length].
    wall : float
        Thickness of the thinnest wall [length].
    lumens : dict of str to array of int
        Cells whose inner walls belong to each region that is not a wall.
    caps : list of array of int, shape (n, 4), optional
        Quadrilaterals that close the lumen of each cell, where cells are to be closed.
    filling_counts : array of int, shape (cells,), optional
        Number of quadrilaterals that fill the lumen of each cell, where they are filled.
    rounded : Rounded, optional
        Quadrilaterals, numbered through all regions, that follow arcs, where corners are rounded.
    """

    points: Array
    regions: list[tuple[str, Index]]
    edges: list[tuple[str, Index]]
    wall_names: str
    cell_count: int
    length: float
    wall: float
    lumens: dict[str, Index]
    caps: list[Index] | None = None
    filling_counts: Index | None = None
    rounded: Rounded | None = None

    def body_mesh(
        self,
        mesh: Mesh,
        counts: list[int],
        thickness: float,
        *,
        layers: int = 1,
        wall_names: str | None = None,
        is_end_wall: NDArray[np.bool_] | None = None,
        rounded: Rounded | None = None,
    ) -> BodyMesh:
        """Return the bodies of a mesh, from the numbers of elements of its regions, one after the other: those of all
        cells, layer by layer, and that of all fillings. `wall_names` replace those of the section, and `rounded` tells
        which elements follow arcs."""
        cells = layers * self.cell_count
        body = np.repeat(np.arange(cells), counts[:cells])
        filled, filling = self.filling_counts is not None, np.zeros(0, dtype=np.int64)
        if self.filling_counts is not None:
            slices = counts[-1] // (layers * int(self.filling_counts.sum()))
            filling = np.repeat(np.arange(cells), np.tile(self.filling_counts * slices, layers))
        return BodyMesh(
            mesh=ngsolve.Mesh(mesh),
            body_of_element=np.concatenate([body, filling]),
            body_names=tuple(f"cell{cell}" for cell in range(cells)),
            wall_names=wall_names or self.wall_names,
            length=self.length,
            thickness=thickness,
            is_filling=np.repeat([False, True], [len(body), len(filling)]) if filled else None,
            is_end_wall=is_end_wall,
            is_swept=mesh.dim == 2,
            rounded=rounded,
        )


def ring_section(
    outlines: Outlines,
    *,
    wall: Array | float,
    radius: float,
    edges: Index | int,
    layers: int,
    supports: dict[str, NDArray[np.bool_]],
    grading: int = 0,
    lumens: dict[str, Index] | None = None,
    filled: bool = False,
    closed: bool = False,
) -> Section:
    """Return the plane through all cells.

    Parameters
    ----------
    outlines : Outlines
        The cells.
    wall, radius, edges, layers, grading
        As for `ngcell.geometry.rings.sweep`.
    supports : dict of str to array of bool, shape (corners,)
        Sides that belong to each support; the names become boundary regions. The other outer walls form the
        region ``wall``.
    lumens : dict of str to array of int, optional
        Cells whose inner walls belong to each region; by default one region ``lumen`` of all cells.
    filled : bool
        Whether lumens are filled with elements, bonded to the wall.
    closed : bool
        Whether there are quadrilaterals to close lumens with.
    """
    rings = sweep(outlines, wall=wall, radius=radius, edges=edges, layers=layers, grading=grading)
    cells, rows = outlines.cell_count, len(rings.nodes)
    inside, fillings = _fillings(rings) if filled or closed else ([np.zeros((0, 2))] * cells, [])
    within_lumens = np.array([len(places) for places in inside])
    sizes = rows * rings.counts + within_lumens
    first = np.cumsum(sizes) - sizes
    within = np.arange(len(rings.cell)) - np.repeat(np.cumsum(rings.counts) - rings.counts, rings.counts)
    number = first[rings.cell] + within + rings.counts[rings.cell] * np.arange(rows)[:, None]
    points = np.empty((sizes.sum(), 2))
    is_inside = np.ones(len(points), dtype=bool)
    is_inside[number] = False
    points[number], points[is_inside] = rings.nodes, np.concatenate(inside)
    regions, rounded = _ring_quads(number, rings, cells)
    caps = [quads + start for quads, start in zip(fillings, first + (rows - 1) * rings.counts, strict=False)]
    if filled:
        regions.append((FILLING, np.concatenate(caps)))
    hollow = {} if filled else lumens or {LUMEN: np.arange(cells)}
    return Section(
        points=points,
        regions=regions,
        edges=_named_edges(number, rings, hollow, supports),
        wall_names="|".join(["wall", *supports]),
        cell_count=cells,
        length=outlines.side,
        wall=float(np.min(wall)),
        lumens=hollow,
        caps=caps if closed else None,
        filling_counts=np.array([len(quads) for quads in caps]) if filled else None,
        rounded=rounded,
    )


def ring_mesh(outlines: Outlines, **choices: Any) -> BodyMesh:
    """Return the mesh of all cells in the plane; parameters as for `ring_section`."""
    section = ring_section(outlines, **choices)
    mesh = Mesh()
    mesh.dim = 2
    mesh.AddPoints(np.ascontiguousarray(section.points))
    for dimension, parts in ((2, section.regions), (1, section.edges)):
        for name, numbers in parts:
            region = mesh.AddRegion(name, dim=dimension)
            mesh.AddElements(dim=dimension, index=region, data=int32(numbers), base=0)
    counts = [len(quads) for _, quads in section.regions]
    return section.body_mesh(mesh, counts, section.wall, rounded=section.rounded)


def along_walls(mesh: ngsolve.Mesh) -> Array:
    """Return the direction along its wall of each quadrilateral of rings, or of each hexahedron of prisms, shape
    (elements, dimension).

    It is that from the middle of one end of the element to the middle of the other: in a straight wall the wall's own,
    and in no element that of the wall round the corner.
    """
    points = np.array([vertex.point for vertex in mesh.vertices])
    corners = points[[[vertex.nr for vertex in element.vertices[:4]] for element in mesh.Elements(ngsolve.VOL)]]
    along = corners[:, 1] - corners[:, 0] + corners[:, 2] - corners[:, 3]
    return np.asarray(along / np.linalg.norm(along, axis=1)[:, None])


def int32(numbers: NDArray[Any]) -> NDArray[np.int32]:
    """Return numbers as Netgen takes them."""
    return np.ascontiguousarray(numbers, dtype=np.int32)


def _fillings(rings: Rings) -> tuple[list[Array], list[Index]]:
    """Return the nodes inside each lumen, and the quadrilaterals that fill it; see `ngcell.geometry.filling`."""
    outlines = np.split(rings.nodes[-1], np.cumsum(rings.counts)[:-1])
    points: list[Array] = [np.zeros((0, 2))] * len(outlines)
    quads: list[Index] = [np.zeros((0, 4), dtype=np.int64)] * len(outlines)
    are_hexagons = _are_three_quadrangles(rings)
    alike = np.flatnonzero(are_hexagons)
    if len(alike):
        inside, shared = lumen_quads(np.array([outlines[cell] for cell in alike]))
        for cell, places in zip(alike.tolist(), inside, strict=True):
            points[cell], quads[cell] = places, shared
    on_side = np.bincount(rings.side)
    odd = rings.cell[np.isin(rings.side, np.flatnonzero(on_side % 2))]
    odd = odd[~are_hexagons[odd]]
    if len(odd):
        raise GeometryError(
            f"cell {odd[0]} has a side with an odd number of elements, and its lumen cannot be meshed; allowed: "
            "another mesh.size, or hollow cells, open at their ends"
        )
    for cell, outline in enumerate(outlines):
        if not are_hexagons[cell]:
            points[cell], quads[cell] = any_lumen_quads(outline)
        if smallest_sines(np.concatenate([outline, points[cell]])[quads[cell]]).min() <= 0:
            raise GeometryError(
                f"the mesh in the lumen of cell {cell} is folded; allowed: another mesh.size or mesh.grading, a "
                "smaller corner radius, or hollow cells, open at their ends"
            )
    return points, quads


def _are_three_quadrangles(rings: Rings) -> NDArray[np.bool_]:
    """Return which lumens are hexagons of three quadrangles with as many nodes on all sides, shape (cells,)."""
    is_corner = np.diff(rings.side, prepend=-1) > 0
    on_side = np.bincount(rings.side)[rings.side[is_corner]]
    of_cell = rings.cell[is_corner]
    corners = np.bincount(of_cell, minlength=len(rings.counts))
    first = on_side[np.cumsum(corners) - corners]
    found = (corners == WALLS) & (first == on_side[0])
    found &= np.bincount(of_cell, on_side != first[of_cell], len(corners)) == 0
    places = rings.nodes[-1][is_corner]
    found[found] = are_three_quadrangles(places[found[of_cell]].reshape(-1, WALLS, 2))
    return np.asarray(found)


def _ring_quads(number: Index, rings: Rings, cells: int) -> tuple[list[tuple[str, Index]], Rounded | None]:
    """Return the quadrilaterals of each cell, layer by layer, and those that follow arcs.

    Nodes of layers have the given numbers, shape (layers + 1, n).
    """
    outer, inner = number[:-1], number[1:]
    quads = np.stack([outer, outer[:, rings.ahead], inner[:, rings.ahead], inner], axis=-1).reshape(-1, 4)
    order = np.argsort(quads[:, 0])
    parts = np.split(quads[order], np.cumsum((len(number) - 1) * rings.counts)[:-1])
    regions = [(f"cell{cell}", part) for cell, part in zip(range(cells), parts, strict=True)]
    if rings.arcs is None:
        return regions, None
    place = np.argsort(order).reshape(outer.shape)[:, rings.on_arc].T
    layer = np.tile(np.column_stack([rings.layers[:-1], rings.layers[1:]]), (len(place), 1))
    each = np.repeat(np.arange(len(place)), len(outer))
    return regions, Rounded(place.ravel(), rings.arcs.chosen(each), layer)


def _named_edges(
    number: Index, rings: Rings, hollow: dict[str, Index], supports: dict[str, NDArray[np.bool_]]
) -> list[tuple[str, Index]]:
    """Return the edges (n, 2) of each boundary region: lumens, supports, and the walls that nothing supports."""
    outer = np.column_stack([number[0], number[0, rings.ahead]])
    inner = np.column_stack([number[-1, rings.ahead], number[-1]])
    regions = [(name, inner[np.isin(rings.cell, member)]) for name, member in hollow.items()]
    unsupported = np.ones(int(rings.side.max()) + 1, dtype=bool)
    for name, member in [*supports.items(), ("wall", unsupported)]:
        regions.append((name, outer[np.ravel(member)[rings.side]]))
        unsupported &= ~np.ravel(member)
    return [(name, numbers) for name, numbers in regions if numbers.size]
