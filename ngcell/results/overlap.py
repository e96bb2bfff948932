"""How deep bodies lie inside each other, measured without the contact search: by outlines, or by closed surfaces."""

from __future__ import annotations

from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.facets import FacetSurface
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.space import DisplacementSpace
from ngcell.results.outline_overlap import deepest_overlap_of_faces
from ngcell.results.solid_overlap import deepest_overlap_of_solids

Array = NDArray[np.float64]


def deepest_overlap_of_bodies(
    space: DisplacementSpace, walls: Surface, positions: Array, unit: Array | None = None
) -> float:
    """Return the largest depth, >= 0, by which a wall point of a body lies inside another body.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns of the bodies.
    walls : Surface
        Their walls.
    positions : array of float, shape (dimension, scalar unknowns)
        Deformed positions as unknowns [length].
    unit : array of float, shape (bodies,), optional
        A length of each body; a depth is taken over the smaller one of the two. By default it is a length.
    """
    return _deepest_overlap(walls, space, positions, np.ones(space.body_count) if unit is None else unit)


@singledispatch
def _deepest_overlap(walls: Surface, space: DisplacementSpace, positions: Array, unit: Array) -> float:
    raise NotImplementedError(type(walls))


_deepest_overlap.register(EdgeSurface, deepest_overlap_of_faces)
_deepest_overlap.register(FacetSurface, deepest_overlap_of_solids)
