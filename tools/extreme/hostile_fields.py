"""What written fields say by themselves: energy, J, overlaps and areas, from `tissue.pvd` alone.

Nothing of ngcell is used here. Elements are found again as groups of VTK cells that share points; their fields are the
polynomials through these points, which are exact up to order 4. Energies are integrated by ten Gauss points in each
direction, J is sampled densely up to the sides of the elements, and outlines are polygons that shapely intersects.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
import shapely
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Points on a side of an element, of which outlines are made, and along an element, at which J is sampled.
_ON_SIDE, _ALONG = 17, 21
_GAUSS = 10
_CORNERS = {True: [(0, 0), (1, 0), (1, 1), (0, 1)], False: [(0, 0), (1, 0), (0, 1)]}


@dataclass(frozen=True, eq=False)
class Element:
    """Reference coordinates of an element: where its points are, and the polynomials through them."""

    is_quad: bool
    width: int

    @property
    def lattice(self) -> Array:
        """Its points, shape (points, 2), sorted by the first coordinate and then by the second."""
        both = [(i, j) for i in range(self.width + 1) for j in range(self.width + 1)]
        return np.array([pair for pair in both if self.is_quad or sum(pair) <= self.width]) / self.width

    def values(self, at: Array) -> tuple[Array, Array]:
        """Return what the values at the points are multiplied by, and the same for slopes, at places (n, 2)."""
        powers = np.rint(self.lattice * self.width).astype(int)
        inverse = np.linalg.inv(_monomials(self.lattice, powers))
        slopes = [_monomials(at, powers, along) @ inverse for along in (0, 1)]
        return _monomials(at, powers) @ inverse, np.stack(slopes, axis=1)

    @property
    def rule(self) -> tuple[Array, Array]:
        """Gauss points, shape (points, 2), and weights; in a triangle those of a square that collapses."""
        point, weight = np.polynomial.legendre.leggauss(_GAUSS)
        s, t = (axis.ravel() for axis in np.meshgrid((point + 1) / 2, (point + 1) / 2, indexing="ij"))
        weights = np.outer(weight, weight).ravel() / 4
        return (np.column_stack([s, t]), weights) if self.is_quad else (np.column_stack([s, t * (1 - s)]), weights * (1 - s))

    @property
    def dense(self) -> Array:
        """Places all over it, its sides and corners among them."""
        s, t = (axis.ravel() for axis in np.meshgrid(*[np.linspace(0, 1, _ALONG)] * 2, indexing="ij"))
        return np.column_stack([s, t]) if self.is_quad else np.column_stack([s, t * (1 - s)])

    @property
    def around(self) -> Array:
        """Places around it, side by side, shape (sides, points, 2)."""
        corners = np.array(_CORNERS[self.is_quad], dtype=float)
        share = np.linspace(0, 1, _ON_SIDE)[:, None]
        return np.array([a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)])


def _monomials(at: Array, powers: Index, slope_along: int | None = None) -> Array:
    """Return products of powers of both coordinates at places, or their slopes along one of them."""
    factors = []
    for axis in (0, 1):
        power, place = powers[:, axis], at[:, axis, None]
        if axis == slope_along:
            factors.append(power * place ** np.maximum(power - 1, 0))
        else:
            factors.append(place**power)
    return np.asarray(factors[0] * factors[1], dtype=float)


@dataclass(frozen=True, eq=False)
class Fields:
    """Written fields of one level: elements, the points of each at rest and moved, (elements, points, 2), and cells."""

    element: Element
    rest: Array
    moved: Array
    cell: Index

    @property
    def cells(self) -> list[int]:
        """Numbers of the cells."""
        return [int(number) for number in np.unique(self.cell)]

    def gradients(self, at: Array) -> tuple[Array, Array]:
        """Return F, shape (elements, places, 2, 2), and the density of the reference map, (elements, places)."""
        _, slopes = self.element.values(at)
        before, after = (np.einsum("qsn,end->eqds", slopes, points) for points in (self.rest, self.moved))
        return after @ np.linalg.inv(before), np.linalg.det(before)

    @property
    def smallest_jacobian(self) -> float:
        """Smallest J all over the elements."""
        gradient, density = self.gradients(self.element.dense)
        # Where a triangle collapses into its corner, or a corner of an element is flat, J has no value.
        sound = np.abs(density) > 1e-6 * np.abs(density).max(1, keepdims=True)
        return float(np.linalg.det(gradient)[sound].min())

    def energy(self, law: dict[str, float]) -> float:
        """Return the stored energy of Mooney-Rivlin walls in plane strain, infinite where J <= 0."""
        places, weights = self.element.rule
        gradient, density = self.gradients(places)
        jacobian = np.linalg.det(gradient)
        if jacobian.min() <= 0:
            return float("inf")
        right = np.swapaxes(gradient, 2, 3) @ gradient
        first = np.trace(right, axis1=2, axis2=3) + 1
        squares = np.einsum("eqij,eqij->eq", right, right) + 1
        second = (first**2 - squares) / 2
        stored = law["c1"] / 2 * (jacobian ** (-2 / 3) * first - 3) + law["c2"] / 2 * (jacobian ** (-4 / 3) * second - 3)
        stored += law["bulk_modulus"] / 2 * np.log(jacobian) ** 2
        return float((stored * np.abs(density) * weights).sum())

    def of(self, cells: list[int]) -> Fields:
        """Return the part of some cells."""
        mine = np.isin(self.cell, cells)
        return Fields(self.element, self.rest[mine], self.moved[mine], self.cell[mine])

    def sides(self, points: Array) -> Array:
        """Return places around all elements, shape (elements, sides, points, 2)."""
        around = self.element.around
        values, _ = self.element.values(around.reshape(-1, 2))
        return np.einsum("qn,end->eqd", values, points).reshape(len(points), *around.shape)


def read_levels(folder: Path) -> Iterator[tuple[float, Fields]]:
    """Yield time and fields of each level that a result folder holds."""
    reader: Any = pyvista.get_reader(str(folder / "tissue.pvd"))
    for time in reader.time_values:
        reader.set_active_time_value(time)
        yield float(time), _fields(reader.read()[0])


def _fields(grid: Any) -> Fields:
    (kind,) = {int(kind) for kind in grid.celltypes}
    joins = np.asarray(grid.cells_dict[kind])
    count, nodes = joins.shape
    shared = sparse.csr_array(
        (np.ones(joins.size), (np.repeat(np.arange(count), nodes), joins.ravel())), shape=(count, grid.n_points)
    )
    elements, of_cell = connected_components(shared @ shared.T, directed=False)
    is_quad = kind in (9, 23, 28)
    per_element = grid.n_points // elements
    width = {9: 2, 25: 4, 6: 2, 15: 4}[per_element]
    element = Element(is_quad, width)
    _check_lattice(element, joins)
    place = np.asarray(grid.points)[:, :2]
    moved = place + np.asarray(grid.point_data["displacement"])[:, :2]
    points = joins.min(1) // per_element
    number = np.zeros(elements, dtype=np.int64)
    number[points] = np.asarray(grid.cell_data["cell_id"])
    shape = (elements, per_element, 2)
    return Fields(element, place.reshape(shape), moved.reshape(shape), number)


def _check_lattice(element: Element, joins: Index) -> None:
    """Refuse files whose points are not in the order that their VTK cells say."""
    lattice = element.lattice[joins % len(element.lattice)]
    corners = 4 if element.is_quad else 3
    for corner in range(corners):
        middle = (lattice[:, corner] + lattice[:, (corner + 1) % corners]) / 2
        if not np.allclose(middle, lattice[:, corners + corner]):
            raise ValueError("the points of an element are in another order")


@dataclass(frozen=True, eq=False)
class Shapes:
    """Deformed cells as polygons, and how much of each lies over itself [area]."""

    polygon: dict[int, Any]
    self_overlap: dict[int, float]


def shapes(fields: Fields) -> Shapes:
    """Return the polygons of all cells."""
    outline = fields.sides(fields.moved)[:, :, :-1].reshape(len(fields.cell), -1, 2)
    sign = np.sign(_area(fields.sides(fields.rest)[:, :, :-1].reshape(len(fields.cell), -1, 2)))
    area = sign * _area(outline)
    polygon, over = {}, {}
    for cell in fields.cells:
        mine = np.flatnonzero(fields.cell == cell)
        whole = shapely.union_all([shapely.make_valid(shapely.Polygon(outline[number])) for number in mine])
        polygon[cell], over[cell] = whole, float(area[mine].sum() - whole.area)
    return Shapes(polygon, over)


def _area(line: Array) -> Array:
    x, y = line[..., 0], line[..., 1]
    return np.asarray((x * np.roll(y, -1, -1) - np.roll(x, -1, -1) * y).sum(-1) / 2)


def deepest_overlap(found: Shapes) -> float:
    """Return the largest mean thickness of the pieces in which two cells overlap [length]."""
    deepest = 0.0
    for one, two in combinations(found.polygon.values(), 2):
        common = one.intersection(two)
        pieces = [piece for piece in getattr(common, "geoms", [common]) if piece.area > 0]
        deepest = max([deepest, *(2 * piece.area / piece.length for piece in pieces)])
    return deepest


def entered_area(found: Shapes) -> float:
    """Return the largest area that the filled outlines of two cells have in common."""
    filled = [shapely.union_all([shapely.Polygon(piece.exterior) for piece in getattr(one, "geoms", [one])
                                 if piece.geom_type == "Polygon"]) for one in found.polygon.values()]  # fmt: skip
    return max((one.intersection(two).area for one, two in combinations(filled, 2)), default=0.0)


def lumen_areas(fields: Fields) -> dict[int, tuple[float, float]]:
    """Return the area of each cell's lumen, at rest and deformed; of cells without one nothing."""
    rest, moved = fields.sides(fields.rest), fields.sides(fields.moved)
    sign = np.sign(_area(rest[:, :, :-1].reshape(len(rest), -1, 2)))
    found = {}
    for cell in fields.cells:
        mine = np.flatnonzero(fields.cell == cell)
        inner = _inner_sides(rest[mine].reshape(-1, _ON_SIDE, 2))
        if inner is None:
            continue
        direction = np.repeat(sign[mine], rest.shape[1])[inner]
        lines = (side[mine].reshape(-1, _ON_SIDE, 2)[inner] for side in (rest, moved))
        before, after = (-float((direction * _swept(line)).sum()) for line in lines)
        found[cell] = before, after
    return found


def _swept(line: Array) -> Array:
    """Return the area between each line and the origin, by the trapezoids of its points."""
    x, y = line[..., 0], line[..., 1]
    return np.asarray((x[:, :-1] * y[:, 1:] - x[:, 1:] * y[:, :-1]).sum(1) / 2)


def _inner_sides(sides: Array) -> Index | None:
    """Return the sides of a cell's elements, (sides, points, 2), that lie around its lumen; None if it has none."""
    scale = np.abs(sides).max() or 1.0
    _, place = np.unique(np.round(sides[:, _ON_SIDE // 2] / scale, 7), axis=0, return_inverse=True)
    alone = np.flatnonzero(np.bincount(place.ravel())[place.ravel()] == 1)
    ends = sides[alone][:, [0, -1]].reshape(-1, 2)
    _, corner = np.unique(np.round(ends / scale, 7), axis=0, return_inverse=True)
    one, two = corner.reshape(-1, 2).T
    size = int(corner.max()) + 1
    loops, of_corner = connected_components(sparse.csr_array((np.ones(len(one)), (one, two)), shape=(size, size)), directed=False)
    if loops < 2:
        return None
    of_side = of_corner[one]
    extent = [np.ptp(sides[alone][of_side == loop].reshape(-1, 2), axis=0).sum() for loop in range(loops)]
    return np.asarray(alone[of_side != int(np.argmax(extent))])
