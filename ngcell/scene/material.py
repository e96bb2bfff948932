"""What the walls are made of. A further law is one more class here and one more name in `Material`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field, Strict, field_validator
from pydantic_core import PydanticCustomError

from ngcell.scene.section import SECTION, ByKind, NonNegativeNumber, PlanarVector, PositiveNumber

Angle = Annotated[float, Field(ge=-90, le=90)]
Angles = Annotated[tuple[Angle, ...], Strict(False)]


class _Fibres(BaseModel):
    """What every law of fibres says.

    Parameters
    ----------
    stiffness : float
        k1 of each family, a stress, > 0.
    angles : tuple of float
        Angles of one or two families [degree], from the wall's direction in the plane towards the axis of the cell,
        from -90 to 90: 0 runs around the cell, 90 along its axis. In end walls of prisms, from the direction around the
        axis towards it at the upper end, and away from it at the lower end.
    direction : tuple of float, shape (2,), optional
        In place of the wall's direction in user-defined bodies, which need it: a vector in the plane, not zero.
    """

    model_config = SECTION

    stiffness: PositiveNumber
    angles: Angles
    direction: PlanarVector | None = None

    @field_validator("angles")
    @classmethod
    def _one_or_two(cls, angles: tuple[float, ...]) -> tuple[float, ...]:
        if not 1 <= len(angles) <= 2:
            raise PydanticCustomError("limit", "allowed: one angle, or two for two families")
        return angles

    @field_validator("direction")
    @classmethod
    def _points_somewhere(cls, direction: tuple[float, float] | None) -> tuple[float, float] | None:
        if direction == (0.0, 0.0):
            raise PydanticCustomError("limit", "points nowhere; allowed: a vector that is not zero")
        return direction


class ExponentialFibres(_Fibres):
    """Fibres after Holzapfel, Gasser and Ogden: ``k1/(2 k2) (exp(k2 (I4 - 1)**2) - 1)`` in tension.

    Parameters
    ----------
    exponent : float
        k2, without unit, > 0.
    """

    kind: Literal["exponential"] = "exponential"
    exponent: PositiveNumber


class QuadraticFibres(_Fibres):
    """The standard reinforcing law: ``k1/2 (I4 - 1)**2`` in tension."""

    kind: Literal["quadratic"] = "quadratic"


Fibres = Annotated[ExponentialFibres | QuadraticFibres, ByKind()]


class MooneyRivlin(BaseModel):
    """Mooney-Rivlin solid, ``W = c1/2 (I1 - 3) + c2/2 (I2 - 3)`` of the isochoric part, made compressible.

    Parameters
    ----------
    c1 : float
        First constant, a stress, > 0. The shear modulus at rest is ``c1 + c2``.
    c2 : float
        Second constant, a stress, >= 0; 0 is the neo-Hookean solid.
    bulk_modulus : float
        Modulus of the volumetric energy ``bulk_modulus/2 (ln J)**2``, a stress, > 0.
    fibres : ExponentialFibres or QuadraticFibres, optional
        Fibres in it; by default there are none.
    """

    model_config = SECTION

    kind: Literal["mooney-rivlin"] = "mooney-rivlin"
    c1: PositiveNumber
    c2: NonNegativeNumber
    bulk_modulus: PositiveNumber
    fibres: Fibres | None = None


Material = Annotated[MooneyRivlin, ByKind()]
