"""Which outer walls a load holds or moves, told by where they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.bodies import FRAME, LOWER_PLATE, UPPER_PLATE
from ngcell.geometry.outlines import Outlines


def held_walls(outlines: Outlines, supported: str | None, within: float) -> dict[str, NDArray[np.bool_]]:
    """Return which sides each supported region consists of, as arrays of shape (corners,).

    Parameters
    ----------
    outlines : Outlines
        The cells.
    supported : {"plates", "frame", None}
        Plates hold the walls of the hull that lie whole within a distance of the tissue's lower or upper edge, a frame
        all walls of the hull. Walls around pores are never held.
    within : float
        That distance [length], >= 0.

    Raises
    ------
    GeometryError
        If no wall lies within that distance of an edge.
    """
    if supported is None:
        return {}
    if supported == "frame":
        return {FRAME: outlines.on_hull}
    height = outlines.corners[:, 1]
    both = np.stack([height, height[outlines.ahead]])
    away = {LOWER_PLATE: both.max(0) - height.min(), UPPER_PLATE: height.max() - both.min(0)}
    for (name, distance), edge in zip(away.items(), ("lower", "upper"), strict=True):
        nearest = distance[outlines.on_hull].min()
        if nearest > within:
            raise GeometryError(
                f"no outer wall lies whole within {within:.4g} of the tissue's {edge} edge, for the {name} to hold; "
                f"allowed: tissue.held_within >= {nearest:.4g}"
            )
    return {name: outlines.on_hull & (distance <= within) for name, distance in away.items()}
