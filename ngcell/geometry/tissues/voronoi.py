"""A Voronoi tissue: irregular cells around random points, cut to a rectangle."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, Strict

from ngcell.geometry.outlines import Outlines
from ngcell.geometry.partition import outlines_of
from ngcell.geometry.tissues.outlined import OutlinedCells
from ngcell.geometry.tissues.stacks import MOST_CELLS
from ngcell.geometry.voronoi import relaxed, voronoi_cells
from ngcell.scene.section import NonNegativeNumber, PositiveNumber

#: Distance as a share of a cell's size below which places are one.
_SAME = 1e-7


class Voronoi(OutlinedCells):
    """Voronoi cells of points drawn at random in a rectangle, cut to it, and numbered from below.

    Parameters
    ----------
    cells : int
        Number of cells, 2 to `MOST_CELLS`.
    extent : tuple of float, shape (2,)
        Width and height of the rectangle, both > 0.
    seed : int
        Number that the points are drawn from, >= 0.
    relaxation : int
        Number of Lloyd's steps, 0 to 1000, each of which moves all points to the centroids of their cells: the more,
        the more regular.
    shortest : float
        As for all, but 1/4 by default: a Voronoi tissue has sides of any length.

    Notes
    -----
    By default plates hold the walls on the straight edges of the tissue and no others. Further keys are those of
    `ngcell.geometry.tissues.outlined.OutlinedCells`.
    """

    held_share: ClassVar[float] = 0.0

    kind: Literal["voronoi"] = "voronoi"
    shortest: NonNegativeNumber = 0.25
    cells: Annotated[int, Field(ge=2, le=MOST_CELLS)]
    extent: Annotated[tuple[PositiveNumber, PositiveNumber], Strict(False)]
    seed: Annotated[int, Field(ge=0)] = 0
    relaxation: Annotated[int, Field(ge=0, le=1000)] = 2

    def drawn(self) -> Outlines:
        """Return the outlines."""
        drawn = np.random.default_rng(self.seed).uniform(0, 1, (self.cells, 2)) * self.extent
        points = relaxed(drawn, *self.extent, self.relaxation)
        points = points[np.lexsort(points.T)]
        return outlines_of(voronoi_cells(points, *self.extent), _SAME * float(np.prod(self.extent) / self.cells) ** 0.5)
