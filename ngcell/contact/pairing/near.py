"""Facets that may touch and are near each other: all that contact has to look at."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.surface.surface import Surface
from ngcell.geometry.near import near_pairs

Array = NDArray[np.float64]
Index = NDArray[np.int64]
#: A distance [length], or one of each body, shape (bodies,): of two bodies the smaller one counts.
Reach = float | Array


def reach_between(walls: Surface, reach: Reach, one: Index, two: Index) -> Array:
    """Return the reach of pairs of facets [length]."""
    of_body = np.broadcast_to(reach, walls.thickness.shape)
    return np.asarray(np.minimum(of_body[walls.body[one]], of_body[walls.body[two]]))


class NearFacets:
    """Ordered pairs of facets that may touch within reach, kept while nothing has moved far.

    Parameters
    ----------
    walls : Surface
        The walls.
    reach : float or array of float, shape (bodies,)
        Distance up to which no pair is missed [length].
    """

    def __init__(self, walls: Surface, reach: Reach) -> None:
        self._walls = walls
        self._reach = reach
        self._found: tuple[Array, tuple[Index, Index]] | None = None

    def pairs(self, nodes: Array) -> tuple[Index, Index]:
        """Return the pairs at deformed nodes of shape (facets, nodes, dimension) [length]; some may be out of reach."""
        margin = float(np.min(self._reach))
        if self._found is None or np.abs(nodes - self._found[0]).max(initial=0.0) > margin / 2:
            self._found = nodes, near_facets(self._walls, nodes, self._reach + 2 * margin)
        return self._found[1]


def near_facets(walls: Surface, nodes: Array, reach: Reach) -> tuple[Index, Index]:
    """Return all ordered pairs of facets that may touch and are nearer than `reach` [length]."""
    middle = walls.middles(nodes)
    half = np.linalg.norm(nodes - middle[:, None], axis=2).max(1)
    one, two = near_pairs(middle, float(np.max(reach)) + 2 * float(half.max(initial=0.0)))
    distance = np.linalg.norm(middle[one] - middle[two], axis=1)
    near = walls.may_touch(one, two) & (distance < reach_between(walls, reach, one, two) + half[one] + half[two])
    one, two = one[near], two[near]
    return np.concatenate([one, two]), np.concatenate([two, one])


def facing(walls: Surface, nodes: Array, one: Index, two: Index, limit: float) -> NDArray[np.bool_]:
    """Return which pairs of facets face each other: the product of their chords' normals lies below `limit`."""
    normal = walls.chord_normals(nodes)
    return np.asarray(np.einsum("ed,ed->e", normal[one], normal[two]) < limit)


def adjacency(walls: Surface, nodes: Array, reach: Reach) -> sparse.csr_array:
    """Return which facets are the same or nearer than `reach` [length], shape (facets, facets)."""
    one, two = near_facets(walls, nodes, reach)
    near = sparse.csr_array((np.ones(len(one)), (one, two)), shape=(walls.facet_count,) * 2)
    return (near + sparse.eye_array(walls.facet_count)).tocsr()


def couplings_of_near_facets(walls: Surface, positions: Array, reach: Reach) -> tuple[Index, Index]:
    """Return rows and columns of all scalar unknowns of facets that are the same, or nearer than `reach` [length]."""
    near = adjacency(walls, walls.nodes(positions), reach)
    touches = walls.touches(positions.shape[1])
    row, column = (touches.T @ near @ touches).tocoo().coords
    return row.astype(np.int64), column.astype(np.int64)
