"""Which parts of a lumen are near each other.

A point looks for the nearest point on each side of its own lumen, on edges that it may touch. Where these end, next to
edges that it may not touch, the nearest point is an end of what was looked at and no contact; it is left out. So is a
corner that is the nearest point of one side, unless it is that of both sides that meet there: then one of them has it.
As long as a lumen is open, nothing is looked for in it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.near import Reach, near_facets
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.pairing.search import PairSearch
from ngcell.contact.surface.lumens import LumenSurface
from ngcell.contact.surface.surface import SurfacePoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Distances change by up to this much where coordinates of two points change by half of 1 each.
_DIAGONAL = np.sqrt(2.0)
#: Coordinate up to which a point is the end of its edge: round-off of the projection, no more.
_END = 1e-9


class Closing:
    """Tells which lumens close, and looks again only where something has moved.

    Parameters
    ----------
    lumens : LumenSurface
        The lumens.
    """

    def __init__(self, lumens: LumenSurface) -> None:
        self._lumens = lumens
        self._margin = float(lumens.thickness.min())
        self._open_at: Array | None = None

    def lumens(self, nodes: Array) -> NDArray[np.bool_]:
        """Return which lumens close, shape (loops,), at deformed nodes (edges, nodes, 2)."""
        if self._open_at is not None and np.abs(nodes - self._open_at).max() <= self._margin / 2:
            return self._lumens.closing_at_corners(nodes)
        self._open_at = None
        if not self._lumens.closing_across(nodes, _DIAGONAL * self._margin).any():
            self._open_at = nodes
        return self._lumens.closing(nodes, 0.0)


class LumenSearch(PairSearch):
    """The search for closest points of the same lumen; parameters as for `PairSearch`, and what tells which close."""

    def __init__(self, walls: LumenSurface, points: SurfacePoints, reach: Reach, closing: Closing) -> None:
        super().__init__(walls, points, reach)
        self._lumens, self._closing = walls, closing

    def pairs(self, nodes: Array) -> ContactPairs:
        """Return all contact pairs of a deformed state."""
        pairs, lumens = super().pairs(nodes), self._lumens
        xi, part = pairs.secondary_xi, lumens.part
        beside = lumens.neighbours[pairs.secondary, (xi >= 0.5).astype(int)]
        is_end = np.minimum(xi, 1 - xi) < _END
        beside = np.where(is_end, beside, pairs.secondary)
        is_corner = part[beside] != part[pairs.secondary]
        left_out = is_end & (~lumens.may_touch(pairs.primary, beside) | (is_corner & ~_shared(pairs, beside, part)))
        return pairs.chosen(self._closing.lumens(nodes)[lumens.body[pairs.primary]] & ~left_out)


def _shared(pairs: ContactPairs, beside: Index, part: Index) -> NDArray[np.bool_]:
    """Return which pairs, at an end next to the edge `beside`, have that end for the nearest point of the part beyond
    it, too; of the two pairs only the one with the lower part."""
    mine, beyond = part[pairs.secondary], part[beside]
    first = pairs.point * (int(part.max(initial=0)) + 1)
    key, wanted = first + mine, first + beyond
    order = np.argsort(key)
    other = order[np.minimum(np.searchsorted(key, wanted, sorter=order), max(len(order) - 1, 0))]
    is_there = key[other] == wanted
    same = (pairs.secondary[other] == beside) & (beside[other] == pairs.secondary)
    return np.asarray(is_there & same & (mine < beyond))


def near_in_closing(lumens: LumenSurface, nodes: Array, reach: Reach, margin: float) -> tuple[Index, Index]:
    """Return ordered pairs of edges nearer than reach and margin [length], in lumens that may close within the margin.

    Corners are seen as they close, and not before.
    """
    closes = lumens.closing(nodes, _DIAGONAL * margin)
    if not closes.any():
        nothing = np.zeros(0, dtype=np.int64)
        return nothing, nothing
    one, two = near_facets(lumens, nodes, reach + margin)
    return one[closes[lumens.body[one]]], two[closes[lumens.body[one]]]
