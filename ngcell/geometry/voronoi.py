"""Voronoi cells of points in a rectangle.

The points are mirrored in each side of the rectangle: a wall between a point and its image lies on that side, so that
cells end there exactly (Du, Faber and Gunzburger, SIAM Rev. 41, 1999, doi:10.1137/S0036144599352836, for Lloyd's
iteration).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import GeometryError

Array = NDArray[np.float64]

#: Distance as a share of the rectangle below which a corner is on its side.
_ON_SIDE = 1e-9


def voronoi_cells(points: Array, width: float, height: float) -> list[Array]:
    """Return the corners of the cell of each point in [0, width] x [0, height], shape (corners, 2) each."""
    from scipy.spatial import QhullError, Voronoi

    extent = np.array([width, height])
    images = [points]
    for axis in (0, 1):
        for side in (0.0, extent[axis]):
            image = points.copy()
            image[:, axis] = 2 * side - image[:, axis]
            images.append(image)
    try:
        found = Voronoi(np.concatenate(images))
    except QhullError as error:
        raise GeometryError(
            f"extent = [{width:g}, {height:g}]: points in it have no Voronoi cells in double precision; allowed: a "
            "width and a height of ordinary size, and not far from each other"
        ) from error
    places = found.vertices
    for side in (np.zeros(2), extent):
        places = np.where(np.abs(places - side) < _ON_SIDE * extent.max(), side, places)
    return [places[found.regions[region]] for region in found.point_region[: len(points)]]


def relaxed(points: Array, width: float, height: float, steps: int) -> Array:
    """Return points after so many steps of Lloyd's: each goes to the centroid of its cell."""
    for _ in range(steps):
        points = np.array([_centroid(cell) for cell in voronoi_cells(points, width, height)])
    return points


def _centroid(polygon: Array) -> Array:
    start, end = polygon, np.roll(polygon, -1, axis=0)
    cross = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
    return np.asarray(((start + end) * cross[:, None]).sum(0) / (3 * cross.sum()))
