"""Hollow cells as rings of quadrilaterals, swept along their outlines.

A structured ring needs a fifth of the unknowns of a triangulation with the same bending error, matches its
neighbours node by node, and takes milliseconds. The lumen is the outline moved inwards by the thickness of the wall,
each corner along its bisector; nodes stand at the same shares of a side of both.

A corner radius rounds convex corners of the outer wall only. Nodes stand on chords of the arc (`ARC_EDGES` to half a
corner), and elements are curved to it from there. Whatever its angle, a corner loses the same length of wall on both
sides: so neighbours part at the same node.

Stresses are singular at the corners of the lumen, which are re-entrant. Graded elements shrink towards them
geometrically, along the wall and through it: each grade adds a node on both sides of a corner, and from the second on a
layer on the side of the lumen. Elements of one grade are parts of those of the grade before, so that what is found on
one mesh is a function on the next (Schwab, p- and hp-Finite Element Methods, 1998).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.outlines import Outlines, following
from ngcell.geometry.rounded import ARC_EDGES, Arcs, arcs_along, round_corners

#: Ratio of the sizes of elements from one grade to the next; 0.15 to 0.2 is best for corners (Schwab 1998, 4.5).
GRADE = 0.2
#: Largest share of a side from a corner to the first graded node; ratio of distances that leaves no sliver; digits in
#: which places along a wall differ.
WIDEST, _SLIVER, _DIGITS = 0.25, 1.3, 12

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Rings:
    """Nodes of the rings of all cells.

    Attributes
    ----------
    nodes : array of float, shape (layers + 1, nodes, 2)
        Nodes of each layer, the outermost first, cell by cell and anticlockwise [length].
    side : array of int, shape (nodes,)
        Side of the outlines that each node of a layer stands on; the first node of a side is its corner.
    counts : array of int, shape (cells,)
        Number of nodes of each cell's layers.
    layers : array of float, shape (layers + 1,)
        Where layers end, as shares of the wall from outside.
    on_arc : array of int, shape (n,)
        Nodes of a layer from which the outer wall goes on to the next along an arc.
    arcs : Arcs, optional
        These arcs; None where no corner is rounded.
    """

    nodes: Array
    side: Index
    counts: Index
    layers: Array
    on_arc: Index
    arcs: Arcs | None = None

    @cached_property
    def cell(self) -> Index:
        """Cell of each node of a layer, shape (nodes,)."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    @cached_property
    def ahead(self) -> Index:
        """The next node of the same layer, shape (nodes,)."""
        return following(self.counts)


def sweep(
    outlines: Outlines,
    *,
    wall: Array | float,
    radius: float,
    edges: Index | int,
    layers: int,
    grading: int = 0,
) -> Rings:
    """Return the nodes of the rings of all cells.

    Parameters
    ----------
    outlines : Outlines
        The cells.
    wall : float or array of float, shape (cells,)
        Thickness of the walls [length].
    radius : float
        Radius of outer corners of 120 degrees [length], >= 0; other ones lose the same length of wall.
    edges : int or array of int, shape (corners,)
        Elements along the straight part of each side.
    layers : int
        Elements through the wall.
    grading : int
        How often elements are graded towards the corners of lumens, >= 0.
    """
    cut = radius / np.sqrt(3)
    places = _side_places(outlines, float(np.mean(wall)), cut, np.broadcast_to(edges, len(outlines.corners)), grading)
    on_side = np.array([len(part) for part in places])
    side, place = np.repeat(np.arange(len(places)), on_side), np.concatenate(places)
    outer = _along(outlines.corners, outlines, side, place)
    counts = np.bincount(outlines.cell, on_side, outlines.cell_count).astype(np.int64)
    on_arc, arcs = np.zeros(0, dtype=np.int64), None
    if cut:
        outer = round_corners(outer, outlines, side, place, cut)
        on_arc, arcs = arcs_along(outer, outlines, side, place, cut, following(counts))
    inner = _along(outlines.moved_inwards(wall), outlines, side, place)
    shares = layer_shares(layers, grading)
    share = shares[:, None, None]
    return Rings((1 - share) * outer + share * inner, side, counts, shares, on_arc, arcs)


def wall_parameters(side: float, cut: float, edges: int, corner: Sequence[float] = ()) -> Array:
    """Return where nodes sit along one side of a sharp outline, in [-1/2, 1/2) of the side.

    Where corners are cut off [length] the ends of the straight part are nodes, and `ARC_EDGES` edges follow to each
    corner. Distances from both corners at which elements are graded, in units of the side and the largest first, leave
    so many edges between the first of them.
    """
    arc = cut / side
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
    return tuple(min(wall / side, WIDEST) * GRADE**step for step in range(grading))


def layer_shares(layers: int, grading: int) -> Array:
    """Return where layers end, as shares of the wall from outside, 0 first; those at the lumen are graded."""
    ends = np.linspace(0, 1, layers + 1)
    return np.concatenate([ends[:-1], [1 - GRADE**step / layers for step in range(1, grading)], ends[-1:]])


def _side_places(outlines: Outlines, wall: float, cut: float, edges: Index, grading: int) -> list[Array]:
    """Return where nodes sit on each side, in [0, 1) of it, the same on both faces of a wall.

    Sides of a length, to as many digits as places have, have the same places.
    """
    one = np.where(outlines.twins >= 0, np.minimum(outlines.twins, np.arange(len(edges))), np.arange(len(edges)))
    scale = outlines.lengths.max()
    kinds, kind = np.unique(
        np.column_stack([(outlines.lengths / scale).round(_DIGITS), edges])[one], axis=0, return_inverse=True
    )
    places = [
        0.5 + wall_parameters(share * scale, cut, int(number), corner_distances(share * scale, wall, grading))
        for share, number in kinds
    ]
    return [places[number] for number in kind.ravel()]


def _along(corners: Array, outlines: Outlines, side: Index, place: Array) -> Array:
    """Return the points at these places along the sides of polygons with these corners, shape (nodes, 2)."""
    return np.asarray(corners[side] + (corners[outlines.ahead] - corners)[side] * place[:, None])
