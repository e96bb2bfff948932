"""Bricks in running bond: rows of rectangles, every second row moved along by part of a brick."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from ngcell.geometry.outlines import Outlines
from ngcell.geometry.partition import outlines_of
from ngcell.geometry.tissues.outlined import OutlinedCells
from ngcell.geometry.tissues.stacks import checked_cols
from ngcell.scene.section import PositiveCount, PositiveNumber

#: Distance as a share of a brick's shorter side below which places are one.
_SAME = 1e-6


class Brick(OutlinedCells):
    """Rows of equal rectangular cells, numbered row by row from below; joints of rows lie in the middle of the next.

    Parameters
    ----------
    rows, cols : int
        Number of rows and of cells in each row, >= 1; together at most `MOST_CELLS` cells.
    aspect : float
        Length of a cell along x over its height along y, > 0.
    length : float
        Length of a cell along x, > 0.
    stagger : float
        How far every second row is moved, as a share of a cell, in [0, 1); 0 sets joints above joints.

    Notes
    -----
    By default plates hold the walls on the straight edges of the tissue and no others. Further keys are those of
    `ngcell.geometry.tissues.outlined.OutlinedCells`.
    """

    held_share: ClassVar[float] = 0.0

    kind: Literal["brick"] = "brick"
    rows: PositiveCount
    cols: PositiveCount
    aspect: PositiveNumber
    length: PositiveNumber = 2.0
    stagger: Annotated[float, Field(ge=0, lt=1)] = 0.5

    @field_validator("cols")
    @classmethod
    def _few_enough(cls, cols: int, info: ValidationInfo) -> int:
        return checked_cols(cols, info.data.get("rows", 1))

    @property
    def grid(self) -> tuple[int, int]:
        """Number of rows, those of all layers, and of cells in each."""
        return self.rows * self.layers, self.cols

    def drawn(self) -> Outlines:
        """Return the outlines."""
        row, col = np.divmod(np.arange(self.rows * self.cols), self.cols)
        size = self.length * np.array([1.0, 1 / self.aspect])
        foot = np.column_stack([col + self.stagger * (row % 2), row])
        corners = (foot[:, None] + [(0, 0), (1, 0), (1, 1), (0, 1)]) * size
        return outlines_of(list(corners), _SAME * size.min())
