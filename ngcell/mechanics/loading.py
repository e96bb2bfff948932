"""The load of a case as prescribed motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.bodies import LOWER_END, UPPER_END
from ngcell.geometry.tissue import ENDS, FRAME, LOWER_PLATE, UPPER_PLATE
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene import Ends, Frame, Load, Traction

Array = NDArray[np.float64]


def prescribed_motion(space: DisplacementSpace, load: Load) -> PrescribedMotion:
    """Return the motion that a load prescribes; what moves prisms moves them in the plane."""
    if isinstance(load, Ends):
        from ngcell.mechanics.ends import EndsMotion

        return EndsMotion(space, load)
    dimension = space.dimension
    whole, still = (True,) * dimension, np.zeros((dimension, dimension))
    ends = []
    if dimension == 3 and load.ends == "held":
        ends = [Support(ENDS, still, np.zeros(3), (False, False, True))]
    if isinstance(load, Frame):
        gradient = still.copy()
        gradient[:2, :2] = np.array(load.final_gradient) - np.eye(2)
        supports = [*ends, Support(FRAME, gradient, np.zeros(dimension), whole)]
        return PrescribedMotion(space, supports, lambda at: gradient @ at)
    return _plates_motion(space, prescribed_plate_displacement(space, load), ends)


def end_loads(load: Load) -> tuple[Traction, ...]:
    """Return the forces on the ends of pressed prisms, none for others.

    They keep their direction: a pressure that followed ends with free rims would have no potential.
    """
    if isinstance(load, Ends) or load.end_pressure is None:
        return ()
    return Traction(UPPER_END, (0.0, 0.0, -load.end_pressure)), Traction(LOWER_END, (0.0, 0.0, load.end_pressure))


def moved_region(load: Load) -> str:
    """Return the region whose force and displacement are reported."""
    if isinstance(load, Ends):
        return UPPER_END
    return FRAME if isinstance(load, Frame) else UPPER_PLATE


def prescribed_plate_displacement(space: DisplacementSpace, load: Load) -> Array:
    """Return the displacement of the moved plate at load factor 1 [length], shape (dimension,); zero for a frame."""
    prescribed_displacement = np.zeros(space.dimension)
    if isinstance(load, Frame):
        return prescribed_displacement
    if isinstance(load, Ends):
        return np.array(load.displacement)
    if load.displacement is not None:
        prescribed_displacement[:2] = load.displacement
        return prescribed_displacement
    low, high = space.bodies.extent[:, 1]
    assert load.stretch is not None
    prescribed_displacement[1] = (load.stretch - 1) * (high - low)
    return prescribed_displacement


def _plates_motion(space: DisplacementSpace, prescribed_displacement: Array, ends: list[Support]) -> PrescribedMotion:
    """Plates move rigidly; in between, the lifting grows in proportion to the height."""
    height = space.rest[1]
    lower = height[_vertices(space, LOWER_PLATE)].max()
    upper = height[_vertices(space, UPPER_PLATE)].min()

    def lifting(at: Array) -> Array:
        return np.asarray(prescribed_displacement[:, None] * np.clip((at[1] - lower) / (upper - lower), 0, 1))

    dimension = space.dimension
    whole, still = (True,) * dimension, np.zeros((dimension, dimension))
    plates = [
        Support(LOWER_PLATE, still, np.zeros(dimension), whole),
        Support(UPPER_PLATE, still, prescribed_displacement, whole),
    ]
    return PrescribedMotion(space, [*ends, *plates], lifting)


def _vertices(space: DisplacementSpace, region: str) -> NDArray[np.int64]:
    unknowns = space.region_unknowns(region)
    return unknowns[space.one[unknowns] > 0]
