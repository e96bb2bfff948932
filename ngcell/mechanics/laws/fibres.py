"""Families of fibres that stiffen a wall: they bear tension only.

A fibre of angle a runs in the surface of a prismatic wall: ``cos(a)`` along the wall's direction d in the plane and
``sin(a)`` along the axis, as microfibrils that wind around a cell. With the stretch ``|F d|`` of the wall, and none
along the axis in plane strain,

    I4 = cos(a)^2 |F d|^2 + sin(a)^2,     E = max(0, I4 - 1),

    W = k1 / (2 k2) (exp(k2 E^2) - 1)     exponential, Holzapfel, Gasser and Ogden (2000)
    W = k1 / 2 E^2                        quadratic, the standard reinforcing law and the limit k2 = 0

for each family. I4 is that of the whole deformation, not of its isochoric part, which would let a fibre shorten where
the material swells. The energy is once continuously differentiable where a fibre goes slack.

A single oblique family also shears the wall along its axis; in plane strain that is held, and in a balanced pair it
cancels. In prisms the axis is e_z, and nothing else changes: ``I4 = |F (cos(a) d + sin(a) e_z)|^2``.

End walls of prisms have fibres in their plane: angles are measured from the direction around the axis of the cell, at
the upper end towards the axis and at the lower end away from it, so that a helix around the cell goes on as a spiral.

References
----------
Holzapfel, Gasser, Ogden, J. Elasticity 61 (2000), DOI 10.1023/A:1010835316564.
"""

from __future__ import annotations

from typing import Annotated, Literal

import ngsolve
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict, field_validator
from pydantic_core import PydanticCustomError

from ngcell.scene.section import PlanarVector, PositiveNumber, Section

Array = NDArray[np.float64]
Angle = Annotated[float, Field(ge=-90, le=90)]
Angles = Annotated[tuple[Angle, ...], Strict(False)]


class _Fibres(Section):
    """Families of the same fibres: what every law of fibres shares.

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

    @property
    def radians(self) -> tuple[float, ...]:
        """Angle of each family [radian]."""
        return tuple(np.radians(self.angles).tolist())

    @property
    def exponent_or_zero(self) -> float:
        """k2 [1], >= 0; 0 is the quadratic law."""
        raise NotImplementedError

    def energy_of_square(self, square: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        """Return W [stress] of one family from the square of its strain E."""
        raise NotImplementedError

    def stored_energy(
        self, gradient: ngsolve.CoefficientFunction, direction: tuple[ngsolve.CoefficientFunction, ...]
    ) -> ngsolve.CoefficientFunction:
        """Return W [stress] of a deformation gradient and the directions that angles are measured in.

        In the plane these are a gradient of shape (2, 2) and the two components of the unit vector d; in three
        dimensions one of shape (3, 3) and the six components of d and of the unit vector across it that stands for the
        axis.
        """
        dimension = gradient.dims[0]
        along, *upward = (
            _moved(gradient, direction[at : at + dimension]) for at in range(0, len(direction), dimension)
        )
        total = ngsolve.CF(0.0)
        for angle in self.radians:
            cos, sin = np.cos(angle), np.sin(angle)
            strain = cos**2 * (_square(along) - 1)
            if upward:
                moved = [cos * one + sin * two for one, two in zip(along, upward[0], strict=True)]
                strain = _square(moved) - 1
            square = ngsolve.IfPos(strain, strain, 0.0) ** 2
            total += self.energy_of_square(square)
        return total

    def cauchy_stress(self, gradient: Array, direction: Array) -> Array:
        """Return the Cauchy stress [stress], shape (n, 3, 3): ``2 dW/dI4 (F a) (F a) / J`` of each family.

        Deformation gradients have the shape (n, 3, 3), directions in the plane (n, 2), in three dimensions (n, 6).
        """
        stress = np.zeros_like(gradient)
        along, upward = np.zeros((len(direction), 3)), np.tile([0.0, 0.0, 1.0], (len(direction), 1))
        for part, values in zip((along, upward), np.split(direction, range(3, direction.shape[1], 3), 1), strict=False):
            part[:, : values.shape[1]] = values
        for angle in self.radians:
            fibre = np.cos(angle) * along + np.sin(angle) * upward
            moved = np.einsum("nij,nj->ni", gradient, fibre)
            strain = np.maximum((moved**2).sum(1) - 1, 0)
            pull = 2 * self.stiffness * strain * np.exp(self.exponent_or_zero * strain**2)
            stress += pull[:, None, None] * moved[:, :, None] * moved[:, None, :]
        return np.asarray(stress / np.linalg.det(gradient)[:, None, None])


class ExponentialFibres(_Fibres):
    """Fibres after Holzapfel, Gasser and Ogden: ``k1/(2 k2) (exp(k2 (I4 - 1)**2) - 1)`` in tension.

    Parameters
    ----------
    stiffness : float
        k1 of each family, a stress, > 0.
    angles : tuple of float
        Angles of one or two families [degree], from the wall's direction towards the axis of the cell, from -90 to 90.
    direction : tuple of float, shape (2,), optional
        In place of the wall's direction in user-defined bodies, which need it: a vector in the plane, not zero.
    exponent : float
        k2, without unit, > 0.
    """

    kind: Literal["exponential"] = "exponential"
    exponent: PositiveNumber

    @property
    def exponent_or_zero(self) -> float:
        """k2 [1]."""
        return self.exponent

    def energy_of_square(self, square: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        """Return W [stress] of one family from the square of its strain E."""
        return self.stiffness / (2 * self.exponent) * (ngsolve.exp(self.exponent * square) - 1)


class QuadraticFibres(_Fibres):
    """The standard reinforcing law: ``k1/2 (I4 - 1)**2`` in tension.

    Parameters
    ----------
    stiffness, angles, direction
        As for `ExponentialFibres`.
    """

    kind: Literal["quadratic"] = "quadratic"

    @property
    def exponent_or_zero(self) -> float:
        """k2 [1]."""
        return 0.0

    def energy_of_square(self, square: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        """Return W [stress] of one family from the square of its strain E."""
        return self.stiffness / 2 * square


def _moved(
    gradient: ngsolve.CoefficientFunction, vector: tuple[ngsolve.CoefficientFunction, ...]
) -> list[ngsolve.CoefficientFunction]:
    """Return the components of ``gradient @ vector``."""
    count = len(vector)
    products = [[gradient[row, column] * vector[column] for column in range(count)] for row in range(count)]
    return [sum(row[1:], start=row[0]) for row in products]


def _square(vector: list[ngsolve.CoefficientFunction]) -> ngsolve.CoefficientFunction:
    first, *others = (component * component for component in vector)
    return sum(others, start=first)
