"""The load of a case as prescribed motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.tissue import FRAME, LOWER_PLATE, UPPER_PLATE
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene import Frame, Plates

Array = NDArray[np.float64]


def prescribed_motion(space: DisplacementSpace, load: Plates | Frame) -> PrescribedMotion:
    """Return the motion that a load prescribes."""
    if isinstance(load, Frame):
        gradient = np.array(load.final_gradient) - np.eye(2)
        return PrescribedMotion(space, [Support(FRAME, gradient, np.zeros(2))], lambda at: gradient @ at)
    return _plates_motion(space, plate_travel(space, load))


def moved_region(load: Plates | Frame) -> str:
    """Return the region whose force and displacement are reported."""
    return FRAME if isinstance(load, Frame) else UPPER_PLATE


def plate_travel(space: DisplacementSpace, load: Plates | Frame) -> Array:
    """Return the displacement of the moved plate at load factor 1 [length], shape (2,); zero for a frame."""
    if isinstance(load, Frame):
        return np.zeros(2)
    if load.displacement is not None:
        return np.array(load.displacement)
    low, high = space.bodies.extent[:, 1]
    assert load.stretch is not None
    return np.array([0.0, (load.stretch - 1) * (high - low)])


def _plates_motion(space: DisplacementSpace, travel: Array) -> PrescribedMotion:
    """Plates move rigidly; in between, the carried field grows in proportion to the height."""
    height = space.rest[1]
    lower = height[_vertices(space, LOWER_PLATE)].max()
    upper = height[_vertices(space, UPPER_PLATE)].min()

    def carried(at: Array) -> Array:
        return travel[:, None] * np.clip((at[1] - lower) / (upper - lower), 0, 1)

    still = np.zeros((2, 2))
    supports = [Support(LOWER_PLATE, still, np.zeros(2)), Support(UPPER_PLATE, still, travel)]
    return PrescribedMotion(space, supports, carried)


def _vertices(space: DisplacementSpace, region: str) -> NDArray[np.int64]:
    unknowns = space.region_unknowns(region)
    return unknowns[space.one[unknowns] > 0]
