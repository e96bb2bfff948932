"""The stiffness of penalty terms, from the walls and their material."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.surface import Surface

Array = NDArray[np.float64]


def penalty_stiffness(walls: Surface, modulus_of_body: Array, multiple: float) -> Array:
    """Return the stiffness of each facet [stress / length] from its body's plane-strain modulus [stress].

    It is the same all over a body, that of its thinnest layer: were it each facet's own, the energy of a closed
    contact would jump where a point slides from one facet to the next.
    """
    thinnest = np.full(len(modulus_of_body), np.inf)
    np.minimum.at(thinnest, walls.body, walls.depth)
    return np.asarray(multiple * (modulus_of_body / thinnest)[walls.body])
