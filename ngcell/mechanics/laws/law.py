"""What a law of a solid offers, whichever it is: its stored energy, its stress, and its stiffness at rest.

A law of the package is one file beside this one and one line in `ngcell.scene.registry`. A script may hand over
`ngcell.mechanics.laws.custom.CustomLaw`, or any object with these members.
"""

from __future__ import annotations

from typing import Protocol, Self, runtime_checkable

import ngsolve
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@runtime_checkable
class FibreLaw(Protocol):
    """Families of fibres, whose energy adds to that of the solid around them."""

    @property
    def direction(self) -> tuple[float, float] | None:
        """Vector in the plane that angles are measured from in user-defined bodies; a tissue takes the wall's."""

    def stored_energy(
        self, gradient: ngsolve.CoefficientFunction, direction: tuple[ngsolve.CoefficientFunction, ...]
    ) -> ngsolve.CoefficientFunction:
        """Return W [stress] of a deformation gradient and the directions that angles are measured in."""

    def cauchy_stress(self, gradient: Array, direction: Array) -> Array:
        """Return the Cauchy stress [stress], shape (n, 3, 3), of deformation gradients of that shape."""


@runtime_checkable
class HyperelasticLaw(Protocol):
    """A hyperelastic solid.

    It is hashable, and laws that are equal share one symbolic energy. That depends on the deformation alone: energies
    at the last displacement are remembered, and a parameter that a script changes during a run would not be seen.
    """

    @property
    def shear_modulus(self) -> float:
        """Shear modulus at rest [stress], > 0."""

    @property
    def bulk_modulus(self) -> float:
        """Bulk modulus at rest [stress], > 0."""

    @property
    def plane_strain_modulus(self) -> float:
        """Modulus E / (1 - nu^2) of a plane-strain half-space at rest [stress]: the scale of contact penalties."""

    @property
    def fibres(self) -> FibreLaw | None:
        """Fibres, which add to the stored energy given here; None where there are none."""

    def softened(self, ratio: float) -> Self:
        """Return the law with a bulk modulus of at most `ratio` times the shear modulus, or itself."""

    def stored_energy(self, gradient: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        """Return W [stress] of a deformation gradient, shape (3, 3), or (2, 2) for plane strain."""

    def energy_parts(
        self, gradient: ngsolve.CoefficientFunction
    ) -> tuple[ngsolve.CoefficientFunction, ngsolve.CoefficientFunction]:
        """Return W [stress] in two parts: the isochoric one, and the volumetric one, which may be integrated with
        fewer points where the solid is nearly incompressible."""

    def cauchy_stress(self, gradient: Array) -> Array:
        """Return the Cauchy stress [stress], shape (n, 3, 3), of deformation gradients of that shape."""


def plane_strain_modulus(shear_modulus: float, bulk_modulus: float) -> float:
    """Return E / (1 - nu^2) [stress] of an isotropic solid."""
    mu, kappa = shear_modulus, bulk_modulus
    return 4 * mu * (3 * kappa + mu) / (3 * kappa + 4 * mu)


def in_three_dimensions(gradient: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
    """Return a deformation gradient of shape (3, 3): a planar one with the stretch 1 out of the plane."""
    if tuple(gradient.dims) == (3, 3):
        return gradient
    xx, xy, yx, yy = (gradient[row, column] for row in range(2) for column in range(2))
    return ngsolve.CF((xx, xy, 0, yx, yy, 0, 0, 0, 1), dims=(3, 3))
