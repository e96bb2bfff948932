"""The closest point of a body's surface: three steps, each with one algorithm on edges and one on faces.

Candidates narrow the choice, Newton's method on the curved facet finishes it, and what was found is classified: the
foot of a normal, or a point where facets meet or end.
"""

from __future__ import annotations

from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing import closest_on_edges as on_edges
from ngcell.contact.pairing import closest_on_facets as on_facets
from ngcell.contact.pairing.classification import Classification
from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.facets import FacetSurface
from ngcell.contact.surface.surface import Surface

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@singledispatch
def nearest_candidates(
    walls: Surface, nodes: Array, group: Index, facet: Index, point: Array, reach: float | Array
) -> Index:
    """Return the candidates that may hold the nearest point of the same body.

    Parameters
    ----------
    walls : Surface
        The walls.
    nodes : array of float, shape (facets, nodes, dimension)
        Deformed positions of their nodes [length].
    group, facet : array of int, shape (candidates,)
        Number of the point, and facet.
    point : array of float, shape (candidates, dimension)
        The points [length].
    reach : float or array of float, shape (candidates,)
        Distance beyond which nothing is a candidate [length].
    """
    raise NotImplementedError(type(walls))


@singledispatch
def closest_points(walls: Surface, nodes: Array, facet: Index, point: Array) -> tuple[Array, Array]:
    """Return coordinates and distance [length] of the closest point on the facet of each point.

    Parameters
    ----------
    walls : Surface
        The walls.
    nodes : array of float, shape (facets, nodes, dimension)
        Deformed positions of their nodes [length].
    facet : array of int, shape (n,)
        Facet for each point.
    point : array of float, shape (n, dimension)
        The points [length].
    """
    raise NotImplementedError(type(walls))


@singledispatch
def classified(walls: Surface, nodes: Array, facet: Index, xi: Array, point: Array) -> Classification:
    """Tell feet of normals from points where facets meet or end; parameters as for `closest_points`.

    `xi` has the coordinates of the closest points.
    """
    raise NotImplementedError(type(walls))


nearest_candidates.register(EdgeSurface, on_edges.nearest_candidates)
nearest_candidates.register(FacetSurface, on_facets.nearest_candidates)
closest_points.register(EdgeSurface, on_edges.closest_points)
closest_points.register(FacetSurface, on_facets.closest_points)
classified.register(EdgeSurface, on_edges.classified)
classified.register(FacetSurface, on_facets.classified)
