"""A tissue between two plates."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from ngcell.errors import CaseError
from ngcell.geometry.bodies import LOWER_PLATE, UPPER_PLATE
from ngcell.mechanics.loading.constant_volume import BarrellingMotion
from ngcell.mechanics.loading.load import EndsOfPrisms, check_one_given, held_sides
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene.scope import refuse
from ngcell.scene.section import PlanarVector, PositiveNumber

Array = NDArray[np.float64]

#: Distance of plates that are not apart, as a share of the tissue's height: round-off.
_APART = 1e-9


class Plates(EndsOfPrisms):
    """Two plates: the outer walls that face down are held, those that face up are moved, the sides free or confined.

    Exactly one of `displacement` and `stretch` is given.

    Parameters
    ----------
    displacement : tuple of float, shape (2,), optional
        Displacement of the upper plate at load factor 1, a length.
    stretch : float, optional
        Distance of the plates at load factor 1 over the distance at rest, > 0.
    sides : {"free", "confined"}
        Whether the sides of the tissue are free, or between rigid walls without friction: outer walls along the left
        and the right edge then keep their place along x, and slide along y. They neither come off nor stick.

    Notes
    -----
    Further keys are those of `ngcell.mechanics.loading.load.EndsOfPrisms`.
    """

    moved: ClassVar[str] = UPPER_PLATE

    kind: Literal["plates"] = "plates"
    sides: Literal["free", "confined"] = "free"
    displacement: PlanarVector | None = None
    stretch: PositiveNumber | None = None

    @property
    def supported(self) -> str:
        """Which outer walls it holds or moves: those on the plates, where the tissue is confined those at its sides."""
        return "plates" if self.sides == "free" else self.sides

    @model_validator(mode="after")
    def _one_motion(self) -> Self:
        check_one_given(displacement=self.displacement, stretch=self.stretch)
        return self

    @model_validator(mode="after")
    def _along_the_sides(self) -> Self:
        if self.sides == "confined" and self.displacement is not None and self.displacement[0]:
            refuse("moves the plate through the side walls; allowed: 0 along x, or free sides", "displacement", 0)
        return self

    def motion(self, space: DisplacementSpace) -> PrescribedMotion:
        """Return the motion: plates move rigidly; in between, the lifting grows in proportion to the height.

        Raises
        ------
        CaseError
            If the plates meet at rest, or pass each other.
        """
        (lower, upper), moved = self._plates(space), self.prescribed_displacement(space)

        def lifting(at: Array) -> Array:
            return np.asarray(moved[:, None] * np.clip((at[1] - lower) / (upper - lower), 0, 1))

        return PrescribedMotion(space, self._supports(space), lifting)

    def motion_at_constant_volume(self, space: DisplacementSpace) -> PrescribedMotion:
        """Return the motion with a lifting that barrels or necks between the plates, and keeps the volume.

        Where plates keep their distance, or nothing is free to barrel, it is that of `motion`.
        """
        moved, (low, high) = self.prescribed_displacement(space), space.bodies.extent
        middle = (low + high) / 2
        centre = {0: middle[0]} if self.sides == "free" else {}
        if space.dimension == 3 and self.ends != "held":
            centre[2] = low[2] if self.ends == "mirrored" else middle[2]
        if not moved[1] or not centre:
            return self.motion(space)
        supports, plates = self._supports(space), self._plates(space)
        return BarrellingMotion(space, supports, plates=plates, moved=moved, centre=centre)

    def _plates(self, space: DisplacementSpace) -> tuple[float, float]:
        """Return the heights of the lower plate and of the upper one at rest [length]."""
        height = space.rest[1]
        lower = float(height[_vertices(space, LOWER_PLATE)].max())
        upper = float(height[_vertices(space, UPPER_PLATE)].min())
        _check_apart(upper - lower, float(np.ptp(height)))
        _check_sides(self.prescribed_displacement(space)[1], upper - lower)
        return lower, upper

    def _supports(self, space: DisplacementSpace) -> list[Support]:
        dimension = space.dimension
        whole, still = (True,) * dimension, np.zeros((dimension, dimension))
        below = Support(LOWER_PLATE, still, np.zeros(dimension), whole)
        above = Support(UPPER_PLATE, still, self.prescribed_displacement(space), whole)
        return [*self.held_ends(space), *held_sides(space, self.sides), below, above]

    def prescribed_displacement(self, space: DisplacementSpace) -> Array:
        """Return the displacement of the upper plate at load factor 1 [length]."""
        moved = np.zeros(space.dimension)
        if self.displacement is not None:
            moved[:2] = self.displacement
        elif self.stretch is not None:
            moved[1] = (self.stretch - 1) * np.ptp(space.bodies.extent[:, 1])
        return moved


def _check_apart(distance: float, extent: float) -> None:
    """Refuse plates that meet at rest: a corner that both hold would have to go both ways."""
    if distance <= _APART * extent:
        raise CaseError(
            f"load: the plates are not apart at rest, the upper one begins {distance:.3g} above the highest point of "
            "the lower one; allowed: tissues whose plates are apart, as those of more rows"
        )


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
