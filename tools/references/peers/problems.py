"""The two problems that all programs solve, and their exact answers.

blocks
    Two unit blocks on each other between slippery walls, pressed together by a tenth of their height, on meshes that do
    not match: every section bears the same pressure.
rings
    A quarter of a press-fit: a ring [0.5, 1.0] in one of [0.9, 1.5], by its one-dimensional solution.

mu = 1, c1 = c2, plane strain; kappa / mu is 5 for the blocks, 100 for the rings.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.references import radial

Array = NDArray[np.float64]

C1, C2 = 0.5, 0.5
PRESSED = 0.9
RADII = ((0.5, 1.0), (0.9, 1.5))
KAPPA = {"blocks": 5.0, "rings": 100.0}


@dataclass(frozen=True)
class Grid:
    """A body as a structured grid of quadratic quadrilaterals.

    Attributes
    ----------
    places : array of float, shape (2 nx + 1, 2 ny + 1, 2)
        Places of nodes [length]; x across the bodies, or along radii.
    """

    places: Array

    @property
    def cells(self) -> tuple[int, int]:
        """Number of elements along both directions."""
        return (self.places.shape[0] - 1) // 2, (self.places.shape[1] - 1) // 2


def grids(problem: str, count: int) -> tuple[Grid, Grid]:
    """Return both bodies with about `count` elements along the first, and fewer along the second: lower, or inner."""
    fewer = max(1, (3 * count) // 4)
    if problem == "blocks":
        return _block(0.0, count), _block(1.0, fewer)
    return _ring(*RADII[0], count), _ring(*RADII[1], fewer)


def _block(bottom: float, count: int) -> Grid:
    x = np.linspace(0.0, 1.0, 2 * count + 1)
    return Grid(np.stack(np.meshgrid(x, bottom + x, indexing="ij"), axis=-1))


def _ring(bore: float, rim: float, count: int) -> Grid:
    radius, angle = np.linspace(bore, rim, 2 * count + 1), np.linspace(0, np.pi / 2, 4 * count + 1)
    r, t = np.meshgrid(radius, angle, indexing="ij")
    return Grid(np.stack([r * np.cos(t), r * np.sin(t)], axis=-1))


def exact_force(problem: str, *, in_logarithm: bool) -> float:
    """Return what the upper wall, or a plane of symmetry of the outer ring, bears [stress * length].

    The volumetric energy is ``kappa/2 (ln J)^2``, or ``kappa/2 (J - 1)^2``; on the rings the two differ by less than
    anything is told here.
    """
    kappa = KAPPA[problem]
    solid = radial.RadialSolid(C1, C2, kappa)
    if problem == "rings":
        state = radial.press_fit(radial.Ring(solid, *RADII[0]), radial.Ring(solid, *RADII[1]))
        return float(state.contact_pressure * state.outside.inner)
    pressure = -float(solid.slopes(1.0, PRESSED)[1])
    return pressure if in_logarithm else pressure + kappa * (np.log(PRESSED) / PRESSED - (PRESSED - 1))
