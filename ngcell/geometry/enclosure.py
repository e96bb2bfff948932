"""Which points lie inside closed triangulated surfaces, by the solid angle under which they see them.

References
----------
Van Oosterom, Strackee, IEEE Trans. Biomed. Eng. 30 (1983), DOI 10.1109/TBME.1983.325207.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Most triangles times points at once.
_CHUNK = 2_000_000


def winding_numbers(points: Array, triangles: Array) -> Array:
    """Return how often a closed surface winds around each point, shape (points,): 1 inside, 0 outside.

    Parameters
    ----------
    points : array of float, shape (points, 3)
        The points [length].
    triangles : array of float, shape (triangles, 3, 3)
        Corners of the surface's triangles, all with the same side out [length].
    """
    count = max(1, _CHUNK // max(len(triangles), 1))
    parts = [_solid_angles(points[start : start + count], triangles) for start in range(0, len(points), count)]
    return np.concatenate(parts) / (4 * np.pi) if parts else np.zeros(0)


def _solid_angles(points: Array, triangles: Array) -> Array:
    """Return the sum of the triangles' signed solid angles."""
    one, two, three = (triangles[None, :, corner] - points[:, None] for corner in range(3))
    size_one, size_two, size_three = (np.linalg.norm(arm, axis=2) for arm in (one, two, three))
    volume = np.einsum("ptd,ptd->pt", one, np.cross(two, three))
    against = size_one * size_two * size_three
    against += np.einsum("ptd,ptd->pt", one, two) * size_three
    against += np.einsum("ptd,ptd->pt", two, three) * size_one
    against += np.einsum("ptd,ptd->pt", three, one) * size_two
    return np.asarray(2 * np.arctan2(volume, against).sum(1))
