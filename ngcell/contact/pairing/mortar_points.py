"""The points at which two walls that face each other are integrated over: on segments, or on intersection polygons."""

from __future__ import annotations

from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.intersections import find_intersections, intersection_pairs
from ngcell.contact.pairing.near import Reach
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.pairing.segments import find_segments, segment_pairs
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.facets import FacetSurface
from ngcell.contact.surface.surface import Surface

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@singledispatch
def mortar_points(
    walls: Surface, nodes: Array, primary: Index, secondary: Index, reach: Reach, limit: float
) -> ContactPairs:
    """Return the Gauss points on what faces each other of pairs of facets, with their closest points.

    Parameters
    ----------
    walls : Surface
        The walls.
    nodes : array of float, shape (facets, nodes, dimension)
        Deformed positions of their nodes [length].
    primary, secondary : array of int
        The facets that are integrated over, and those that they may face.
    reach : float or array of float, shape (bodies,)
        Distance beyond which nothing is integrated [length].
    limit : float
        Product of normals below which facets face each other; see `ngcell.contact.options.ContactOptions`.
    """
    raise NotImplementedError(type(walls))


@mortar_points.register
def _(walls: EdgeSurface, nodes: Array, primary: Index, secondary: Index, reach: Reach, limit: float) -> ContactPairs:
    return segment_pairs(walls, nodes, find_segments(walls, nodes, primary, secondary, limit), reach)[0]


@mortar_points.register
def _(walls: FacetSurface, nodes: Array, primary: Index, secondary: Index, reach: Reach, limit: float) -> ContactPairs:
    return intersection_pairs(walls, nodes, find_intersections(walls, nodes, primary, secondary, limit), reach)
