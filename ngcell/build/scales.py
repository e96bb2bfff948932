"""What sets the scales of a scene: not bodies that stay alone, far from all others, where nothing can come to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SolverScales:
    """Scales of steps and of the continuation.

    Attributes
    ----------
    thickness, length : float
        Smallest thickness of a body, and the length that sets the scale of one [length].
    softest, stiffest : float
        Shear moduli [stress].
    """

    thickness: float
    length: float
    softest: float
    stiffest: float


def scales_in_reach(
    space: DisplacementSpace,
    motion: PrescribedMotion,
    walls: Sequence[HyperelasticLaw],
    solids: Sequence[HyperelasticLaw],
) -> SolverScales:
    """Return the scales of the bodies that others may come to.

    A body that stays alone must change nothing of what the others do, and where equilibria are not unique the way
    there selects one of them.

    Parameters
    ----------
    walls, solids : sequence of HyperelasticLaw
        Laws of the walls of each body, and of all solids.
    """
    bodies = space.bodies
    low, high = _boxes(space)
    is_near = ~_stays_alone(space, motion, low, high)
    if is_near.all() or not is_near.any():
        moduli = [law.shear_modulus for law in walls], [law.shear_modulus for law in solids]
        return SolverScales(bodies.thickness, bodies.length, min(moduli[0]), max(moduli[1]))
    # Bodies that are apart at rest are drawn ones, each of one law; their length is half of a diagonal.
    near = [law.shear_modulus for law, counts in zip(walls, is_near, strict=True) if counts]
    length = float(np.linalg.norm((high - low)[is_near], axis=1).min()) / 2
    return SolverScales(float(bodies.thickness_of_body[is_near].min()), length, min(near), max(near))


def _boxes(space: DisplacementSpace) -> tuple[Array, Array]:
    """Return smallest and largest coordinates of each body at rest, shapes (bodies, dimension) [length]."""
    vertices = space.one == 1
    place, body = space.rest[:, vertices].T, space.body_of_unknown[vertices]
    low, below = np.full((2, space.body_count, space.dimension), np.inf)
    np.minimum.at(low, body, place)
    np.minimum.at(below, body, -place)
    return low, -below


def _stays_alone(space: DisplacementSpace, motion: PrescribedMotion, low: Array, high: Array) -> NDArray[np.bool_]:
    """Return which bodies are held, and farther from the others than all of these are large and supports move."""
    is_alone = np.zeros(space.body_count, dtype=bool)
    if space.body_count < 3:
        return is_alone
    way = float(np.abs(motion.imposed(np.zeros(space.unknowns), 1.0)).max(initial=0.0))
    for one in np.unique(space.body_of_unknown[motion.fixed.any(0)]):
        others = np.arange(space.body_count) != one
        start, end = low[others].min(0), high[others].max(0)
        apart = float(np.maximum(start - high[one], low[one] - end).max())
        is_alone[one] = apart > float(np.linalg.norm(end - start)) + way
    return is_alone
