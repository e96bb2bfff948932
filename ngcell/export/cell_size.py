"""The size of a cell in a picture, which widths of lines, markers, numbers and the count of pixels follow from.

Pictures of tens of cells are drawn as they always were. Where there are more, lines and markers shrink with the cell,
or they would cover it, and the picture has more pixels, up to twice as many along each side.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Pixels to the inch of a picture of a few cells.
DPI = 150
_MOST_DPI = 300
#: Pixels that a cell should be wide, as far as the picture may grow.
_PIXELS = 56
_POINTS_AN_INCH = 72


@dataclass(frozen=True, slots=True)
class CellSize:
    """The width of a cell in a picture.

    Attributes
    ----------
    points : float
        The width [typographic points], of 1/72 inch.
    """

    points: float

    @classmethod
    def of(cls, places: NDArray[Any], count: int, inches: float) -> CellSize:
        """Return that of `count` cells which fill the rectangle around places, drawn at `inches` a unit of length.

        Parameters
        ----------
        places : array of float, shape (places, 2)
            Points of the cells at rest [length].
        count : int
            Number of cells; > 0.
        inches : float
            Of the picture, to the unit of length.
        """
        return cls(sqrt(float(np.ptp(places, axis=0).prod()) / max(count, 1)) * inches * _POINTS_AN_INCH)

    @property
    def dpi(self) -> float:
        """Pixels to the inch at which a cell is wide enough, as far as the picture may grow."""
        return float(np.clip(_PIXELS * _POINTS_AN_INCH / max(self.points, 1e-9), DPI, _MOST_DPI))

    def at_most(self, width: float, share: float) -> float:
        """Return a width [points], smaller where it would be more than this share of the cell."""
        return min(width, share * self.points)
