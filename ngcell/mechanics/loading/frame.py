"""A tissue in a frame that deforms."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Strict, model_validator
from pydantic_core import PydanticCustomError

from ngcell.geometry.bodies import FRAME
from ngcell.mechanics.loading.load import EndsOfPrisms, check_one_given
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene.section import PlanarVector, PositiveNumber

Array = NDArray[np.float64]
Gradient = tuple[tuple[float, float], tuple[float, float]]


class Frame(EndsOfPrisms):
    """A frame: all outer walls follow one affine deformation.

    Exactly one of `deformation_gradient`, `stretch` and `shear` is given.

    Parameters
    ----------
    deformation_gradient : tuple of tuple of float, shape (2, 2), optional
        Deformation gradient at load factor 1, without unit. It is reached along the straight line from
        the identity, on which its determinant stays positive.
    stretch : tuple of float, shape (2,), optional
        Stretches along x and y at load factor 1, each > 0.
    shear : float, optional
        Simple shear at load factor 1: displacement along x over height.

    Notes
    -----
    Further keys are those of `ngcell.mechanics.loading.load.EndsOfPrisms`.
    """

    supported: ClassVar[str | None] = "frame"
    moved: ClassVar[str] = FRAME

    kind: Literal["frame"] = "frame"
    deformation_gradient: Annotated[tuple[PlanarVector, PlanarVector], Strict(False)] | None = None
    stretch: Annotated[tuple[PositiveNumber, PositiveNumber], Strict(False)] | None = None
    shear: float | None = None

    @property
    def final_gradient(self) -> Gradient:
        """Deformation gradient at load factor 1, shape (2, 2), whichever way the load was given."""
        if self.deformation_gradient is not None:
            return self.deformation_gradient
        stretch_x, stretch_y = self.stretch or (1.0, 1.0)
        return (stretch_x, self.shear or 0.0), (0.0, stretch_y)

    @model_validator(mode="after")
    def _one_deformation(self) -> Self:
        check_one_given(deformation_gradient=self.deformation_gradient, stretch=self.stretch, shear=self.shear)
        return self

    @model_validator(mode="after")
    def _keeps_orientation(self) -> Self:
        smallest = _smallest_determinant(self.final_gradient)
        if smallest <= 0:
            raise PydanticCustomError(
                "limit",
                "turns the frame inside out, its determinant falls to {smallest} on the way; "
                "allowed: a determinant > 0 along the line from the identity to it",
                {"smallest": f"{smallest:.6g}", "place": ("deformation_gradient",)},
            )
        return self

    def motion(self, space: DisplacementSpace) -> PrescribedMotion:
        """Return the motion: all outer walls, and the lifting, follow the affine deformation in the plane."""
        dimension = space.dimension
        gradient = np.zeros((dimension, dimension))
        gradient[:2, :2] = np.array(self.final_gradient) - np.eye(2)
        walls = Support(FRAME, gradient, np.zeros(dimension), (True,) * dimension)
        return PrescribedMotion(space, [*self.held_ends(space), walls], lambda at: gradient @ at)

    def prescribed_displacement(self, space: DisplacementSpace) -> Array:
        """Return zero: a frame has no plate whose displacement could be told."""
        return np.zeros(space.dimension)


def _smallest_determinant(gradient: Gradient) -> float:
    """Return the smallest of ``det(I + s (F - I))`` over s in [0, 1], a parabola in s."""
    (xx, xy), (yx, yy) = gradient
    slope = (xx - 1) + (yy - 1)
    bend = (xx - 1) * (yy - 1) - xy * yx
    extremum = [s for s in [-slope / (2 * bend)] if 0 < s < 1] if bend > 0 else []
    return min(1 + slope * s + bend * s * s for s in (0.0, 1.0, *extremum))
