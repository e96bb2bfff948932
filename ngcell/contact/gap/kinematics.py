"""The normal gap and its first two derivatives, with contact pairs held fixed.

With ``a`` from the closest secondary point to the primary point, and ``t`` the deformed secondary tangent, the gap is

    g = side (a_x t_y - a_y t_x) / |t| - correction (a . t)^2 / 2        (foot of a normal)
    g = sign |a|                                                   (end of an edge)

and open gaps are positive. The first term is the distance to the tangent line; the second is what the wall curves away
from that line when the true foot slides by ``a . t``. With the secondary curvature k (of the deformed wall, by the
outward normal) and the gap g, both frozen where the contact pair was found, ``correction = k / (|t|^2 (1 - k g))``. So g and its
first two derivatives are those of the distance to the curved wall itself: the tangent with frozen contact pairs is the
tangent of the energy whose contact pairs are found anew, and Newton's method converges quadratically.

In three dimensions there are two tangents, and feet of normals to a side besides; see `ngcell.contact.gap.facets`. What a gap is,
is a `Shape`; the rest is the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce
from operator import add
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.pairing.search import ContactPairs
from ngcell.contact.surface.walls import Walls

Array = NDArray[np.float64]

#: ContactPairs in three dimensions whose parts of a tangent are held in memory at once.
_AT_ONCE = 1000


class Shape(Protocol):
    """What a gap is, and its derivatives by the vectors ``(a, t)``, in three dimensions ``(a, t, t')``, each of shape (n, d)."""

    def gaps(self, pairs: ContactPairs, side: Array, correction: Array, *vectors: Array) -> Array:
        """Return the gaps [length], shape (n,)."""

    def slopes(self, pairs: ContactPairs, side: Array, correction: Array, gap: Array, *vectors: Array) -> Array:
        """Return the derivatives by the components of the vectors, shape (n, d * vectors)."""

    def curvatures(
        self, pairs: ContactPairs, chosen: NDArray[np.int64], side: Array, correction: Array, *vectors: Array
    ) -> Array:
        """Return the second derivatives of chosen gaps, whose side, correction and vectors are given."""


class PlanarGap:
    """Gaps in the plane."""

    def gaps(self, pairs: ContactPairs, side: Array, correction: Array, a: Array, t: Array) -> Array:
        """Return the gaps."""
        foot = _height(a, t, side) - correction / 2 * _along(a, t) ** 2
        return np.where(pairs.at_end, pairs.sign * np.linalg.norm(a, axis=1), foot)

    def slopes(self, pairs: ContactPairs, side: Array, correction: Array, gap: Array, a: Array, t: Array) -> Array:
        """Return the derivatives by ``(a_x, a_y, t_x, t_y)``."""
        speed = np.linalg.norm(t, axis=1)[:, None]
        height = _height(a, t, side)[:, None]
        side, slid = side[:, None], (correction * _along(a, t))[:, None]
        by_offset = side * np.column_stack([t[:, 1], -t[:, 0]]) / speed - slid * t
        by_tangent = side * np.column_stack([-a[:, 1], a[:, 0]]) / speed - height * t / speed**2 - slid * a
        end = pairs.at_end
        by_offset[end] = a[end] / gap[end, None]
        by_tangent[end] = 0
        return np.column_stack([by_offset, by_tangent])

    def curvatures(
        self, pairs: ContactPairs, chosen: NDArray[np.int64], side: Array, correction: Array, a: Array, t: Array
    ) -> Array:
        """Return the second derivatives of chosen gaps by ``(a, t)``, shape (chosen, 4, 4)."""
        end, sign = pairs.at_end[chosen], pairs.sign[chosen]
        foot = _foot_curvature(a, t, side) - correction[:, None, None] * _correction_curvature(a, t)
        return np.where(end[:, None, None], _end_curvature(a, sign), foot)


@dataclass(frozen=True, eq=False)
class GapKinematics:
    """Linear maps from unknowns to ``(a, t)`` of each contact pair, in three dimensions to ``(a, t, t')``.

    Attributes
    ----------
    contact pairs : ContactPairs
        The contact pairs, n of them.
    dofs : array of int, shape (n, 2 (order + 1))
        Scalar unknowns of the primary and of the secondary edge.
    offset, tangent : array of float, shape (n, 2 (order + 1))
        Factors of those unknowns in a component of ``a`` and of ``t``.
    side : array of float, shape (n,)
        Side of the secondary edge.
    correction : array of float, shape (n,), in three dimensions (n, 2, 2)
        Factor of ``(a . t)^2 / 2`` in the gap [1 / length**3]; 0 at ends and on straight edges.
    other_tangent : array of float, shape (n, 2 (order + 1)), optional
        Factors of ``t'``.
    shape : Shape
        What the gap is.
    """

    pairs: ContactPairs
    dofs: NDArray[np.int64]
    offset: Array
    tangent: Array
    side: Array
    correction: Array
    other_tangent: Array | None = None
    shape: Shape = field(default_factory=PlanarGap)
    _seen: list[Any] = field(default_factory=list, init=False)

    @property
    def maps(self) -> tuple[Array, ...]:
        """Factors of the unknowns in a component of each vector."""
        planar = self.offset, self.tangent
        return planar if self.other_tangent is None else (*planar, self.other_tangent)

    def vectors(self, positions: Array) -> tuple[Array, ...]:
        """Return ``a`` and ``t``, each (n, d), of positions given as unknowns of shape (d, scalar unknowns).

        Those of the array that was last asked for are kept; it is not to be written to.
        """
        if not self._seen or self._seen[0] is not positions:
            local = positions[:, self.dofs]
            self._seen[:] = positions, tuple(np.einsum("dnj,nj->nd", local, factors) for factors in self.maps)
        return self._seen[1]

    def gaps(self, positions: Array) -> Array:
        """Return the gaps [length], shape (n,)."""
        return self.shape.gaps(self.pairs, self.side, self.correction, *self.vectors(positions))

    def slopes(self, positions: Array) -> tuple[Array, Array]:
        """Return the gaps and their derivatives by the components of the vectors, ``a`` first."""
        vectors = self.vectors(positions)
        gap = self.shape.gaps(self.pairs, self.side, self.correction, *vectors)
        return gap, self.shape.slopes(self.pairs, self.side, self.correction, gap, *vectors)

    def curvatures(self, positions: Array, chosen: NDArray[np.int64]) -> Array:
        """Return the second derivatives of chosen gaps by the components of the vectors."""
        vectors = (vector[chosen] for vector in self.vectors(positions))
        return self.shape.curvatures(self.pairs, chosen, self.side[chosen], self.correction[chosen], *vectors)

    def bending(self, positions: Array, contact_forces: Array) -> sparse.coo_array:
        """Return the part of the tangent that pushes along curved gaps [stress * length], shape (n,), leave."""
        closed = np.flatnonzero(contact_forces > 0)
        if len(positions) == 2 or not len(closed):
            return self._bent(positions, contact_forces, closed)
        # Many points share the unknowns of a face: summed up part by part, what they leave takes little memory.
        starts = range(0, len(closed), _AT_ONCE)
        parts = (self._bent(positions, contact_forces, closed[first : first + _AT_ONCE]).tocsr() for first in starts)
        return reduce(add, parts).tocoo()

    def _bent(self, positions: Array, contact_forces: Array, chosen: NDArray[np.int64]) -> sparse.coo_array:
        blocks = -contact_forces[chosen, None, None] * self.curvatures(positions, chosen)
        return self.assemble(blocks, chosen, positions.shape[1])

    def jacobian(self, slopes: Array, columns: int) -> sparse.csr_array:
        """Return the derivatives of all gaps by the unknowns, from `slopes`; shape (n, d columns)."""
        axes = slopes.shape[1] // len(self.maps)
        data = []
        for axis in range(axes):
            part = slopes[:, [axis]] * self.maps[0]
            for number, factors in enumerate(self.maps[1:], start=1):
                part = part + slopes[:, [axis + number * axes]] * factors
            data.append(part)
        indices = np.concatenate([self.dofs + axis * columns for axis in range(axes)], axis=1)
        pointer = np.arange(len(indices) + 1) * indices.shape[1]
        return sparse.csr_array(
            (np.concatenate(data, axis=1).ravel(), indices.ravel(), pointer), shape=(len(indices), axes * columns)
        )

    def assemble(self, blocks: Array, chosen: NDArray[np.int64], columns: int) -> sparse.coo_array:
        """Return the sum over chosen contact pairs of their blocks in the vectors, as a matrix in the unknowns."""
        axes = blocks.shape[1] // len(self.maps)
        factors = np.stack([each[chosen] for each in self.maps], axis=1)
        unknown = self.dofs[chosen][:, None] + columns * np.arange(axes)[:, None]
        rows = np.tile(unknown, (1, len(self.maps), 1))
        maps = _sparse_rows(np.repeat(factors, axes, axis=1), rows, axes * columns)
        by_unknown = blocks.reshape(*blocks.shape[:2], len(self.maps), axes).transpose(0, 1, 3, 2) @ factors[:, None]
        every = np.repeat(unknown.reshape(len(chosen), 1, axes * self.dofs.shape[1]), blocks.shape[1], axis=1)
        return (maps.T @ _sparse_rows(by_unknown, every, axes * columns)).tocoo()


def _sparse_rows(values: Array, columns: NDArray[np.int64], count: int) -> sparse.csr_array:
    """Return a matrix whose rows have these values in these of `count` columns; the first two axes are rows."""
    height, width = columns.shape[0] * columns.shape[1], columns.shape[2]
    pointer = width * np.arange(height + 1)
    return sparse.csr_array((values.ravel(), columns.ravel(), pointer), shape=(height, count))


def gap_kinematics(walls: Walls, pairs: ContactPairs, positions: Array) -> GapKinematics:
    """Return the kinematics of contact pairs that were found at `positions`, unknowns of shape (d, scalar unknowns)."""
    if walls.dimension == 3:
        from ngcell.contact.gap.facets import facet_kinematics

        return facet_kinematics(walls, pairs, positions)
    primary = walls.trace(pairs.edge, pairs.here)
    secondary = walls.trace(pairs.other, pairs.xi)
    slope, bend = (walls.trace(pairs.other, pairs.xi, derivative=degree) for degree in (1, 2))
    kinematics = GapKinematics(
        pairs=pairs,
        dofs=np.concatenate([walls.dofs[pairs.edge], walls.dofs[pairs.other]], axis=1),
        offset=np.concatenate([primary, -secondary], axis=1),
        tangent=np.concatenate([np.zeros_like(primary), slope], axis=1),
        side=walls.side[pairs.other],
        correction=np.zeros(len(pairs)),
    )
    bent = np.einsum("nj,dnj->nd", bend, positions[:, walls.dofs[pairs.other]])
    kinematics.correction[:] = _correction(kinematics, positions, bent)
    return kinematics


def _correction(kinematics: GapKinematics, positions: Array, bent: Array) -> Array:
    """Return ``k / (|t|^2 (1 - k g))`` at feet, 0 at ends; `bent` is the second derivative of the secondary wall.

    At a closest point ``1 - k g`` is positive; it is kept away from 0, where contact pairs are about to jump.
    """
    _, t = kinematics.vectors(positions)
    speed2 = np.einsum("nd,nd->n", t, t)
    curvature = _height(bent, t, kinematics.side) / speed2
    correction = curvature / speed2 / np.maximum(1 - curvature * kinematics.gaps(positions), 0.1)
    return np.where(kinematics.pairs.at_end, 0.0, correction)


def _height(a: Array, t: Array, side: Array) -> Array:
    """Return the component of `a` along the outward normal of `t`."""
    return np.asarray(side * (a[:, 0] * t[:, 1] - a[:, 1] * t[:, 0]) / np.linalg.norm(t, axis=1))


def _along(a: Array, t: Array) -> Array:
    return np.einsum("nd,nd->n", a, t)


def _correction_curvature(a: Array, t: Array) -> Array:
    """Second derivative of ``(a . t)^2 / 2``."""
    slope = np.concatenate([t, a], axis=1)
    swap = np.kron(np.array([[0.0, 1.0], [1.0, 0.0]]), np.eye(2))
    return np.asarray(slope[:, :, None] * slope[:, None, :] + _along(a, t)[:, None, None] * swap)


def _end_curvature(a: Array, sign: Array) -> Array:
    distance = np.maximum(np.linalg.norm(a, axis=1), np.finfo(float).tiny)[:, None, None]
    direction = a[:, :, None] / distance
    block = np.zeros((len(a), 4, 4))
    block[:, :2, :2] = sign[:, None, None] * (np.eye(2) - direction * direction.transpose(0, 2, 1)) / distance
    return block


def _foot_curvature(a: Array, t: Array, side: Array) -> Array:
    """Second derivative of ``c / s`` with ``c = a x t`` and ``s = |t|``."""
    speed = np.linalg.norm(t, axis=1)[:, None, None]
    cross = (a[:, 0] * t[:, 1] - a[:, 1] * t[:, 0])[:, None, None]
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    cross_slope = np.column_stack([t[:, 1], -t[:, 0], -a[:, 1], a[:, 0]])
    direction = t / speed[:, 0]
    speed_slope = np.column_stack([np.zeros_like(a), direction])
    block = np.zeros((len(a), 4, 4))
    block[:, :2, 2:] = turn / speed
    block[:, 2:, :2] = turn.T / speed
    mixed = cross_slope[:, :, None] * speed_slope[:, None, :]
    block -= (mixed + mixed.transpose(0, 2, 1)) / speed**2
    block += 2 * cross / speed**3 * speed_slope[:, :, None] * speed_slope[:, None, :]
    block[:, 2:, 2:] -= cross / speed**3 * (np.eye(2) - direction[:, :, None] * direction[:, None, :])
    return side[:, None, None] * block
