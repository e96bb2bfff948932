"""The lumens of hexagonal cells as quadrilaterals that share the nodes of their walls.

A hexagon is three quadrangles that meet in its centre; each takes the wall's nodes along two of its sides. In a regular
one they are rhombi.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.lattice import WALLS

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Corners of the hexagon that a quadrangle has opposite to the centre.
_TIPS = (1, 3, 5)


def lumen_quads(outlines: Array) -> tuple[Array, Index]:
    """Return the nodes inside each lumen and the quadrilaterals that fill it, the same in all.

    Parameters
    ----------
    outlines : array of float, shape (cells, 6 n, 2)
        Nodes along the inner wall of each cell, counter-clockwise, each n-th one a corner [length].

    Returns
    -------
    points : array of float, shape (cells, 3 n (n - 1) + 1, 2)
        Nodes inside [length].
    quads : array of int, shape (3 n**2, 4)
        Corners, counter-clockwise: numbers up to ``6 n`` are nodes of the outline, further ones those inside.
    """
    edges = outlines.shape[1] // WALLS
    number, first = _numbers(edges)
    quads = np.stack([number[:, :-1, :-1], number[:, :-1, 1:], number[:, 1:, 1:], number[:, 1:, :-1]], axis=-1)
    nodes = np.stack([_quadrangle(outlines, corner, edges) for corner in _TIPS], axis=1)
    return nodes.reshape(len(outlines), -1, 2)[:, first], quads.reshape(-1, 4)


def _numbers(edges: int) -> tuple[Index, Index]:
    """Return the number of each node of the three quadrangles, (3, n + 1, n + 1), and the first node of each number
    that is none of the outline.

    Nodes are told apart in a regular hexagon, by whole multiples of its corners 0 and 2.
    """
    steps = np.arange(edges + 1)
    back, forth = np.meshgrid(edges - steps, edges - steps, indexing="ij")
    corner = np.array([(1, 0), (1, 1), (0, 1), (-1, 0), (-1, -1), (0, -1)])
    ahead = np.roll(corner, -1, axis=0) - corner
    outline = edges * corner[:, None] + ahead[:, None] * steps[:-1, None]
    quadrangles = [
        forth[..., None] * corner[tip - 1] + back[..., None] * corner[(tip + 1) % WALLS] for tip in _TIPS
    ]
    places = np.concatenate([outline.reshape(-1, 2), np.reshape(quadrangles, (-1, 2))])
    _, first, number = np.unique(places, axis=0, return_index=True, return_inverse=True)
    # Number distinct places in the order of their first appearance, so that the outline keeps its numbers.
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    count = WALLS * edges
    return rank[number.ravel()][count:].reshape(3, edges + 1, edges + 1), np.sort(first)[count:] - count


def _quadrangle(outlines: Array, corner: int, edges: int) -> Array:
    """Return the nodes of the quadrangle at a corner of each cell: backwards and forwards along the wall, shape
    (cells, n + 1, n + 1, 2).

    Nodes stand at shares of the way to the next corners: those of the wall at the wall, and the means of all sides at
    the lines that quadrangles share.
    """
    steps = np.arange(edges + 1)
    at, count = corner * edges, outlines.shape[1]
    back, forth = outlines[:, at - steps], outlines[:, (at + steps) % count]
    tip, centre = back[:, :1], outlines[:, ::edges].mean(1)[:, None, None]
    own = [np.linalg.norm(way - tip, axis=2) / np.linalg.norm(way[:, -1:] - tip, axis=2) for way in (back, forth)]
    corners = outlines[:, ::edges, None]
    side = np.linalg.norm(outlines.reshape(len(outlines), WALLS, edges, 2) - corners, axis=3)
    side /= np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=3)
    mean = np.column_stack([side.mean(1), np.ones(len(side))])
    one = own[0][:, :, None] * (1 - mean[:, None]) + mean[:, :, None] * mean[:, None]
    two = own[1][:, None] * (1 - mean[:, :, None]) + mean[:, None] * mean[:, :, None]
    one, two = one[..., None], two[..., None]
    ends = tip[:, :, None], back[:, -1][:, None, None], forth[:, -1][:, None, None]
    return np.asarray(
        (1 - one) * (1 - two) * ends[0] + one * (1 - two) * ends[1] + (1 - one) * two * ends[2] + one * two * centre
    )
