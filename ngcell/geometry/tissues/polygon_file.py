"""A tissue of polygons from a file, such as those of a segmented micrograph."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from ngcell.geometry.outlines import Outlines
from ngcell.geometry.partition import outlines_of
from ngcell.geometry.polygon_files import read_polygons
from ngcell.geometry.tissues.outlined import OutlinedCells
from ngcell.scene.section import FilePath, NonNegativeNumber, PositiveNumber

#: Distance as a share of the tissue's extent that round-off makes; width of the narrowest pore, as a share of a wall.
_ROUND_OFF, _NARROWEST = 1e-7, 0.5


class Polygons(OutlinedCells):
    """Cells whose outlines are polygons of a file, convex or not; those of neighbours meet along their common wall.

    A corner of one cell may lie inside a side of another. Cells do not overlap; what lies between them is a pore, and
    no load holds the walls around it.

    Parameters
    ----------
    file : str
        The file: GeoJSON (.geojson, .json), WKT (.wkt), or a table of corners (.csv) with the columns cell, x and y.
        Its path is relative to the case file; one that is given beside a case is relative to the working folder.
    scale : float
        Length of the file's unit, > 0.
    snap : float
        Distance up to which corners, and corners and sides, are one [length], >= 0; by default that of round-off. Gaps
        wider than this and narrower than half a wall are refused.

    Notes
    -----
    Further keys are those of `ngcell.geometry.tissues.outlined.OutlinedCells`.
    """

    kind: Literal["polygons"] = "polygons"
    file: FilePath
    scale: PositiveNumber = 1.0
    snap: NonNegativeNumber = 0.0

    def drawn(self) -> Outlines:
        """Return the outlines."""
        polygons, names = read_polygons(Path(self.file))
        scaled = [self.scale * polygon for polygon in polygons]
        extent = float(np.ptp(np.concatenate(scaled), axis=0).max())
        same = max(self.snap, _ROUND_OFF * extent)
        return outlines_of(scaled, same, narrowest=_NARROWEST * self.wall, names=names)
