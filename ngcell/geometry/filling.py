"""The lumen of a hexagonal cell as quadrilaterals that share the nodes of its wall.

A regular hexagon is three rhombi that meet in its centre; each takes the wall's nodes along two of its sides.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.lattice import WALLS

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of the hexagon's size below which two nodes are one.
_SAME = 1e-7


def lumen_quads(outline: Array) -> tuple[Array, Index]:
    """Return the nodes inside the lumen and the quadrilaterals that fill it.

    Parameters
    ----------
    outline : array of float, shape (6 n, 2)
        Nodes along the inner wall, counter-clockwise, each n-th one a corner [length]; symmetric on each side.

    Returns
    -------
    points : array of float, shape (3 n (n - 1) + 1, 2)
        Nodes inside [length].
    quads : array of int, shape (3 n**2, 4)
        Corners, counter-clockwise: numbers up to ``6 n`` are nodes of the outline, further ones those inside.
    """
    edges = len(outline) // WALLS
    rhombi = [_rhombus(outline, corner, edges) for corner in (1, 3, 5)]
    nodes = np.concatenate(rhombi).reshape(-1, 2)
    scale = _SAME * np.ptp(outline, axis=0).max()
    everything = np.concatenate([outline, nodes])
    _, first, number = np.unique(np.round(everything / scale), axis=0, return_index=True, return_inverse=True)
    # Number distinct places in the order of their first appearance, so that the outline keeps its numbers.
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    number = rank[number.ravel()][len(outline) :].reshape(3, edges + 1, edges + 1)
    quads = np.stack([number[:, :-1, :-1], number[:, :-1, 1:], number[:, 1:, 1:], number[:, 1:, :-1]], axis=-1)
    points = everything[np.sort(first)][len(outline) :]
    return points, quads.reshape(-1, 4)


def _rhombus(outline: Array, corner: int, edges: int) -> Array:
    """Return the nodes of the rhombus at a corner: backwards and forwards along the wall, shape (n + 1, n + 1, 2)."""
    at = corner * edges
    steps = np.arange(edges + 1)
    tip = outline[at]
    backwards, forwards = outline[at - steps] - tip, outline[(at + steps) % len(outline)] - tip
    return np.asarray(tip + backwards[:, None] + forwards[None, :])
