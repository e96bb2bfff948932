"""The Mooney-Rivlin solid: its symbolic stored energy, and its stress in closed form.

With the isochoric split and a factor 1/2 in front of both constants:

    W = c1/2 (I1* - 3) + c2/2 (I2* - 3) + kappa/2 (ln J)^2,   I1* = J^(-2/3) I1,  I2* = J^(-4/3) I2.

The shear modulus at rest is ``c1 + c2``, the bulk modulus kappa. FEBio's "Mooney-Rivlin" writes c1 (I1* - 3) and
c2 (I2* - 3): its constants are half of ours, its k equals kappa (uncoupled, U = k/2 (ln J)^2).

The energy is written with scalar entries on purpose: NGSolve's compiled integrator is four times faster than on
matrix expressions.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import ngsolve
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ngcell.mechanics.laws.law import FibreLaw, plane_strain_modulus
from ngcell.scene.choice import OneOf
from ngcell.scene.scope import is_planar, refuse
from ngcell.scene.section import NonNegativeNumber, PositiveNumber, Section

Array = NDArray[np.float64]


class MooneyRivlin(Section):
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
        Fibres in it, which add to the stored energy given here; by default there are none.
    strength : float, optional
        Largest principal Cauchy stress that a planar wall bears on average, a stress, > 0. The load at which it would
        rupture is told; the wall is not changed.
    stretch_limit : float, optional
        Largest principal stretch that it bears on average, > 1.
    rupture_length : float, optional
        Length of these averages [length], > 0; by default the thickness of the wall.
    """

    kind: Literal["mooney-rivlin"] = "mooney-rivlin"
    c1: PositiveNumber
    c2: NonNegativeNumber
    bulk_modulus: PositiveNumber
    fibres: Annotated[FibreLaw, OneOf("fibres")] | None = None
    strength: PositiveNumber | None = None
    stretch_limit: Annotated[float, Field(gt=1)] | None = None
    rupture_length: PositiveNumber | None = None

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse a direction of the fibres in a tissue, whose walls have directions of their own."""
        if "tissue" in scene and self.fibres is not None and self.fibres.direction is not None:
            what = "is that of the wall in a tissue; allowed: no direction, or angles from the wall's"
            refuse(what, "fibres", "direction")
        if "tissue" in scene and not is_planar(scene) and self.ruptures:
            key = "strength" if self.strength is not None else "stretch_limit"
            refuse("is that of planar walls; allowed: only without tissue.height", key)

    @model_validator(mode="after")
    def _length_of_an_average(self) -> Self:
        if self.rupture_length is not None and not self.ruptures:
            refuse("averages nothing; allowed: beside strength or stretch_limit", "rupture_length")
        return self

    @property
    def ruptures(self) -> bool:
        """Whether it is said what walls bear."""
        return self.strength is not None or self.stretch_limit is not None

    @property
    def shear_modulus(self) -> float:
        """Shear modulus at rest [stress]."""
        return self.c1 + self.c2

    @property
    def plane_strain_modulus(self) -> float:
        """Modulus E / (1 - nu^2) of a plane-strain half-space at rest [stress]."""
        return plane_strain_modulus(self.shear_modulus, self.bulk_modulus)

    def softened(self, ratio: float) -> Self:
        """Return the law with a bulk modulus of at most `ratio` times the shear modulus."""
        return self.model_copy(update={"bulk_modulus": min(self.bulk_modulus, ratio * self.shear_modulus)})

    def stored_energy(self, gradient: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        """Return W [stress] of a deformation gradient, shape (3, 3), or (2, 2) for plane strain."""
        isochoric, volumetric = self.energy_parts(gradient)
        return isochoric + volumetric

    def energy_parts(
        self, gradient: ngsolve.CoefficientFunction
    ) -> tuple[ngsolve.CoefficientFunction, ngsolve.CoefficientFunction]:
        """Return the isochoric and the volumetric part of W [stress]."""
        first, second, jacobian = _plane_strain(gradient) if gradient.shape == (2, 2) else _invariants(gradient)
        log_jacobian = ngsolve.log(jacobian)
        scale = ngsolve.exp(-2 / 3 * log_jacobian)
        first = scale * first
        second = scale * scale * second
        volumetric = self.bulk_modulus / 2 * log_jacobian * log_jacobian
        return self.c1 / 2 * (first - 3) + self.c2 / 2 * (second - 3), volumetric

    def cauchy_stress(self, gradient: Array) -> Array:
        """Return the Cauchy stress [stress], shape (n, 3, 3), of deformation gradients of shape (n, 3, 3).

        ``sigma = dev(c1 b* + c2 (I1* b* - b* b*)) / J + kappa ln(J) / J`` with ``b* = J^(-2/3) F F^T``.
        """
        jacobian = np.linalg.det(gradient)[:, None, None]
        left = gradient @ gradient.transpose(0, 2, 1) / np.cbrt(jacobian) ** 2
        trace = np.trace(left, axis1=1, axis2=2)[:, None, None]
        stretch = self.c1 * left + self.c2 * (trace * left - left @ left)
        mean = np.trace(stretch, axis1=1, axis2=2)[:, None, None] / 3
        return np.asarray((stretch + (self.bulk_modulus * np.log(jacobian) - mean) * np.eye(3)) / jacobian)


def _plane_strain(gradient: ngsolve.CoefficientFunction) -> tuple[ngsolve.CoefficientFunction, ...]:
    """Return I1, I2 and J without stretch out of the plane."""
    xx, xy, yx, yy = (gradient[i, j] for i in range(2) for j in range(2))
    square = xx * xx + xy * xy + yx * yx + yy * yy
    jacobian = xx * yy - xy * yx
    return square + 1, square + jacobian * jacobian, jacobian


def _invariants(gradient: ngsolve.CoefficientFunction) -> tuple[ngsolve.CoefficientFunction, ...]:
    """Return I1, I2 and J: the squares of F and of its cofactors, and its determinant."""
    entry = [[gradient[i, j] for j in range(3)] for i in range(3)]
    cofactor = [
        [
            entry[(i + 1) % 3][(j + 1) % 3] * entry[(i + 2) % 3][(j + 2) % 3]
            - entry[(i + 1) % 3][(j + 2) % 3] * entry[(i + 2) % 3][(j + 1) % 3]
            for j in range(3)
        ]
        for i in range(3)
    ]
    first, second = (sum(number * number for row in matrix for number in row) for matrix in (entry, cofactor))
    jacobian = entry[0][0] * cofactor[0][0] + entry[0][1] * cofactor[0][1] + entry[0][2] * cofactor[0][2]
    return first, second, jacobian
