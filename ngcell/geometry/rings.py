"""Hollow hexagonal cells as rings of quadrilaterals, written straight into a Netgen mesh.

A structured ring needs a fifth of the unknowns of a triangulation with the same bending error, matches its
neighbours node by node, and takes milliseconds. Coincident walls have coincident but separate nodes.

A corner radius rounds the outer wall only; the arc is resolved by straight edges (`ARC_EDGES` to half a corner),
which lie inside the true arc by less than one percent of the radius.

Stresses are singular at the corners of the lumen, which are re-entrant. Graded elements shrink towards them
geometrically, along the wall and through it: each grade adds a node on both sides of a corner, and from the second on a
layer on the side of the lumen. Elements of one grade are parts of those of the grade before, so that what is found on
one mesh is a function on the next (Schwab, p- and hp-Finite Element Methods, 1998).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import ngsolve
import numpy as np
from netgen.meshing import Mesh
from numpy.typing import NDArray

from ngcell.geometry.bodies import FILLING, LUMEN, BodyMesh
from ngcell.geometry.filling import lumen_quads
from ngcell.geometry.lattice import WALLS, Lattice

ARC_EDGES = 2
#: Ratio of the sizes of elements from one grade to the next; 0.15 to 0.2 is best for corners (Schwab 1998, 4.5).
GRADE = 0.2
#: Largest share of a side from a corner to the first graded node; ratio of distances that leaves no sliver; digits in
#: which places along a wall differ.
_WIDEST, _SLIVER, _DIGITS = 0.25, 1.3, 12

Array = NDArray[np.float64]


def wall_parameters(side: float, radius: float, edges: int, corner: Sequence[float] = ()) -> Array:
    """Return where nodes sit along one wall of the sharp hexagon, in [-1/2, 1/2) of the side.

    With a radius the ends of the straight part are nodes, and `ARC_EDGES` edges follow to each corner. Distances from
    both corners at which elements are graded, in units of the side and the largest first, leave so many edges between
    the first of them.
    """
    arc = radius / np.sqrt(3) / side
    round_off = np.linspace(0, arc, ARC_EDGES + 1) if arc else np.zeros(1)
    graded = [distance for distance in corner if not _is_near(distance, round_off[1:])]
    middle = 0.5 - max(arc, *corner[:1], 0.0)
    end = np.unique([*round_off, *graded])
    straight = np.linspace(-middle, middle, edges + 1)
    return np.unique(np.concatenate([end - 0.5, straight, 0.5 - end]).round(_DIGITS))[:-1]


def _is_near(distance: float, others: Array) -> bool:
    """Return whether a node at this distance would leave a sliver beside others."""
    return bool((np.abs(np.log(distance / others)) < np.log(_SLIVER)).any())


def corner_distances(side: float, wall: float, grading: int) -> tuple[float, ...]:
    """Return the distances from a corner at which elements are graded, in units of the side, the largest first.

    The first is the thickness of the wall, in which the corner is felt, as far as the side allows.
    """
    return tuple(min(wall / side, _WIDEST) * GRADE**step for step in range(grading))


def layer_shares(layers: int, grading: int) -> Array:
    """Return where layers end, as shares of the wall from outside, 0 first; those at the lumen are graded."""
    ends = np.linspace(0, 1, layers + 1)
    return np.concatenate([ends[:-1], [1 - GRADE**step / layers for step in range(1, grading)], ends[-1:]])


def ring_layers(
    lattice: Lattice, *, wall: float, radius: float, edges: int, layers: int, grading: int = 0
) -> Array:
    """Return the nodes of one cell about its centre, outermost layer first; shape (layers + 1, nodes, 2)."""
    coarse = wall_parameters(lattice.side, radius, edges)
    places = wall_parameters(lattice.side, radius, edges, corner_distances(lattice.side, wall, grading))
    inner = _along(lattice, places) * (1 - wall / lattice.apothem)
    outer = _round_corners(_along(lattice, places), lattice, radius)
    if grading and radius:
        # Further nodes stand on the chords of the arc: whatever the grading, the cell is the same.
        known = _round_corners(_along(lattice, coarse), lattice, radius)
        at, asked = (np.add.outer(np.arange(6), part + 0.5).ravel() for part in (coarse, places))
        outer = np.column_stack([np.interp(asked, at, coordinate, period=6) for coordinate in known.T])
    share = layer_shares(layers, grading)[:, None, None]
    return np.asarray((1 - share) * outer + share * inner)


def _along(lattice: Lattice, places: Array) -> Array:
    """Return the points at these places along each wall of the sharp hexagon, shape (6 places, 2)."""
    corners = lattice.corners
    way = (np.roll(corners, -1, axis=0) - corners)[:, None] * (places + 0.5)[:, None]
    return np.asarray((corners[:, None] + way).reshape(-1, 2))


def _round_corners(sharp: Array, lattice: Lattice, radius: float) -> Array:
    """Move the points of the sharp hexagon that a corner radius cuts off onto the arc, towards its centre."""
    if radius == 0:
        return sharp
    nearest = lattice.corners[np.argmax(sharp @ lattice.corners.T, axis=1)]
    centre = nearest * (1 - 2 * radius / np.sqrt(3) / lattice.side)
    ray = sharp - centre
    tangent_length = radius / np.sqrt(3)
    cut_off = np.linalg.norm(sharp - nearest, axis=1) < tangent_length * (1 - 1e-9)
    on_arc = centre + radius * ray / np.linalg.norm(ray, axis=1)[:, None]
    return np.where(cut_off[:, None], on_arc, sharp)


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
    lattice : Lattice
        Where the cells sit.
    wall : float
        Thickness of the walls [length].
    lumens : dict of str to array of int
        Cells whose inner walls belong to each region that is not a wall.
    caps : array of int, shape (cells, n, 4), optional
        Quadrilaterals that close the lumen of each cell, where cells are to be closed.
    """

    points: Array
    regions: list[tuple[str, NDArray[np.int64]]]
    edges: list[tuple[str, NDArray[np.int64]]]
    wall_names: str
    lattice: Lattice
    wall: float
    lumens: dict[str, NDArray[np.int64]]
    caps: NDArray[np.int64] | None = None

    def body_mesh(
        self,
        mesh: Mesh,
        counts: list[int],
        thickness: float,
        *,
        layers: int = 1,
        wall_names: str | None = None,
        is_end_wall: NDArray[np.bool_] | None = None,
    ) -> BodyMesh:
        """Return the bodies of a mesh, from the numbers of elements of its regions, one after the other: those of all
        cells, layer by layer, and that of all fillings. `wall_names` replace those of the section."""
        cells = layers * len(self.lattice.centres)
        body = np.repeat(np.arange(cells), counts[:cells])
        filled = len(counts) > cells
        filling = np.repeat(np.arange(cells), counts[-1] // cells) if filled else np.zeros(0, dtype=np.int64)
        return BodyMesh(
            mesh=ngsolve.Mesh(mesh),
            body_of_element=np.concatenate([body, filling]),
            body_names=tuple(f"cell{cell}" for cell in range(cells)),
            wall_names=wall_names or self.wall_names,
            length=self.lattice.side,
            thickness=thickness,
            is_filling=np.repeat([False, True], [len(body), len(filling)]) if filled else None,
            is_end_wall=is_end_wall,
        )


def ring_section(
    lattice: Lattice,
    *,
    wall: float,
    radius: float,
    edges: int,
    layers: int,
    supports: dict[str, NDArray[np.bool_]],
    grading: int = 0,
    lumens: dict[str, NDArray[np.int64]] | None = None,
    filled: bool = False,
    closed: bool = False,
) -> Section:
    """Return the plane through all cells.

    Parameters
    ----------
    lattice : Lattice
        Where the cells sit.
    wall, radius : float
        Wall thickness and corner radius [length].
    edges, layers : int
        Elements along the straight part of a wall and through it.
    supports : dict of str to array of bool, shape (cells, 6)
        Walls that belong to each support; the names become boundary regions. The other outer walls form the
        region ``wall``.
    grading : int
        How often elements are graded towards the corners of lumens, >= 0.
    lumens : dict of str to array of int, optional
        Cells whose inner walls belong to each region; by default one region ``lumen`` of all cells.
    filled : bool
        Whether lumens are filled with elements, bonded to the wall.
    closed : bool
        Whether there are quadrilaterals to close lumens with.
    """
    ring = ring_layers(lattice, wall=wall, radius=radius, edges=edges, layers=layers, grading=grading)
    layers = len(ring) - 1
    cells, nodes = len(lattice.centres), ring.shape[1]
    layer = np.arange((layers + 1) * nodes).reshape(layers + 1, nodes)
    quads, cell_points = _ring_quads(layer), ring.reshape(-1, 2)
    if filled or closed:
        inside, filling = lumen_quads(ring[-1])
        filling = filling + layer[-1, 0]
        cell_points = np.concatenate([cell_points, inside])
    first_node = len(cell_points) * np.arange(cells)
    regions = [(f"cell{cell}", quads + first) for cell, first in enumerate(first_node)]
    caps = filling + first_node[:, None, None] if filled or closed else None
    if caps is not None and filled:
        regions.append((FILLING, caps.reshape(-1, 4)))
    hollow = {} if filled else lumens or {LUMEN: np.arange(cells)}
    return Section(
        points=(lattice.centres[:, None] + cell_points).reshape(-1, 2),
        regions=regions,
        edges=_named_edges(layer, first_node, hollow, supports),
        wall_names="|".join(["wall", *supports]),
        lattice=lattice,
        wall=wall,
        lumens=hollow,
        caps=caps if closed else None,
    )


def _named_edges(
    layer: NDArray[np.int64],
    first_node: NDArray[np.int64],
    hollow: dict[str, NDArray[np.int64]],
    supports: dict[str, NDArray[np.bool_]],
) -> list[tuple[str, NDArray[np.int64]]]:
    """Return the edges (n, 2) of each boundary region: lumens, supports, and the walls that nothing supports."""
    outer = np.stack([layer[0], np.roll(layer[0], -1)], axis=-1).reshape(WALLS, -1, 2)
    inner = np.stack([np.roll(layer[-1], -1), layer[-1]], axis=-1)
    regions = [(name, first_node[member, None, None] + inner) for name, member in hollow.items()]
    unsupported = np.ones((len(first_node), WALLS), dtype=bool)
    for name, member in [*supports.items(), ("wall", unsupported)]:
        cell, side = np.nonzero(member)
        regions.append((name, outer[side] + first_node[cell][:, None, None]))
        unsupported &= ~member
    return [(name, numbers.reshape(-1, 2)) for name, numbers in regions if numbers.size]


def ring_mesh(lattice: Lattice, **choices: Any) -> BodyMesh:
    """Return the mesh of all cells in the plane; parameters as for `ring_section`."""
    section = ring_section(lattice, **choices)
    mesh = Mesh()
    mesh.dim = 2
    mesh.AddPoints(np.ascontiguousarray(section.points))
    for dimension, parts in ((2, section.regions), (1, section.edges)):
        for name, numbers in parts:
            region = mesh.AddRegion(name, dim=dimension)
            mesh.AddElements(dim=dimension, index=region, data=int32(numbers), base=0)
    return section.body_mesh(mesh, [len(quads) for _, quads in section.regions], section.wall)


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


def _ring_quads(layer: NDArray[np.int64]) -> NDArray[np.int64]:
    outer, inner = layer[:-1], layer[1:]
    corners = [outer, np.roll(outer, -1, axis=1), np.roll(inner, -1, axis=1), inner]
    return np.stack(corners, axis=-1).reshape(-1, 4)


def int32(numbers: NDArray[Any]) -> NDArray[np.int32]:
    """Return numbers as Netgen takes them."""
    return np.ascontiguousarray(numbers, dtype=np.int32)
