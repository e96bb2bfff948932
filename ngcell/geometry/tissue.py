"""The tissue of a case as a mesh: lattice, rings, and the hull walls that its load holds or moves."""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.bodies import LOWER_END, UPPER_END, BodyMesh
from ngcell.geometry.lattice import Lattice, hexagonal_lattice
from ngcell.geometry.rings import ring_mesh, ring_section
from ngcell.scene import Ends, Frame, Load, MeshChoice, Tissue

#: Names of the supported regions.
LOWER_PLATE, UPPER_PLATE, FRAME = "lower-plate", "upper-plate", "frame"
#: Regular expression of the ends of prisms.
ENDS = f"{UPPER_END}|{LOWER_END}"

#: Default edges: at most this many wall thicknesses long, and at least this many to a side.
_SLENDERNESS, _FEWEST_EDGES = 5.0, 2


def tissue_mesh(
    tissue: Tissue,
    load: Load,
    choice: MeshChoice,
    lumens: dict[str, NDArray[np.int64]] | None = None,
    *,
    filled: bool = False,
) -> BodyMesh:
    """Return the mesh of a tissue, one body a cell, with the regions that the load needs, and those of `lumens`:
    the cells whose inner walls belong to each; `filled` lumens hold elements."""
    lattice = hexagonal_lattice(tissue.rows, tissue.cols, side=tissue.side, pointy=tissue.orientation == "pointy")
    edges, layers = mesh_density(tissue, choice)
    choices: dict[str, Any] = {
        "wall": tissue.wall,
        "radius": tissue.corner_radius,
        "edges": edges,
        "layers": layers,
        "supports": supported_walls(lattice, load),
        "filled": filled,
    }
    if tissue.height is None:
        return ring_mesh(lattice, lumens=lumens, **choices)
    from ngcell.geometry.prisms import prism_mesh

    slices = choice.slices or max(1, ceil(tissue.height / tissue.side * edges - 1e-9))
    closed, cells = tissue.end_wall is not None, tissue.rows * tissue.cols
    sections = [
        ring_section(lattice, **choices, lumens=_of_layer(layer, cells, lumens), closed=closed)
        for layer in range(tissue.layers)
    ]
    return prism_mesh(*sections, height=tissue.height, slices=slices, end_wall=tissue.end_wall)


def _of_layer(
    layer: int, cells: int, lumens: dict[str, NDArray[np.int64]] | None
) -> dict[str, NDArray[np.int64]] | None:
    """Return the cells of each region that are in a layer of so many cells, by their numbers in it."""
    if lumens is None:
        return None
    return {name: member[member // cells == layer] - layer * cells for name, member in lumens.items()}


def mesh_density(tissue: Tissue, choice: MeshChoice) -> tuple[int, int]:
    """Return the number of elements along a side and through the wall."""
    size = choice.size or min(tissue.side / _FEWEST_EDGES, _SLENDERNESS * tissue.wall)
    layers = choice.layers or max(1, round(tissue.wall / size))
    return max(1, ceil(tissue.side / size - 1e-9)), layers


def supported_walls(lattice: Lattice, load: Load) -> dict[str, NDArray[np.bool_]]:
    """Return which walls each supported region consists of, as arrays of shape (cells, 6)."""
    if isinstance(load, Ends):
        return {}
    if isinstance(load, Frame):
        return {FRAME: lattice.neighbours < 0}
    top = int(lattice.row_of_cell.max())
    return {LOWER_PLATE: lattice.hull_walls(0, -1), UPPER_PLATE: lattice.hull_walls(top, 1)}
