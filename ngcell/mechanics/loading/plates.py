"""A tissue between two plates."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, model_validator

from ngcell.errors import CaseError
from ngcell.geometry.bodies import LOWER_PLATE, UPPER_PLATE
from ngcell.mechanics.loading.load import (
    check_ends,
    check_one_given,
    check_scope_of_ends,
    end_tractions,
    held_ends,
)
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene.bodies import Traction
from ngcell.scene.levels import Levels, level_factors
from ngcell.scene.section import SECTION, PlanarVector, PositiveNumber

Array = NDArray[np.float64]


class Plates(BaseModel):
    """Two plates: the outer walls that face down are held, those that face up are moved, the sides are free.

    Exactly one of `displacement` and `stretch` is given.

    Parameters
    ----------
    displacement : tuple of float, shape (2,), optional
        Displacement of the upper plate at load factor 1, a length.
    stretch : float, optional
        Distance of the plates at load factor 1 over the distance at rest, > 0.
    ends : {"free", "held", "pressed"}, optional
        Whether the ends of prisms are free, as by default, held along z, as in plane strain, or under a pressure.
    end_pressure : float, optional
        Force on both ends of pressed prisms per reference area, a stress, inwards along z whichever way the ends
        turn; it grows with the load. Below 0 it pulls.
    levels : int or tuple of float
        Number of equal levels, or the load factors in [0, 1] that are reported, in the order of the load path;
        it may return, as in ``[0.5, 1.0, 0.5, 0.0]``.
    """

    model_config = SECTION

    supported: ClassVar[str | None] = "plates"
    moved: ClassVar[str] = UPPER_PLATE

    kind: Literal["plates"] = "plates"
    displacement: PlanarVector | None = None
    stretch: PositiveNumber | None = None
    ends: Literal["free", "held", "pressed"] | None = None
    end_pressure: float | None = None
    levels: Levels = 10

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1], in the order of the load path."""
        return level_factors(self.levels)

    @model_validator(mode="after")
    def _one_motion(self) -> Self:
        check_one_given(displacement=self.displacement, stretch=self.stretch)
        return self

    @model_validator(mode="after")
    def _ends_under_a_pressure(self) -> Self:
        check_ends(self.ends, self.end_pressure)
        return self

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse keys of prisms in a planar tissue, and a pressure on ends beside what comes before the load."""
        check_scope_of_ends(self, scene)

    def motion(self, space: DisplacementSpace) -> PrescribedMotion:
        """Return the motion: plates move rigidly; in between, the lifting grows in proportion to the height.

        Raises
        ------
        CaseError
            If the plates pass each other.
        """
        height, moved = space.rest[1], self.prescribed_displacement(space)
        lower = height[_vertices(space, LOWER_PLATE)].max()
        upper = height[_vertices(space, UPPER_PLATE)].min()
        _check_sides(moved[1], upper - lower)

        def lifting(at: Array) -> Array:
            return np.asarray(moved[:, None] * np.clip((at[1] - lower) / (upper - lower), 0, 1))

        dimension = space.dimension
        whole, still = (True,) * dimension, np.zeros((dimension, dimension))
        plates = [Support(LOWER_PLATE, still, np.zeros(dimension), whole), Support(UPPER_PLATE, still, moved, whole)]
        return PrescribedMotion(space, [*held_ends(space, self.ends), *plates], lifting)

    def prescribed_displacement(self, space: DisplacementSpace) -> Array:
        """Return the displacement of the upper plate at load factor 1 [length]."""
        moved = np.zeros(space.dimension)
        if self.displacement is not None:
            moved[:2] = self.displacement
        elif self.stretch is not None:
            moved[1] = (self.stretch - 1) * np.ptp(space.bodies.extent[:, 1])
        return moved

    def tractions(self) -> tuple[Traction, ...]:
        """Return the forces on pressed ends."""
        return end_tractions(self.end_pressure)


def _check_sides(rise: float, distance: float) -> None:
    """Refuse plates that pass each other: what lies between them would be turned inside out.

    Between the lowest point of the upper plate and the highest of the lower one, the lifting has the determinant ``1 +
    rise / distance`` at load factor 1, and a larger one on the way if the plates approach.
    """
    if distance + rise <= 0:
        raise CaseError(
            f"load: the upper plate moves by {rise:.6g} along y and passes the lower one, {distance:.6g} below it; "
            f"allowed: a displacement along y above {-distance:.6g}"
        )


def _vertices(space: DisplacementSpace, region: str) -> NDArray[np.int64]:
    unknowns = space.region_unknowns(region)
    return unknowns[space.one[unknowns] > 0]
