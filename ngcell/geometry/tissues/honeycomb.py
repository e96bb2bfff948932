"""A honeycomb: rows and columns of equal, regular, hollow hexagonal cells, in the plane or as layers of prisms."""

from __future__ import annotations

from typing import Literal

from ngcell.geometry.tissues.hexagonal import HexagonalCells


class Tissue(HexagonalCells):
    """A patch of regular hexagonal cells; its keys are those of `ngcell.geometry.tissues.hexagonal.HexagonalCells`."""

    kind: Literal["honeycomb"] = "honeycomb"
