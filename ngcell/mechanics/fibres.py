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
cancels.

References
----------
Holzapfel, Gasser, Ogden, J. Elasticity 61 (2000), DOI 10.1023/A:1010835316564.
"""

from __future__ import annotations

from dataclasses import dataclass

import ngsolve
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FibreLaw:
    """Families of the same fibres.

    Attributes
    ----------
    stiffness : float
        k1 of each family [stress], > 0.
    exponent : float
        k2 [1], >= 0; 0 is the quadratic law.
    angles : tuple of float
        Angle of each family from the direction in the plane towards the axis [radian].
    """

    stiffness: float
    exponent: float
    angles: tuple[float, ...]

    def stored_energy(
        self, gradient: ngsolve.CoefficientFunction, direction: tuple[ngsolve.CoefficientFunction, ...]
    ) -> ngsolve.CoefficientFunction:
        """Return W [stress] of a deformation gradient in the plane, shape (2, 2), and a unit vector in it."""
        along = [gradient[row, 0] * direction[0] + gradient[row, 1] * direction[1] for row in range(2)]
        stretch = along[0] * along[0] + along[1] * along[1]
        total = ngsolve.CF(0.0)
        for angle in self.angles:
            strain = np.cos(angle) ** 2 * (stretch - 1)
            square = ngsolve.IfPos(strain, strain, 0.0) ** 2
            total += self._of_square(square)
        return total

    def cauchy_stress(self, gradient: Array, direction: Array) -> Array:
        """Return the Cauchy stress [stress], shape (n, 3, 3): ``2 dW/dI4 (F a) (F a) / J`` of each family.

        Deformation gradients have the shape (n, 3, 3), the directions in the plane (n, 2).
        """
        stress = np.zeros_like(gradient)
        for angle in self.angles:
            fibre = np.column_stack([np.cos(angle) * direction, np.full(len(direction), np.sin(angle))])
            moved = np.einsum("nij,nj->ni", gradient, fibre)
            strain = np.maximum((moved**2).sum(1) - 1, 0)
            pull = 2 * self.stiffness * strain * np.exp(self.exponent * strain**2)
            stress += pull[:, None, None] * moved[:, :, None] * moved[:, None, :]
        return stress / np.linalg.det(gradient)[:, None, None]

    def _of_square(self, square: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        if self.exponent == 0:
            return self.stiffness / 2 * square
        return self.stiffness / (2 * self.exponent) * (ngsolve.exp(self.exponent * square) - 1)
