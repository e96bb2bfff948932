"""Averages over parts of bodies at rest, as sparse weights: the stress that a wall is judged by.

A stress at a re-entrant corner is singular: on finer meshes its maximum grows without end, and tells nothing. Its
average over a length that belongs to the material stays finite and converges (G. Pijaudier-Cabot and Z. P. Bazant,
"Nonlocal damage theory", J. Eng. Mech. 113(10), 1512-1533, 1987; doi:10.1061/(ASCE)0733-9399(1987)113:10(1512), which
was not checked). Two kinds of parts:

- Walls of a planar tissue, swept along their outlines: the whole thickness, and along the wall the weights
  ``cos(pi s / 2 l)**2`` up to a distance l from the middle, which have the width l. The mean over the thickness of a
  wall is what balance of forces determines.
- Other bodies: all of the body within a distance l of a point, with the weights ``(1 - r**2 / l**2)**2``.

Without a given length, l is the thickness of the wall.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.places import element_type
from ngcell.results.rupture.samples import Samples, check_count, gauss, lattice, parts_for, rule

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Averages that are taken for each length along a wall, and in other bodies.
_ALONG, _AROUND = 6, 4
#: Points of a rule in each part of an element, besides half of the order of the unknowns.
_BESIDES = 2


@dataclass(frozen=True, eq=False)
class Averages:
    """Averages over parts of bodies.

    Attributes
    ----------
    samples : Samples
        Points in the elements.
    place : array of float, shape (averages, dimension)
        Middle of each part, at rest [length].
    body : array of int, shape (averages,)
        Body that it belongs to.
    weights : csr_array, shape (averages, n)
        Weights of sums over the points of a column.
    column : array of int, shape (elements * points,)
        Which sum each point belongs to; -1 for none.
    """

    samples: Samples
    place: Array
    body: Index
    weights: sparse.csr_array
    column: Index

    def sums(self, values: Array) -> Array:
        """Return weighted integrals of values at all points, shape (points, ...), for each average."""
        used = self.column >= 0
        flat = values[used].reshape(int(used.sum()), -1)
        weighted = flat * self.samples.volume[used, None]
        count = self.weights.shape[1]
        columns = np.column_stack([np.bincount(self.column[used], row, count) for row in weighted.T])
        return np.asarray((self.weights @ columns).reshape(-1, *values.shape[1:]))


def averages_of(space: DisplacementSpace, length: Array) -> Averages:
    """Return the averages of all bodies over these lengths, shape (bodies,) [length]."""
    return _along_walls(space, length) if space.bodies.is_swept else _around_points(space, length)


def _along_walls(space: DisplacementSpace, length: Array) -> Averages:
    walls = _columns(space)
    count = space.order // 2 + _BESIDES
    relative = float((walls.length / length[walls.body]).max())
    check_count(int(relative), space)
    along, along_weights = gauss(count, parts_for(relative, 1.0))
    through, through_weights = gauss(count)
    points = np.array([(x, y) for x in along for y in through])
    samples = Samples(space, points, np.outer(along_weights, through_weights).ravel())
    line = np.tile(np.repeat(np.arange(len(along)), len(through)), space.mesh.ne)
    of_element = walls.column_of_element[samples.element]
    column = np.where(of_element < 0, -1, of_element * len(along) + line)
    at = (walls.start[:, None] + walls.length[:, None] * along).ravel()
    body = np.repeat(walls.body, len(along))
    place, owner, blocks = [], [], []
    for number in range(space.body_count):
        mine, ends = np.flatnonzero(body == number), np.flatnonzero(walls.body == number)
        whole = walls.length[ends].sum()
        middle = np.arange(int(np.ceil(_ALONG * whole / length[number]))) * (length[number] / _ALONG)
        middle *= whole / (middle[-1] + length[number] / _ALONG)
        apart = np.abs(middle[:, None] - at[mine])
        apart = np.minimum(apart, whole - apart) / length[number]
        blocks.append(sparse.csr_array(np.where(apart < 1, np.cos(np.pi / 2 * apart) ** 2, 0.0)))
        inside = np.searchsorted(walls.start[ends], middle, side="right") - 1
        share = ((middle - walls.start[ends][inside]) / walls.length[ends][inside])[:, None]
        place.append((1 - share) * walls.ends[ends[inside], 0] + share * walls.ends[ends[inside], 1])
        owner.append(np.full(len(middle), number))
    order = np.argsort(body, kind="stable")
    weights = sparse.block_diag(blocks, format="csr")[:, np.argsort(order)]
    return Averages(samples, np.concatenate(place), np.concatenate(owner), sparse.csr_array(weights), column)


@dataclass(frozen=True, eq=False)
class _Columns:
    """Columns of elements through walls, those of each cell one after the other.

    Attributes
    ----------
    column_of_element : array of int, shape (elements,)
        Column of each element; -1 in what fills lumens.
    body : array of int, shape (columns,)
        Body of each.
    ends : array of float, shape (columns, 2, 2)
        Where it begins and ends on the line along the middle of the wall [length].
    start, length : array of float, shape (columns,)
        Where it begins along that line, and how long it is [length].
    """

    column_of_element: Index
    body: Index
    ends: Array
    start: Array
    length: Array


def _columns(space: DisplacementSpace) -> _Columns:
    """Return the columns: elements that follow each other through a wall, from outside to the lumen."""
    bodies, mesh = space.bodies, space.mesh
    in_wall = np.ones(mesh.ne, dtype=bool) if bodies.is_filling is None else ~bodies.is_filling
    element = np.flatnonzero(in_wall)
    corner = np.array([[vertex.nr for vertex in each.vertices] for each in mesh.Elements()])[element]
    outer, inner = (corner[:, one] * mesh.nv + corner[:, two] for one, two in ((0, 1), (3, 2)))
    order = np.argsort(outer)
    below = order[np.searchsorted(outer, inner, sorter=order).clip(max=len(order) - 1)]
    below = np.where(outer[below] == inner, below, -1)
    first = np.flatnonzero(~np.isin(outer, inner))
    column, last, now = np.full(mesh.ne, -1), first.copy(), first.copy()
    number = np.arange(len(first))
    while len(now):
        column[element[now]], last[number] = number, now
        now, number = below[now], number[below[now] >= 0]
        now = now[now >= 0]
    points = np.array([vertex.point for vertex in mesh.vertices])
    ends = np.stack([points[corner[first][:, one]] + points[corner[last][:, two]] for one, two in ((0, 3), (1, 2))], 1)
    ends, body = ends / 2, bodies.body_of_element[element[first]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    start = np.cumsum(length) - length
    begin = start[np.searchsorted(body, np.arange(space.body_count))]
    return _Columns(column, body, ends, start - begin[body], length)


def _around_points(space: DisplacementSpace, length: Array) -> Averages:
    kind, of_element = element_type(space), space.bodies.body_of_element
    mesh = space.mesh
    corner = np.array([[vertex.nr for vertex in each.vertices] for each in mesh.Elements()])
    points = np.array([vertex.point for vertex in mesh.vertices])[corner]
    size = np.linalg.norm(points - np.roll(points, 1, axis=1), axis=2).max(1)
    relative = float((size / length[of_element]).max())
    check_count(int(_AROUND * relative) ** 2, space)
    samples = Samples(space, *rule(kind, space.order // 2 + _BESIDES, parts_for(relative, 1.0)))
    nodes = lattice(kind, int(np.ceil(_AROUND * relative)))
    middle = Samples(space, nodes, np.zeros(len(nodes)))
    owner, body = of_element[middle.element], of_element[samples.element]
    scaled = np.column_stack([middle.rest / length[owner, None], owner])
    _, kept = np.unique(scaled.round(6), axis=0, return_index=True)
    owner, place = owner[kept], middle.rest[kept]
    rows, columns, apart = _near(samples.rest / length[body, None], body, scaled[kept, :2], owner)
    shape = (len(place), len(samples.rest))
    weights = sparse.csr_array(((1 - apart**2) ** 2, (rows, columns)), shape=shape)
    return Averages(samples, place, owner, weights, np.arange(len(samples.rest)))


def _near(points: Array, body: Index, middle: Array, owner: Index) -> tuple[Index, Index, Array]:
    """Return pairs of a middle and a point of its body nearer than 1, and how far they are apart."""
    from scipy.spatial import KDTree

    far = 10 * (np.ptp(points, axis=0).max() + 1)
    tree = KDTree(np.column_stack([points, body * far]))
    found = KDTree(np.column_stack([middle, owner * far])).sparse_distance_matrix(tree, 1.0, output_type="ndarray")
    return found["i"].astype(np.int64), found["j"].astype(np.int64), found["v"]
