"""What a closest point is: the foot of a normal, or a point where facets meet or end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Share by which the distances of facets that are equally near are told apart: where two meet, by which of them sees
#: the point outside.
TIE = 1e-7


class Classification(NamedTuple):
    """What closest points are; all arrays have one entry a point.

    Attributes
    ----------
    at_end : array of bool
        Whether the closest point is no foot of a normal.
    sign : array of float
        +1 outside the body, -1 inside.
    slide_direction : array of float, shape (n, 2), of edges (n, 0)
        Coordinate direction of the side along which the closest point may slide; 0 at corners and at feet.
    slid_past : array of bool
        Whether the point lies behind the facet, and further aside than deep, where the walls end.
    """

    at_end: NDArray[np.bool_]
    sign: NDArray[np.float64]
    slide_direction: NDArray[np.float64]
    slid_past: NDArray[np.bool_]
