"""What tissues of cells of any outline share: their walls, how they are meshed, and what plates and frames hold."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from math import ceil, sqrt
from typing import Any, ClassVar, Self

import numpy as np
from pydantic import ValidationInfo, field_validator, model_validator

from ngcell.errors import GeometryError
from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.held import held_walls
from ngcell.geometry.lumens import check_corners, check_lumens
from ngcell.geometry.outlines import Outlines
from ngcell.geometry.short_sides import without_short_sides
from ngcell.geometry.tissues.protocol import Lumens, TissueDensity
from ngcell.geometry.tissues.stacks import (
    MOST_CELLS,
    Stack,
    checked_end_wall,
    checked_layers,
    default_size,
    edges_along,
    ring_elements,
    stacked_mesh,
    through_wall,
)
from ngcell.scene.scope import refuse
from ngcell.scene.section import NonNegativeNumber, PositiveCount, PositiveNumber, Section

#: Distance as a share of a cell's side that round-off makes.
_ROUND_OFF = 1e-6


class OutlinedCells(Section):
    """Cells whose outlines are polygons, each a body of its own: what their kinds share.

    Parameters
    ----------
    kind : str
        The kind of tissue.
    wall : float
        Thickness of the walls, > 0; every lumen stays open.
    corner_radius : float
        Radius of the outer wall's convex corners of 120 degrees, >= 0; others lose the same length of wall. 0 is
        sharp. The inner wall keeps its corners.
    shortest : float
        Smallest length of a side of a lumen, as a share of `wall`, >= 0. Shorter ones are no good to mesh: the side is
        collapsed into a corner, and `ngcell check` tells how many were. With 0 nothing is collapsed, and a wall that
        leaves a side of the lumen no length is refused.
    held_within : float, optional
        Plates hold the outer walls that lie whole within this distance of the tissue's lower or upper edge, > 0; by
        default half of a cell's side, which is that of a hexagon of the cells' mean area.
    height : float, optional
        Height of the cells along z, > 0: they are prisms, hollow from end to end. Without it the scene is planar.
    end_wall : float, optional
        Thickness of walls that close both ends of prisms, in (0, height / 2).
    layers : int
        Number of layers of prisms, >= 1, each of this height, stacked along z.
    """

    #: Share of a cell's side that `held_within` is by default.
    held_share: ClassVar[float] = 0.5
    #: Elements in lumens of one grading are no parts of those of another.
    nests_lumens: ClassVar[bool] = False

    kind: str
    wall: PositiveNumber
    corner_radius: NonNegativeNumber = 0.0
    shortest: NonNegativeNumber = 0.0
    held_within: PositiveNumber | None = None
    height: PositiveNumber | None = None
    end_wall: PositiveNumber | None = None
    layers: PositiveCount = 1

    @abstractmethod
    def drawn(self) -> Outlines:
        """Return the outlines as they are given, before short sides are collapsed."""

    @cached_property
    def plan(self) -> tuple[Outlines, int]:
        """Outlines of the cells of a layer, and how many short sides they have lost."""
        return without_short_sides(self.drawn(), self.wall, self.shortest)

    @property
    def outlines(self) -> Outlines:
        """Outlines of the cells of a layer."""
        return self.plan[0]

    @property
    def walls(self) -> float:
        """Thickness of the walls [length]."""
        return self.wall

    @property
    def side(self) -> float:
        """The scale of a cell: side of a regular hexagon of the cells' mean area [length]."""
        return self.outlines.side

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return self.outlines.cell_count * self.layers

    @property
    def grid(self) -> tuple[int, int]:
        """Number of layers, and of cells in each."""
        return self.layers, self.outlines.cell_count

    def element_count(self, choice: TissueDensity) -> int:
        """Return the number of elements, at least, without meshing."""
        size = self._size(choice)
        edges = edges_along(self.outlines.lengths, self.wall, size, choice)
        return ring_elements(edges, through_wall(self.wall, size, choice), choice, self._stack(choice))

    def mesh(
        self, supported: str | None, choice: TissueDensity, lumens: Lumens | None = None, *, filled: bool = False
    ) -> BodyMesh:
        """Return the mesh, one body a cell; see `ngcell.geometry.tissues.protocol.TissueGeometry`."""
        size, stack = self._size(choice), self._stack(choice)
        edges = edges_along(self.outlines.lengths, self.wall, size, choice)
        if filled or self.end_wall is not None:
            edges += edges % 2  # lumens are meshed between every second node
        within = (self.held_within or self.held_share * self.side) + _ROUND_OFF * self.side
        choices: dict[str, Any] = {
            "wall": self.wall,
            "radius": self.corner_radius,
            "edges": edges,
            "layers": through_wall(self.wall, size, choice),
            "grading": choice.grading or 0,
            "supports": held_walls(self.outlines, supported, within),
            "filled": filled,
        }
        return stacked_mesh(self.outlines, stack, lumens, choices)

    def _size(self, choice: TissueDensity) -> float:
        return choice.size or default_size(self.side, self.wall)

    def _stack(self, choice: TissueDensity) -> Stack | None:
        if self.height is None:
            return None
        slices = choice.slices or max(1, ceil(self.height / self._size(choice) - 1e-9))
        return Stack(self.layers, self.height, slices, self.end_wall)

    @field_validator("end_wall")
    @classmethod
    def _within_the_height(cls, end_wall: float | None, info: ValidationInfo) -> float | None:
        return checked_end_wall(end_wall, info.data.get("height"))

    @field_validator("layers")
    @classmethod
    def _of_prisms(cls, layers: int, info: ValidationInfo) -> int:
        return checked_layers(layers, info.data.get("height", layers))

    @model_validator(mode="after")
    def _can_be_built(self) -> Self:
        try:
            outlines = self.outlines
        except GeometryError as error:
            refuse("{reason}", reason=str(error))
        if self.layers > 1 and self.cell_count > MOST_CELLS:
            refuse("make {count} cells; allowed: {most}", "layers", count=self.cell_count, most=MOST_CELLS)
        for key, check in (("wall", check_lumens), ("corner_radius", self._check_corners)):
            try:
                check(outlines, self.wall)
            except GeometryError as error:
                refuse("{reason}", key, reason=str(error))
        return self

    def _check_corners(self, outlines: Outlines, wall: float) -> None:
        check_corners(outlines, np.asarray(wall), self.corner_radius / sqrt(3))
