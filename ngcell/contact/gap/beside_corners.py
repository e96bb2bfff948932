"""Gaps of points whose closest points lie next to a convex corner: they fade, and the corner's wall takes over.

A corner that presses on a wall overlaps it by a wedge that is far narrower than quadrature points are apart. Its own
point is a point of the quadrature. Were a point of the wall that lies in the wedge to count with its whole weight, too,
each of them would be a bump for a corner that slides along the wall, and hold it as friction does, by some percent of
the normal force; the integral over the wedge is of third order in the overlap and counts for nothing. So each wall of a
pair counts for half where both are plain, and the wall of the corner alone next to a corner: with psi from 0 at the
corner to 1, a function of the distance from it along the outline, the pass of a primary point has the factor

    f = 1 + psi(secondary)^2 - psi(primary)^2,    G = sqrt(f) g

and G takes the place of the gap g. The factors of both passes add up to 2, wherever walls lie on each other. The
primary point keeps its place on its wall; the closest point slides by ``(a . t) / (|t|^2 (1 - k g))`` of its edge as
bodies move (see `ngcell.contact.gap.edge_gap`), and the derivatives of G have that of f. In the second ones the
curvature of the secondary wall is frozen. How deep walls overlap is told by g.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.gap.edge_gap import SWAP, EdgeGap, edge_kinematics
from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.surface.edges import EdgeSurface

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Exterior angle from which on a vertex is a corner [rad]; arcs turn by 0.03 where elements of order 2 meet.
_CORNER = 0.1
#: Distance from a corner from which on gaps count whole, over the thickness of the wall. Both faces of a corner of 120
#: degrees may lie in a wall up to a distance of twice the overlap, of which a certificate allows 2 %: there psi^2 is
#: below 1e-4.
_WHOLE = 0.4


@dataclass(frozen=True, eq=False)
class FadedGap:
    """Gaps in the plane that fade.

    Attributes
    ----------
    value, slope, bend : array of float, shape (n,)
        The factor of the gap, and its first two derivatives by ``a . t / |t|^2``.
    """

    value: Array
    slope: Array
    bend: Array
    gap: EdgeGap = EdgeGap()
    at_once: int = sys.maxsize

    @property
    def whole(self) -> EdgeGap:
        """The distance that fades."""
        return self.gap

    def flat(self, count: int) -> Array:
        """Return no curvature corrections, shape (count,)."""
        return self.gap.flat(count)

    def gaps(self, pairs: ContactPairs, side: Array, correction: Array, *vectors: Array) -> Array:
        """Return the gaps."""
        return self._factor(*vectors)[0] * self.gap.gaps(pairs, side, correction, *vectors)

    def slopes(self, pairs: ContactPairs, side: Array, correction: Array, gap: Array, *vectors: Array) -> Array:
        """Return the derivatives by ``(a_x, a_y, t_x, t_y)``."""
        whole = self.gap.gaps(pairs, side, correction, *vectors)
        factor, slope, along = self._factor(*vectors)
        own = self.gap.slopes(pairs, side, correction, whole, *vectors)
        return factor[:, None] * own + (whole * slope)[:, None] * along

    def curvatures(self, pairs: ContactPairs, chosen: Index, side: Array, correction: Array, *vectors: Array) -> Array:
        """Return the second derivatives of chosen gaps by ``(a, t)``, shape (chosen, 4, 4)."""
        mine, few = FadedGap(self.value[chosen], self.slope[chosen], self.bend[chosen]), pairs.chosen(chosen)
        whole = self.gap.gaps(few, side, correction, *vectors)
        factor, slope, along = mine._factor(*vectors)
        own = self.gap.slopes(few, side, correction, whole, *vectors)
        block = self.gap.curvatures(few, np.arange(len(few)), side, correction, *vectors) * factor[:, None, None]
        block += slope[:, None, None] * _twice_symmetric(own, along)
        block += (whole * mine.bend)[:, None, None] * along[:, :, None] * along[:, None, :]
        return np.asarray(block + (whole * slope)[:, None, None] * _slide_curvature(*vectors))

    def _factor(self, a: Array, t: Array) -> tuple[Array, Array, Array]:
        """Return the factor, its derivative by the slide, and the derivatives of the slide by both vectors."""
        slid, speed2 = np.einsum("nd,nd->n", a, t), np.einsum("nd,nd->n", t, t)[:, None]
        slid = slid / speed2[:, 0]
        factor = self.value + self.slope * slid + self.bend / 2 * slid**2
        along = np.concatenate([t, a - 2 * slid[:, None] * t], axis=1) / speed2
        return factor, self.slope + self.bend * slid, along


def _slide_curvature(a: Array, t: Array) -> Array:
    """Second derivatives of ``a . t / |t|^2`` by both vectors where ``a . t`` is 0, as it is at a foot."""
    speed2 = np.einsum("nd,nd->n", t, t)[:, None, None]
    growing = np.concatenate([np.zeros_like(t), 2 * t], axis=1)
    return np.asarray(SWAP / speed2 - _twice_symmetric(np.concatenate([t, a], axis=1), growing) / speed2**2)


def _twice_symmetric(one: Array, two: Array) -> Array:
    """Return ``one two^T + two one^T``, shape (n, 4, 4)."""
    product = one[:, :, None] * two[:, None, :]
    return np.asarray(product + product.transpose(0, 2, 1))


class Corners:
    """The convex corners of walls in the plane.

    Parameters
    ----------
    walls : EdgeSurface
        The walls.
    """

    def __init__(self, walls: EdgeSurface) -> None:
        self._walls, self._size, self._width = walls, walls.sizes, _WHOLE * walls.thickness[walls.body]
        is_corner = walls.exterior_angle > _CORNER
        self._away = _along_outlines(walls, is_corner, float(self._width.max(initial=0.0)))
        self._is_near = np.any(self._away < self._width[:, None], axis=1)

    def kinematics(self, pairs: ContactPairs, positions: Array) -> GapKinematics:
        """Return the kinematics of pairs that were found at these positions, without those that count for nothing."""
        value, slope, bend = self._factor(pairs)
        counting = value > 0
        if not counting.all():
            pairs, value, slope, bend = pairs.chosen(counting), value[counting], slope[counting], bend[counting]
        found = edge_kinematics(self._walls, pairs, positions)
        if (value == 1).all():
            return found
        _, t = found.vectors(positions)
        speed2 = np.einsum("nd,nd->n", t, t)
        # The correction is k / (|t|^2 (1 - k g)), and 1 / (1 - k g) = 1 + k g / (1 - k g).
        slides = np.where(pairs.at_end, 0.0, 1 + speed2 * found.correction * found.gaps(positions))
        return replace(found, gap=FadedGap(value, slope * slides, bend * slides**2))

    def _factor(self, pairs: ContactPairs) -> tuple[Array, Array, Array]:
        """Return the factor of each gap, and its first two derivatives by the coordinate of the closest point."""
        theirs, by_one, by_two = self._psi(pairs.secondary, pairs.secondary_xi)
        mine, _, _ = self._psi(pairs.primary, pairs.primary_xi)
        value = np.where(mine < 1, np.sqrt(np.maximum(1 + theirs**2 - mine**2, 0.0)), theirs)
        some = np.where(value > 0, value, 1.0)
        slope = np.where(mine < 1, theirs * by_one / some, by_one)
        bend = np.where(mine < 1, (by_one**2 + theirs * by_two - slope**2) / some, by_two)
        return value, slope, bend

    def _psi(self, edge: Index, xi: Array) -> tuple[Array, Array, Array]:
        """Return psi at places of edges, and its first two derivatives by the coordinate."""
        value, slope, bend = np.ones(len(edge)), np.zeros(len(edge)), np.zeros(len(edge))
        at = np.flatnonzero(self._is_near[edge])
        if len(at):
            edge, xi = edge[at], xi[at]
            rate = self._size[edge] / self._width[edge]
            (one, d_one, dd_one), (two, d_two, dd_two) = (
                _smooth_step(self._away[edge, end] / self._width[edge] + rate * along)
                for end, along in enumerate((xi, 1 - xi))
            )
            value[at], slope[at] = one * two, rate * (d_one * two - one * d_two)
            bend[at] = rate**2 * (dd_one * two - 2 * d_one * d_two + one * dd_two)
        return value, slope, bend


def _along_outlines(walls: EdgeSurface, is_corner: NDArray[np.bool_], farthest: float) -> Array:
    """Return how far both ends of each edge are from a corner along the outline, shape (edges, 2), or farther."""
    number, vertex = np.unique(walls.vertices, return_inverse=True)
    vertex = vertex.reshape(walls.vertices.shape)
    away = np.full(len(number), np.inf)
    away[vertex[is_corner]] = 0.0
    while True:
        reached = away.copy()
        for one, two in ((0, 1), (1, 0)):
            np.minimum.at(reached, vertex[:, two], away[vertex[:, one]] + walls.sizes)
        reached = np.where(reached < farthest, reached, away)
        if (reached == away).all():
            return np.asarray(away[vertex])
        away = reached


def _smooth_step(place: Array) -> tuple[Array, Array, Array]:
    """Return a polynomial from 0 to 1 over the unit interval, and its first two derivatives, zeros at both ends."""
    x = np.clip(place, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x**2), 30 * x**2 * (1 - x) ** 2, 60 * x * (1 - x) * (1 - 2 * x)
