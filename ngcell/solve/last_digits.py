"""Places without their last digits, where round-off would say how they were reached.

Round-off of one iteration is 1e-14 of a length. Where cells come free each further iteration enlarges it some ten
times, and in the end it chooses between branches: of 20 runs of one tissue, whose loads differ by round-off, no two end
alike. From a place that is rounded the way is the same to the bit. The digit is far above round-off, so
that hardly any of some ten thousand numbers lies so near to the middle between two digits that round-off decides, and
far below all that a wall feels. Where a step gains so little that rounding would cost a share of it, nothing is cut.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.one_sided import Matrix, OneSidedModel

Array = NDArray[np.float64]


def without_last_digits(place: Array, free: NDArray[np.bool_], digit: float) -> Array:
    """Return a place whose free unknowns are whole multiples of a digit [length]; prescribed values stay."""
    return np.where(free, digit * np.round(place / digit), place) if isfinite(digit) else place


@dataclass(frozen=True, eq=False)
class Rounding:
    """The last digits that a place loses after a step of a second-order model.

    Attributes
    ----------
    model : OneSidedModel
        The model, which tells what that costs.
    matrix : Matrix
        Its matrix.
    digit : float
        The digit [length].
    nothing : float
        What it may cost [energy].
    """

    model: OneSidedModel
    matrix: Matrix
    digit: float
    nothing: float

    def of(self, place: Array) -> Array:
        """Return a place without its last digits; the place itself if that costs too much."""
        rounded = without_last_digits(place, self.model.free, self.digit)
        if rounded is place:
            return place
        off = rounded - place
        bent, deeper = off @ self.matrix.multiply(self.model.stiffness, off), self.model.jacobian @ off
        return rounded if 0.5 * abs(bent + self.model.penalty @ deeper**2) < self.nothing else place
