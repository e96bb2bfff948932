"""Bernstein polynomials on faces, their numbers, and the points of faces that are constrained one by one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import factorial

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.methods.edge_multipliers import EdgeFunctions
from ngcell.contact.surface.facet_basis import FacetBasis
from ngcell.contact.surface.facets import FacetSurface
from ngcell.contact.surface.surface import SurfacePoints
from ngcell.geometry.near import components, near_pairs

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_ON_SIDE = 1e-9
#: Share of the shortest side of a facet within which points are the same.
_SAME = 1e-4


@dataclass(frozen=True, eq=False)
class FacetFunctions:
    """Products of Bernstein polynomials on the unit square, or those of the unit triangle.

    Attributes
    ----------
    degree : int
        Their degree, in each coordinate or, on triangles, in all.
    corner_count : {3, 4}
        Whether facets are triangles or quadrilaterals.
    """

    degree: int
    corner_count: int

    @cached_property
    def lattice(self) -> FacetBasis:
        """Nodes at which the functions are largest, or nearly so: one for each."""
        return FacetBasis(self.degree, self.corner_count)

    def values(self, xi: Array) -> Array:
        """Return the functions at `xi`, (*shape, 2); shape (*shape, functions)."""
        x, y = np.asarray(xi)[..., 0], np.asarray(xi)[..., 1]
        one, two = (self.lattice.nodes * self.degree).round().astype(int).T
        if self.corner_count == 4:
            along = EdgeFunctions(self.degree)
            return np.asarray(along.values(x)[..., one] * along.values(y)[..., two])
        rest = self.degree - one - two
        repeats = [[factorial(power) for power in powers] for powers in (one, two, rest)]
        x, y = x[..., None], y[..., None]
        return np.asarray(factorial(self.degree) / np.prod(repeats, axis=0) * x**one * y**two * (1 - x - y) ** rest)

    def numbered(self, walls: FacetSurface, sharp: NDArray[np.bool_]) -> Index:
        """Return numbers for the functions on each facet, shape (facets, functions).

        Functions on a side are shared by the facets that meet there. Where a side is sharp, `sharp` of shape (facets,
        corners), walls end: there each function joins the nearest one of its facet that is not on that side,
        preferably one on no sharp side at all.
        """
        own = np.arange(walls.facet_count * len(self.lattice.nodes)).reshape(walls.facet_count, -1)
        on_side, joints = _on_sides(self.lattice), walls.joints
        smooth = ~sharp[joints.facet[:, 0], joints.side[:, 0]]
        (one, two), (side, other) = joints.facet[smooth].T, joints.side[smooth].T
        first, second = own[one[:, None], on_side[side]], own[two[:, None], on_side[other]]
        backwards = walls.vertices[one, side] != walls.vertices[two, other]
        second = np.where(backwards[:, None], second[:, ::-1], second)
        shared = components(own.size, first.ravel(), second.ravel())
        joining, joined = _joined(_lattice_places(walls, self.lattice), sharp, shared[own], on_side)
        links = np.concatenate([first.ravel(), joining]), np.concatenate([second.ravel(), joined])
        return components(own.size, *links)[own]


def constrained_on_facets(walls: FacetSurface) -> SurfacePoints:
    """Return the points of facets whose coordinates are quarters; those on shared sides once."""
    lattice = FacetBasis(4, walls.basis.corner_count)
    place = _lattice_places(walls, lattice).reshape(-1, 3)
    facet, number = np.divmod(np.arange(len(place)), len(lattice.nodes))
    one, two = near_pairs(place, _SAME * float(walls.sizes.min()))
    same = walls.body[facet[one]] == walls.body[facet[two]]
    _, first = np.unique(components(len(place), one[same], two[same]), return_index=True)
    first = np.sort(first)
    return SurfacePoints(facet[first], lattice.nodes[number[first]], np.zeros(len(first)))


def _on_sides(lattice: FacetBasis) -> Index:
    """Return the nodes on each side, from its first corner to its last, shape (corners, nodes on a side)."""
    start = lattice.corners
    ahead = np.roll(start, -1, axis=0) - start
    away = lattice.nodes - start[:, None]
    height = ahead[:, None, 0] * away[..., 1] - ahead[:, None, 1] * away[..., 0]
    along = np.einsum("cnd,cd->cn", away, ahead)
    sides = [np.flatnonzero(np.abs(level) < _ON_SIDE) for level in height]
    return np.array([side[np.argsort(place[side])] for side, place in zip(sides, along, strict=True)])


def _joined(place: Array, sharp: NDArray[np.bool_], shared: Index, on_side: Index) -> tuple[Index, Index]:
    """Return functions on sharp sides, and the one that each joins, by their first numbers.

    `place` has where the functions are largest, shape (facets, functions, 3) [length].
    """
    facet, side = np.nonzero(sharp)
    count = shared.shape[1]
    is_sharp = np.zeros(int(shared.max(initial=0)) + 1, dtype=bool)
    is_sharp[shared[facet[:, None], on_side[side]]] = True
    mine = np.repeat(on_side[side], count, axis=1).ravel()
    facet, side = (np.repeat(array, on_side.shape[1] * count) for array in (facet, side))
    theirs = np.tile(np.arange(count), len(mine) // max(count, 1))
    off = ~(on_side[side] == theirs[:, None]).any(1)
    facet, mine, theirs = facet[off], mine[off], theirs[off]
    apart = np.linalg.norm(place[facet, mine] - place[facet, theirs], axis=1)
    function, target = shared[facet, mine], shared[facet, theirs]
    order = np.lexsort((target, apart, is_sharp[target], function))
    first = order[np.diff(function[order], prepend=-1) > 0]
    own = np.arange(shared.size).reshape(shared.shape)
    return own[facet[first], mine[first]], own[facet[first], theirs[first]]


def _lattice_places(walls: FacetSurface, lattice: FacetBasis) -> Array:
    """Return where the nodes of a lattice are at rest, shape (facets, nodes, 3)."""
    return np.asarray(walls.basis.values(lattice.nodes) @ walls.rest)
