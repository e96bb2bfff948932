"""Which outer walls a load holds or moves, told by where they are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import GeometryError
from ngcell.geometry.bodies import FRAME, LEFT_SIDE, LOWER_PLATE, RIGHT_SIDE, UPPER_PLATE
from ngcell.geometry.outlines import Outlines


def held_walls(outlines: Outlines, supported: str | None, within: float) -> dict[str, NDArray[np.bool_]]:
    """Return which sides each supported region consists of, as arrays of shape (corners,).

    Parameters
    ----------
    outlines : Outlines
        The cells.
    supported : {"plates", "confined", "frame", None}
        Plates hold the walls of the hull that lie whole within a distance of the tissue's lower or upper edge; where
        the tissue is confined, side walls those along its left and right edge, too. A frame holds all walls of the
        hull. Walls around pores are never held.
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
    plates = _along(outlines, 1, within, {LOWER_PLATE: "lower", UPPER_PLATE: "upper"})
    return plates if supported == "plates" else {**plates, **confined_walls(outlines, plates, within)}


def confined_walls(
    outlines: Outlines, plates: Mapping[str, NDArray[np.bool_]], within: float
) -> dict[str, NDArray[np.bool_]]:
    """Return which sides lie along rigid side walls, as arrays of shape (corners,): those of the hull that lie whole
    within a distance [length] of the tissue's left or right edge, but for those that plates hold."""
    on_plates = np.any([np.ravel(held) for held in plates.values()], axis=0)
    sides = _along(outlines, 0, within, {LEFT_SIDE: "left", RIGHT_SIDE: "right"})
    return {name: held & ~on_plates for name, held in sides.items()}


def _along(outlines: Outlines, axis: int, within: float, names: Mapping[str, str]) -> dict[str, NDArray[np.bool_]]:
    """Return which sides of the hull lie along the lower and along the upper edge across an axis; `names` are those of
    the two regions, and of their edges."""
    place = outlines.corners[:, axis]
    both = np.stack([place, place[outlines.ahead]])
    away = dict(zip(names, (both.max(0) - place.min(), place.max() - both.min(0)), strict=True))
    for name, distance in away.items():
        nearest = distance[outlines.on_hull].min()
        if nearest > within:
            raise GeometryError(
                f"no outer wall lies whole within {within:.4g} of the tissue's {names[name]} edge, for the {name} to "
                f"hold; allowed: tissue.held_within >= {nearest:.4g}"
            )
    return {name: outlines.on_hull & (distance <= within) for name, distance in away.items()}
