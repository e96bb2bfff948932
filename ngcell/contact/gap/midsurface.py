"""The vector between two points that stay together for good, measured by the wall midway between theirs.

Bonds join material points of two walls, and favour neither: the tangents of the wall between both are the means of the
two walls', along the coordinates of the secondary one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.gap.by_surface import gap_of
from ngcell.contact.gap.kinematics import GapKinematics
from ngcell.contact.pairing.pairs import ContactPairs
from ngcell.contact.surface.surface import Surface

Array = NDArray[np.float64]


def midsurface_kinematics(walls: Surface, pairs: ContactPairs) -> GapKinematics:
    """Return the maps to ``a`` and to the tangents of the wall between both points, which counts as flat."""
    primary, secondary = (
        walls.trace(pairs.primary, pairs.primary_xi),
        walls.trace(pairs.secondary, pairs.secondary_xi),
    )
    rates, tangents = _rates(walls, pairs), []
    for number, by in enumerate(walls.directions):
        along_secondary = walls.trace(pairs.secondary, pairs.secondary_xi, by)
        along_primary = np.zeros_like(primary)
        for own, own_by in enumerate(walls.directions):
            along_primary += rates[:, own, number, None] * walls.trace(pairs.primary, pairs.primary_xi, own_by)
        tangents.append(np.concatenate([along_primary, along_secondary], axis=1) / 2)
    gap = gap_of(walls)
    return GapKinematics(
        pairs=pairs,
        gap=gap,
        dofs=np.concatenate([walls.dofs[pairs.primary], walls.dofs[pairs.secondary]], axis=1),
        maps=(np.concatenate([primary, -secondary], axis=1), *tangents),
        side=walls.side[pairs.secondary],
        correction=gap.flat(len(pairs)),
    )


def _rates(walls: Surface, pairs: ContactPairs) -> Array:
    """Return the rates of the primary wall's coordinates by those of the secondary one, where both lie in one plane.

    Walls of two bodies run in directions and at speeds of their own. Shape (pairs, directions, directions).
    """
    mine = np.stack(walls.tangents(pairs.primary, pairs.primary_xi, walls.rest), axis=1)
    theirs = np.stack(walls.tangents(pairs.secondary, pairs.secondary_xi, walls.rest), axis=1)
    metric, mixed = mine @ mine.transpose(0, 2, 1), mine @ theirs.transpose(0, 2, 1)
    return np.asarray(mixed / metric if mine.shape[1] == 1 else np.linalg.solve(metric, mixed))
