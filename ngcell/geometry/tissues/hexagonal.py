"""What tissues of hexagonal cells share, regular or not: rows and columns, walls, and prisms on them."""

from __future__ import annotations

from math import ceil, sqrt
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationInfo, field_validator

from ngcell.geometry.bodies import FRAME, LOWER_PLATE, UPPER_PLATE, BodyMesh
from ngcell.geometry.filling import are_three_quadrangles
from ngcell.geometry.held import confined_walls
from ngcell.geometry.lattice import WALLS, Lattice, hexagonal_lattice
from ngcell.geometry.outlines import Outlines
from ngcell.geometry.tissues.protocol import Lumens, TissueDensity
from ngcell.geometry.tissues.stacks import (
    MOST_CELLS,
    Stack,
    checked_cols,
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

Array = NDArray[np.float64]

#: Distance as a share of a cell's side that round-off makes.
_ROUND_OFF = 1e-6


class HexagonalCells(Section):
    """A patch of cells of six walls, in rows and columns, each a body of its own.

    Parameters
    ----------
    kind : str
        The kind of tissue.
    rows, cols : int
        Number of rows and of cells in each row, >= 1; together at most `MOST_CELLS` cells.
    side : float
        Side of the outer hexagon, > 0; it sets the unit of length of the whole case.
    wall : float
        Thickness of the wall, in (0, apothem): the lumen stays open.
    corner_radius : float
        Radius of the outer wall's corners, in [0, apothem); 0 is sharp. The inner wall keeps its corners,
        so the radius stays below ``wall / (1 - sqrt(3) / 2)``, where it would cut through them.
    orientation : {"pointy", "flat"}
        Whether a corner or a wall of each cell points upwards.
    height : float, optional
        Height of the cells along z, > 0: they are prisms, hollow from end to end. Without it the scene is planar.
    end_wall : float, optional
        Thickness of walls that close both ends of prisms, in (0, height / 2).
    layers : int
        Number of layers of prisms, >= 1, each of this height, stacked along z; each holds cells of its own, which
        may touch those of the layers above and below. Together at most `MOST_CELLS` cells.
    """

    kind: str
    rows: PositiveCount
    cols: PositiveCount
    side: PositiveNumber = 1.0
    wall: PositiveNumber
    corner_radius: NonNegativeNumber = 0.0
    orientation: Literal["pointy", "flat"] = "pointy"
    height: PositiveNumber | None = None
    end_wall: PositiveNumber | None = None
    layers: PositiveCount = 1

    @property
    def apothem(self) -> float:
        """Distance from a cell's centre to the middle of its outer walls."""
        return _apothem(self.side)

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return self.rows * self.cols * self.layers

    @property
    def grid(self) -> tuple[int, int]:
        """Number of rows, those of all layers, and of cells in each: cells are numbered row by row, from below."""
        return self.rows * self.layers, self.cols

    @property
    def lattice(self) -> Lattice:
        """Where the cells of a layer sit."""
        return hexagonal_lattice(self.rows, self.cols, side=self.side, pointy=self.orientation == "pointy")

    @property
    def outlines(self) -> Outlines:
        """Outlines of the cells of a layer."""
        return self.lattice.outlines

    @property
    def walls(self) -> Array | float:
        """Thickness of the walls [length], of each cell of a layer or of all."""
        return self.wall

    @property
    def nests_lumens(self) -> bool:
        """Whether elements in lumens of one grading are parts of those of another: lumens that Netgen has to mesh are
        meshed anew."""
        lumens = self.outlines.moved_inwards(self.walls).reshape(-1, WALLS, 2)
        return bool(are_three_quadrangles(lumens).all())

    def density(self, choice: TissueDensity) -> tuple[int, int]:
        """Return the number of elements along a side, between graded ones, and through the wall, before grading."""
        size = choice.size or default_size(self.side, self.wall)
        edges = edges_along(np.array([self.side]), self.wall, size, choice)
        return int(edges[0]), through_wall(self.wall, size, choice)

    def element_count(self, choice: TissueDensity) -> int:
        """Return the number of elements, at least, without meshing."""
        edges, through = self.density(choice)
        sides = np.full(WALLS * self.rows * self.cols, edges)
        return ring_elements(sides, through, choice, self._stack(choice))

    def mesh(
        self, supported: str | None, choice: TissueDensity, lumens: Lumens | None = None, *, filled: bool = False
    ) -> BodyMesh:
        """Return the mesh, one body a cell; see `ngcell.geometry.tissues.protocol.TissueGeometry`."""
        edges, through = self.density(choice)
        if (filled or self.end_wall is not None) and not self.nests_lumens:
            edges += edges % 2  # lumens are meshed between every second node
        choices: dict[str, Any] = {
            "wall": self.walls,
            "radius": self.corner_radius,
            "edges": edges,
            "layers": through,
            "grading": choice.grading or 0,
            "supports": supported_walls(self.lattice, supported),
            "filled": filled,
        }
        return stacked_mesh(self.outlines, self._stack(choice), lumens, choices)

    def _stack(self, choice: TissueDensity) -> Stack | None:
        if self.height is None:
            return None
        slices = choice.slices or max(1, ceil(self.height / self.side * self.density(choice)[0] - 1e-9))
        return Stack(self.layers, self.height, slices, self.end_wall)

    @field_validator("cols")
    @classmethod
    def _few_enough(cls, cols: int, info: ValidationInfo) -> int:
        return checked_cols(cols, info.data.get("rows", 1))

    @field_validator("wall")
    @classmethod
    def _open_lumen(cls, wall: float, info: ValidationInfo) -> float:
        if "side" in info.data and wall >= _apothem(info.data["side"]):
            refuse(
                "a wall this thick closes the lumen; allowed: 0 < wall < {apothem}, "
                "the cell's apothem (side * sqrt(3) / 2 with side = {side})",
                apothem=f"{_apothem(info.data['side']):.6g}",
                side=f"{info.data['side']:.6g}",
            )
        return wall

    @field_validator("end_wall")
    @classmethod
    def _within_the_height(cls, end_wall: float | None, info: ValidationInfo) -> float | None:
        return checked_end_wall(end_wall, info.data.get("height"))

    @field_validator("layers")
    @classmethod
    def _of_prisms(cls, layers: int, info: ValidationInfo) -> int:
        checked_layers(layers, info.data.get("height", layers))
        cells = info.data.get("rows", 1) * info.data.get("cols", 1)
        if layers * cells > MOST_CELLS:
            allowed = "with {cells} cells each these are {all}; allowed: rows * cols * layers <= {most}"
            refuse(allowed, cells=cells, all=layers * cells, most=MOST_CELLS)
        return layers

    @field_validator("corner_radius")
    @classmethod
    def _whole_corner(cls, radius: float, info: ValidationInfo) -> float:
        if "side" not in info.data or "wall" not in info.data:
            return radius
        apothem = _apothem(info.data["side"])
        cut_through = info.data["wall"] / (1 - sqrt(3) / 2)
        if radius >= min(apothem, cut_through):
            limit, reason = min(
                (apothem, "the cell's apothem (side * sqrt(3) / 2)"),
                (cut_through, "wall / (1 - sqrt(3) / 2), where it cuts through the wall's corners"),
            )
            refuse("allowed: 0 <= corner_radius < {limit}, {reason}", limit=f"{limit:.6g}", reason=reason)
        return radius


def _apothem(side: float) -> float:
    return side * sqrt(3) / 2


def supported_walls(lattice: Lattice, supported: str | None) -> dict[str, NDArray[np.bool_]]:
    """Return which walls each supported region consists of, as arrays of shape (cells, 6); see
    `ngcell.geometry.held.held_walls`. Side walls hold what lies whole within half of a cell's side."""
    if supported is None:
        return {}
    if supported == "frame":
        return {FRAME: lattice.neighbours < 0}
    top = int(lattice.row_of_cell.max())
    plates = {LOWER_PLATE: lattice.hull_walls(0, -1), UPPER_PLATE: lattice.hull_walls(top, 1)}
    if supported == "plates":
        return plates
    return {**plates, **confined_walls(lattice.outlines, plates, (0.5 + _ROUND_OFF) * lattice.side)}
