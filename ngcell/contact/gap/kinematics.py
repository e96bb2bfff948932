"""The normal gap and its first two derivatives, with contact pairs held fixed.

A gap is a function of a few vectors: ``a`` from the closest secondary point to the primary point, and the deformed
secondary tangents, each of which depends linearly on the unknowns. What this function is, and why its derivatives are
those of the distance to the curved wall itself, is in `ngcell.contact.gap.edge_gap` and `ngcell.contact.gap.facet_gap`;
the linear maps, which are the same for both, are here. Open gaps are positive.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce
from operator import add
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.pairing.pairs import ContactPairs

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Gap(Protocol):
    """The gap as a function of the vectors ``(a, t)``, of faces ``(a, t, t')``, each of shape (n, dimension)."""

    @property
    def at_once(self) -> int:
        """Number of contact pairs whose parts of a tangent are held in memory at once."""

    @property
    def whole(self) -> Gap:
        """The distance itself, of which gaps that fade are a multiple."""

    def flat(self, count: int) -> Array:
        """Return the curvature corrections of so many contact pairs on walls that count as flat: zeros."""

    def gaps(self, pairs: ContactPairs, side: Array, correction: Array, *vectors: Array) -> Array:
        """Return the gaps [length], shape (n,)."""

    def slopes(self, pairs: ContactPairs, side: Array, correction: Array, gap: Array, *vectors: Array) -> Array:
        """Return the derivatives by the components of the vectors, shape (n, dimension * vectors)."""

    def curvatures(self, pairs: ContactPairs, chosen: Index, side: Array, correction: Array, *vectors: Array) -> Array:
        """Return the second derivatives of chosen gaps, whose side, correction and vectors are given."""


@dataclass(frozen=True, eq=False)
class GapKinematics:
    """Linear maps from unknowns to the vectors of each contact pair, and the gap as a function of these.

    Attributes
    ----------
    pairs : ContactPairs
        The contact pairs, n of them.
    gap : Gap
        What the gap is.
    dofs : array of int, shape (n, nodes of two facets)
        Scalar unknowns of the primary and of the secondary facet.
    maps : tuple of array of float, each of shape (n, nodes of two facets)
        Factors of those unknowns in a component of each vector: of ``a``, then of each tangent.
    side : array of float, shape (n,)
        Side of the secondary facet.
    correction : array of float, shape (n,), of faces (n, 2, 2)
        Curvature correction, by which the secondary wall departs from its tangents; see the gaps' modules.
    """

    pairs: ContactPairs
    gap: Gap
    dofs: Index
    maps: tuple[Array, ...]
    side: Array
    correction: Array
    _seen: list[Any] = field(default_factory=list, init=False)

    def vectors(self, positions: Array) -> tuple[Array, ...]:
        """Return the vectors, each (n, d), of positions given as unknowns of shape (d, scalar unknowns).

        Those of the array that was last asked for are kept; it is not to be written to.
        """
        if not self._seen or self._seen[0] is not positions:
            local = positions[:, self.dofs]
            self._seen[:] = positions, tuple(np.einsum("dnj,nj->nd", local, factors) for factors in self.maps)
        vectors: tuple[Array, ...] = self._seen[1]
        return vectors

    def gaps(self, positions: Array) -> Array:
        """Return the gaps [length], shape (n,)."""
        return self.gap.gaps(self.pairs, self.side, self.correction, *self.vectors(positions))

    def distances(self, positions: Array) -> Array:
        """Return the signed distances of walls [length], shape (n,): gaps without the factor by which they fade."""
        return self.gap.whole.gaps(self.pairs, self.side, self.correction, *self.vectors(positions))

    def slopes(self, positions: Array) -> tuple[Array, Array]:
        """Return the gaps and their derivatives by the components of the vectors, ``a`` first."""
        vectors = self.vectors(positions)
        gap = self.gap.gaps(self.pairs, self.side, self.correction, *vectors)
        return gap, self.gap.slopes(self.pairs, self.side, self.correction, gap, *vectors)

    def curvatures(self, positions: Array, chosen: Index) -> Array:
        """Return the second derivatives of chosen gaps by the components of the vectors."""
        vectors = (vector[chosen] for vector in self.vectors(positions))
        return self.gap.curvatures(self.pairs, chosen, self.side[chosen], self.correction[chosen], *vectors)

    def bending(self, positions: Array, contact_forces: Array, *, convex: bool = False) -> sparse.coo_array:
        """Return the part of the tangent that contact forces [stress * length], shape (n,), have on curved gaps; its
        convex part is that of each contact pair."""
        closed, at_once = np.flatnonzero(contact_forces > 0), self.gap.at_once
        if len(closed) <= at_once:
            return self._bent(positions, contact_forces, closed, convex)
        # Many points share the unknowns of a facet: summed part by part, their blocks take little memory.
        starts = range(0, len(closed), at_once)
        chosen = (closed[first : first + at_once] for first in starts)
        parts = (self._bent(positions, contact_forces, some, convex).tocsr() for some in chosen)
        return reduce(add, parts).tocoo()

    def _bent(self, positions: Array, contact_forces: Array, chosen: Index, convex: bool) -> sparse.coo_array:
        blocks = -contact_forces[chosen, None, None] * self.curvatures(positions, chosen)
        return self.assemble(positive_part(blocks) if convex else blocks, chosen, positions.shape[1])

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

    def assemble(self, blocks: Array, chosen: Index, columns: int) -> sparse.coo_array:
        """Return the sum over chosen contact pairs of their blocks in the vectors, as a matrix in the unknowns."""
        axes = blocks.shape[1] // len(self.maps)
        factors = np.stack([each[chosen] for each in self.maps], axis=1)
        unknown = self.dofs[chosen][:, None] + columns * np.arange(axes)[:, None]
        rows = np.tile(unknown, (1, len(self.maps), 1))
        maps = _sparse_rows(np.repeat(factors, axes, axis=1), rows, axes * columns)
        by_unknown = blocks.reshape(*blocks.shape[:2], len(self.maps), axes).transpose(0, 1, 3, 2) @ factors[:, None]
        every = np.repeat(unknown.reshape(len(chosen), 1, axes * self.dofs.shape[1]), blocks.shape[1], axis=1)
        return (maps.T @ _sparse_rows(by_unknown, every, axes * columns)).tocoo()


def positive_part(blocks: Array) -> Array:
    """Return symmetric matrices, shape (n, size, size), without what their negative eigenvalues add to them."""
    values, vectors = np.linalg.eigh(blocks)
    return np.asarray((vectors * np.maximum(values, 0)[:, None, :]) @ vectors.transpose(0, 2, 1))


def _sparse_rows(values: Array, columns: Index, count: int) -> sparse.csr_array:
    """Return a matrix whose rows have these values in these of `count` columns; the first two axes are rows."""
    height, width = columns.shape[0] * columns.shape[1], columns.shape[2]
    pointer = width * np.arange(height + 1)
    return sparse.csr_array((values.ravel(), columns.ravel(), pointer), shape=(height, count))
