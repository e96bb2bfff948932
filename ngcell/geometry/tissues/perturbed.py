"""A honeycomb whose corners have moved at random: as irregular as asked for, the regular one at nothing."""

from __future__ import annotations

from functools import cached_property
from math import sqrt
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ngcell.errors import GeometryError
from ngcell.geometry.lumens import check_corners, check_lumens
from ngcell.geometry.near import components, near_pairs
from ngcell.geometry.outlines import Outlines
from ngcell.geometry.tissues.hexagonal import HexagonalCells, supported_walls
from ngcell.scene.scope import refuse

Array = NDArray[np.float64]

#: Distance as a share of the side below which corners of cells are one.
_SAME = 1e-6
#: What a seed draws: displacements of corners, thicknesses of walls.
_OF_CORNERS, _OF_WALLS = 0, 1


class Perturbed(HexagonalCells):
    """A honeycomb whose corners are displaced at random, the same corner alike in all cells that share it.

    Corners of walls that plates hold keep their height and move along x only: so the plates' zigzag keeps the straight
    lines that its corners lie on, and the tissue its height, whatever the load. All other corners move within a disc.
    With nothing but zeros it is the honeycomb, and displacements of a seed grow in proportion to `spread`.

    Parameters
    ----------
    spread : float
        Largest displacement of a corner, as a share of the side, in [0, 1/2); displacements are distributed evenly
        over the disc.
    wall_spread : float
        Largest deviation of a cell's wall from `wall`, as a share of it, in [0, 1); deviations are distributed
        evenly, and each cell has one.
    seed : int
        Number that displacements and thicknesses are drawn from, >= 0.

    Notes
    -----
    Further keys are those of `ngcell.geometry.tissues.hexagonal.HexagonalCells`.
    """

    kind: Literal["perturbed"] = "perturbed"
    spread: Annotated[float, Field(ge=0, lt=0.5)]
    wall_spread: Annotated[float, Field(ge=0, lt=1)] = 0.0
    seed: Annotated[int, Field(ge=0)] = 0

    @cached_property
    def outlines(self) -> Outlines:
        """Outlines of the cells of a layer."""
        regular = self.lattice.outlines
        one, two = near_pairs(regular.corners, _SAME * self.side)
        place = components(len(regular.corners), one, two)
        draw = np.random.default_rng((self.seed, _OF_CORNERS))
        size, angle = draw.uniform(0, 1, place.max() + 1) ** 0.5, draw.uniform(0, 2 * np.pi, place.max() + 1)
        moved = self.spread * self.side * size[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        moved[place[self._on_plates(regular)], 1] = 0.0
        return Outlines(regular.corners + moved[place], regular.counts, regular.twins)

    @property
    def walls(self) -> Array:
        """Thickness of the wall of each cell of a layer [length], shape (cells,)."""
        draw = np.random.default_rng((self.seed, _OF_WALLS))
        return np.asarray(self.wall * (1 + self.wall_spread * draw.uniform(-1, 1, self.rows * self.cols)))

    def _on_plates(self, regular: Outlines) -> NDArray[np.bool_]:
        """Return which corners are ends of walls that plates hold, shape (corners,)."""
        held = np.any([walls.ravel() for walls in supported_walls(self.lattice, "plates").values()], axis=0)
        return np.asarray(held | held[regular.behind])

    @model_validator(mode="after")
    def _with_lumens(self) -> Self:
        try:
            check_lumens(self.outlines, self.walls)
            if self.corner_radius:
                check_corners(self.outlines, self.walls, self.corner_radius / sqrt(3))
        except GeometryError as error:
            refuse("{reason}; or a smaller spread", "spread", reason=str(error))
        return self
