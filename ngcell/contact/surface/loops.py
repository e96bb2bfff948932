"""Boundary edges in the plane, chained by common vertices to closed loops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.edges import EdgeSurface

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def closed_loops(walls: EdgeSurface) -> list[Index]:
    """Return the edges of each closed loop in order, with the body on the left."""
    following = _following(walls).tolist()
    unseen = dict.fromkeys(range(walls.facet_count))
    loops = []
    while unseen:
        chain = [unseen.popitem()[0]]
        while following[chain[-1]] in unseen:
            chain.append(following[chain[-1]])
            del unseen[chain[-1]]
        if following[chain[-1]] == chain[0]:
            loops.append(np.array(chain))
    return loops


def _following(walls: EdgeSurface) -> Index:
    """Return the edge that starts where each edge ends, with its body on the left, or -1; shape (edges,)."""
    start, end = np.where(walls.side[:, None] > 0, walls.vertices, walls.vertices[:, ::-1]).T
    starting = np.full(walls.dofs.max(initial=-1) + 1, -1)
    starting[start] = np.arange(walls.facet_count)
    return np.asarray(starting[end])


def anticlockwise(side: Array, nodes: Array) -> Array:
    """Return the nodes of each edge in the order that has its body on the left."""
    return np.where(side[:, None, None] > 0, nodes, nodes[:, ::-1])


def signed_area(corners: Array) -> float:
    """Return the area within a closed line, > 0 where it runs anticlockwise, shape of corners (corners, 2)."""
    following = np.roll(corners, -1, axis=0)
    return float(np.sum(corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0])) / 2
