"""From the plane through all cells to a mesh: in the plane, or of prisms in layers on each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.outlines import Outlines
from ngcell.geometry.prisms import prism_mesh
from ngcell.geometry.rings import WIDEST
from ngcell.geometry.sections import ring_mesh, ring_section
from ngcell.geometry.tissues.protocol import Lumens, TissueDensity
from ngcell.scene.scope import refuse

#: A patch beyond this is out of reach of a direct solver on one machine; far more often it is a typing error.
MOST_CELLS = 10_000
#: Default edges: at most this many wall thicknesses long, and at least this many to a side.
SLENDERNESS, FEWEST_EDGES = 5.0, 2


@dataclass(frozen=True)
class Stack:
    """Layers of prisms.

    Attributes
    ----------
    layers : int
        Number of layers, >= 1.
    height : float
        Height of each [length], > 0.
    slices : int
        Elements along it, between end walls, >= 1.
    end_wall : float, optional
        Thickness of walls that close both ends [length].
    """

    layers: int
    height: float
    slices: int
    end_wall: float | None = None


def checked_cols(cols: int, rows: int) -> int:
    """Return the number of cells in a row; refuse one that makes too many with so many rows."""
    if rows * cols > MOST_CELLS:
        allowed = "with rows = {rows} these are {cells} cells; allowed: rows * cols <= {most}"
        refuse(allowed, rows=rows, cells=rows * cols, most=MOST_CELLS)
    return cols


def checked_layers(layers: int, height: float | None) -> int:
    """Return the number of layers; refuse more than one of what is no prism."""
    if layers > 1 and height is None:
        refuse("are layers of prisms; allowed: 1, or more with a height")
    return layers


def checked_end_wall(end_wall: float | None, height: float | None) -> float | None:
    """Return the thickness of end walls [length]; refuse one that prisms of this height have no room for."""
    if end_wall is not None and (height is None or 2 * end_wall >= height):
        limit = "height / 2, with a height" if height is None else f"{height / 2:.6g}, half of the height"
        refuse("allowed: 0 < end_wall < {limit}", limit=limit)
    return end_wall


def default_size(side: float, wall: float) -> float:
    """Return the length of an element's edge along walls of this thickness, between cells with this side [length]."""
    return min(side / FEWEST_EDGES, SLENDERNESS * wall)


def edges_along(lengths: NDArray[np.float64], wall: float, size: float, choice: TissueDensity) -> NDArray[np.int64]:
    """Return the number of elements along sides of these lengths [length], between graded ones."""
    graded = 2 * np.minimum(wall / lengths, WIDEST) if choice.grading else 0.0
    whole = np.maximum(1, np.ceil((1 - graded) * lengths / size - 1e-9)).astype(np.int64)
    return np.asarray(whole * 2 ** (choice.halvings or 0))


def through_wall(wall: float, size: float, choice: TissueDensity) -> int:
    """Return the number of elements through a wall, before grading."""
    return choice.layers or max(1, round(wall / size))


def ring_elements(edges: NDArray[np.int64], through: int, choice: TissueDensity, stack: Stack | None) -> int:
    """Return the number of elements of rings with so many edges along each side, before grading; at least."""
    grading = choice.grading or 0
    plane = int((edges + 2 * grading).sum()) * (through + max(grading - 1, 0))
    return plane * (1 if stack is None else stack.slices * stack.layers)


def stacked_mesh(
    outlines: Outlines, stack: Stack | None, lumens: Lumens | None, choices: Mapping[str, Any]
) -> BodyMesh:
    """Return the mesh of cells in the plane, where there is no stack, or of layers of prisms.

    Parameters
    ----------
    outlines : Outlines
        The cells of a layer.
    stack : Stack, optional
        The layers.
    lumens : dict of str to array of int, optional
        Cells of all layers whose inner walls form each region.
    choices : mapping
        Further parameters of `ngcell.geometry.sections.ring_section`.
    """
    if stack is None:
        return ring_mesh(outlines, lumens=lumens, **choices)
    cells, closed = outlines.cell_count, stack.end_wall is not None
    sections = [
        ring_section(outlines, **choices, lumens=_of_layer(layer, cells, lumens), closed=closed)
        for layer in range(stack.layers)
    ]
    return prism_mesh(*sections, height=stack.height, slices=stack.slices, end_wall=stack.end_wall)


def _of_layer(layer: int, cells: int, lumens: Lumens | None) -> Lumens | None:
    """Return the cells of each region that are in a layer of so many cells, by their numbers in it."""
    if lumens is None:
        return None
    return {name: member[member // cells == layer] - layer * cells for name, member in lumens.items()}
