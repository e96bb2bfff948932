"""Bodies as grids of quadratic quadrilaterals with named sides: what every program makes its mesh of.

A grid is laid out along two directions. Its four sides are `first` and `last`, where the first direction begins and
ends, `low` and `high` along the second. A hollow cell is closed along the second direction, and its walls and those of
its lumen are sides of their own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Grid:
    """A body.

    Attributes
    ----------
    places : array of float, shape (nodes, 2)
        Places of nodes at rest [length].
    elements : array of int, shape (elements, 3, 3)
        Nodes of each element, along the first and the second direction, which go round counterclockwise.
    sides : mapping of str to array of int, shape (2 * edges + 1,)
        Nodes of each side, one after another.
    size : float
        Thickness of a layer of elements across the body [length].
    """

    places: Array
    elements: Indices
    sides: Mapping[str, Indices]
    size: float

    def on(self, sides: tuple[str, ...]) -> Indices:
        """Return the nodes on any of these sides, each once."""
        return np.unique(np.concatenate([self.sides[side] for side in sides]))

    def middle(self, side: str) -> int:
        """Return the node in the middle of a side."""
        nodes = self.sides[side]
        return int(nodes[len(nodes) // 2])


def block(bottom: float, count: int) -> Grid:
    """Return a unit square that stands at this height, with as many elements along both directions."""
    x = np.linspace(0.0, 1.0, 2 * count + 1)
    return _open(np.stack(np.meshgrid(x, bottom + x, indexing="ij"), axis=-1), 1 / count)


def quarter(bore: float, rim: float, count: int) -> Grid:
    """Return a quarter of a ring, `count` elements across."""
    radius, angle = np.linspace(bore, rim, 2 * count + 1), np.linspace(0, np.pi / 2, 4 * count + 1)
    r, t = np.meshgrid(radius, angle, indexing="ij")
    return _open(np.stack([r * np.cos(t), r * np.sin(t)], axis=-1), (rim - bore) / count)


def _open(places: Array, size: float) -> Grid:
    width, height = places.shape[:2]
    nodes = np.arange(width * height).reshape(width, height)
    sides = {"first": nodes[0], "last": nodes[-1], "low": nodes[:, 0], "high": nodes[:, -1]}
    return Grid(places.reshape(-1, 2), _elements(nodes), sides, size)


def hollow_cell(centre: Array, first: float, wall: float, cut: float, count: int) -> Grid:
    """Return a hollow hexagonal cell whose sides were 1 long before its corners were cut.

    Its sides are `wall0` to `wall5`, counterclockwise, of four elements for each across the wall, the first of which
    faces the direction `first`; `corner0`, of two elements for each across, to `corner5`, each after the wall of its
    number; and `lumen0` to `lumen5`, whose corners are sharp.

    Parameters
    ----------
    centre : array of float, shape (2,)
        Its centre [length].
    first : float
        Angle of the normal of its first wall [radians].
    wall : float
        Thickness of its wall [length].
    cut : float
        How much of each end of a wall is cut off [length].
    count : int
        Elements across the wall.
    """
    angle = first + np.radians(60 * np.arange(7) - 30)
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    outline = np.concatenate([_along(*ends, cut, count) for ends in zip(corners, corners[1:], strict=False)])
    share = np.arange(12 * count)[:, None] / (12 * count)
    lumen = np.concatenate([a + share * (b - a) for a, b in zip(corners, corners[1:], strict=False)])
    lumen *= 1 - 2 * wall / np.sqrt(3)
    outwards = np.linspace(0, 1, 2 * count + 1)[:, None, None]
    places = centre + (1 - outwards) * lumen + outwards * outline
    nodes = np.arange(places.shape[0] * places.shape[1]).reshape(places.shape[:2])
    sides = {}
    for number in range(6):
        start = 12 * count * number
        whole, kept, cut_off = (np.arange(2 * count * elements + 1) for elements in (6, 4, 2))
        sides[f"lumen{number}"] = nodes[0, (start + whole) % nodes.shape[1]]
        sides[f"wall{number}"] = nodes[-1, start + 2 * count + kept]
        sides[f"corner{number}"] = nodes[-1, (start + 10 * count + cut_off) % nodes.shape[1]]
    return Grid(places.reshape(-1, 2), _elements(np.concatenate([nodes, nodes[:, :1]], axis=1)), sides, wall / count)


def _along(start: Array, end: Array, cut: float, count: int) -> Array:
    """Return nodes of the outline from the middle of a cut corner to that of the next, without the last one."""
    points = ((1 - cut / 2) * start, (1 - cut) * start + cut * end, cut * start + (1 - cut) * end, (1 - cut / 2) * end)
    return np.concatenate(
        [
            a + np.arange(2 * elements)[:, None] / (2 * elements) * (b - a)
            for a, b, elements in zip(points, points[1:], (count, 4 * count, count), strict=False)
        ]
    )


def _elements(nodes: Indices) -> Indices:
    """Return the nodes of the elements of a grid of nodes, shape (elements, 3, 3)."""
    width, height = nodes.shape
    corners = product(range(0, width - 1, 2), range(0, height - 1, 2))
    return np.array([nodes[i : i + 3, j : j + 3] for i, j in corners])
