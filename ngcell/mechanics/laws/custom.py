"""A hyperelastic law of a script: the stored energy as an NGSolve expression of the deformation gradient.

Its stress and its moduli at rest follow by NGSolve's symbolic differentiation, evaluated at all gradients at once:
they are the values of a piecewise constant function on a unit interval, one cell a gradient.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import ngsolve
import numpy as np
from netgen.meshing import Element0D, Element1D, Mesh, MeshPoint, Pnt
from numpy.typing import NDArray

from ngcell.errors import CaseError
from ngcell.mechanics.laws.law import FibreLaw, in_three_dimensions, plane_strain_modulus

Array = NDArray[np.float64]
Expression = Callable[[ngsolve.CoefficientFunction], ngsolve.CoefficientFunction]

#: Strain of the differences that moduli at rest are taken from.
_STRAIN = 1e-5
#: Stress at rest, as a share of the shear modulus, above which a law counts as stressed at rest, and as a share of the
#: larger modulus for energy at rest and for stress after a rotation about each axis; and the angle of it [radian].
_AT_REST, _TURN = 1e-9, 0.7


@dataclass(frozen=True, eq=False)
class CustomLaw:
    """A hyperelastic law whose stored energy a script gives.

    Parameters
    ----------
    energy : function
        Returns W [stress] of the deformation gradient F, an NGSolve expression of shape (3, 3); in plane strain F has
        the row and column (0, 0, 1) of a stretch that is held. W is zero and without stress where F is a rotation, and
        written with what NGSolve has for expressions: ``ngsolve.Det(F)``, ``ngsolve.Trace(F.trans * F)``,
        ``ngsolve.log``, ...
    volumetric : function, optional
        Returns a further part of W [stress] of the volume ratio ``J = det F``. What fills lumens integrates it with
        fewer points, so that it does not lock. By default all of W is in `energy`.
    fibres : FibreLaw, optional
        Fibres, which add to the stored energy given here.

    Notes
    -----
    The law is followed as it is from the start: there is no continuation in its bulk modulus, and beyond 10^4 times the
    shear modulus Newton's method takes many iterations.

    Examples
    --------
    >>> import ngsolve
    >>> law = CustomLaw(lambda F: 0.5 * (ngsolve.Trace(F.trans * F) - 3) - ngsolve.log(ngsolve.Det(F)))
    >>> round(law.shear_modulus, 6)
    1.0
    """

    energy: Expression
    volumetric: Expression | None = None
    fibres: FibreLaw | None = None

    def __post_init__(self) -> None:
        if not callable(self.energy):
            raise CaseError(f"energy of a law is {self.energy!r}; allowed: a function of the deformation gradient")
        told = self.energy(ngsolve.CF(tuple(np.eye(3).ravel()), dims=(3, 3)))
        if not isinstance(told, ngsolve.CoefficientFunction) or told.dim != 1:
            raise CaseError(f"energy of a law returns {told!r}; allowed: an NGSolve expression of one number")
        energy, at_rest = self._energy(np.eye(3)[None])[0], self._first_piola(np.eye(3)[None])[0]
        if not (np.isfinite(at_rest).all() and self.shear_modulus > 0 and self.bulk_modulus > 0):
            raise CaseError(
                f"energy of a law: at rest shear modulus {self.shear_modulus:g}, bulk modulus {self.bulk_modulus:g}; "
                "allowed: finite numbers > 0"
            )
        if np.abs(at_rest).max() > _AT_REST * self.shear_modulus:
            raise CaseError(
                f"energy of a law: a stress of {np.abs(at_rest).max():g} at rest; allowed: none where F is the identity"
            )
        stiffest = max(self.shear_modulus, self.bulk_modulus)
        if not abs(energy) <= _AT_REST * stiffest:
            raise CaseError(f"energy of a law: {energy:g} at rest; allowed: 0 where F is the identity")
        turned = np.abs(self._first_piola(_turns(_TURN))).max()
        if not turned <= _AT_REST * stiffest:
            raise CaseError(f"energy of a law: a stress of {turned:g} after a rotation; allowed: none, as at rest")

    @cached_property
    def shear_modulus(self) -> float:
        """Shear modulus at rest [stress], the mean over the three planes of the axes."""
        shears = np.zeros((3, 3, 3))
        rows, columns = [0, 1, 2], [1, 2, 0]
        shears[[0, 1, 2], rows, columns] = _STRAIN
        change = self._first_piola(np.eye(3) + shears) - self._first_piola(np.eye(3) - shears)
        return float(change[[0, 1, 2], rows, columns].mean() / (2 * _STRAIN))

    @cached_property
    def bulk_modulus(self) -> float:
        """Bulk modulus at rest [stress]."""
        wider, narrower = self._first_piola(np.array([1 + _STRAIN, 1 - _STRAIN])[:, None, None] * np.eye(3))
        return float(np.trace(wider - narrower) / (18 * _STRAIN))

    @property
    def plane_strain_modulus(self) -> float:
        """Modulus E / (1 - nu^2) of a plane-strain half-space at rest [stress]."""
        return plane_strain_modulus(self.shear_modulus, self.bulk_modulus)

    def softened(self, ratio: float) -> CustomLaw:
        """Return the law itself: which part of it is to be softened is not known."""
        return self

    def stored_energy(self, gradient: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        """Return W [stress] of a deformation gradient, shape (3, 3), or (2, 2) for plane strain."""
        whole, volumetric = self.energy_parts(gradient)
        return whole + volumetric

    def energy_parts(
        self, gradient: ngsolve.CoefficientFunction
    ) -> tuple[ngsolve.CoefficientFunction, ngsolve.CoefficientFunction]:
        """Return the two parts of W [stress], as the script gave them."""
        whole = in_three_dimensions(gradient)
        volumetric = ngsolve.CF(0.0) if self.volumetric is None else self.volumetric(ngsolve.Det(whole))
        return self.energy(whole), volumetric

    def cauchy_stress(self, gradient: Array) -> Array:
        """Return the Cauchy stress [stress], shape (n, 3, 3): ``dW/dF F^T / J`` of each deformation gradient."""
        stress = self._first_piola(gradient) @ gradient.transpose(0, 2, 1)
        return np.asarray(stress / np.linalg.det(gradient)[:, None, None])

    def _energy(self, gradient: Array) -> Array:
        """Return W [stress], shape (n,), of deformation gradients of shape (n, 3, 3)."""
        return self._evaluated(gradient, self.stored_energy).ravel()

    def _first_piola(self, gradient: Array) -> Array:
        """Return dW/dF [stress], shape (n, 3, 3), of deformation gradients of that shape."""
        return self._evaluated(gradient, lambda variable: self.stored_energy(variable).Diff(variable)).reshape(-1, 3, 3)

    def _evaluated(self, gradient: Array, expression: Expression) -> Array:
        """Return what an expression of the deformation gradient is at gradients of shape (n, 3, 3)."""
        count = len(gradient)
        entries = [
            ngsolve.VoxelCoefficient((0.0,), (1.0,), column.copy(), False) for column in gradient.reshape(-1, 9).T
        ]
        variable = ngsolve.CF(tuple(entries), dims=(3, 3)).MakeVariable()
        values = expression(variable)(_interval()((np.arange(count) + 0.5) / count))
        return np.asarray(values, dtype=float)


def _turns(angle: float) -> Array:
    """Return rotations about each axis, shape (3, 3, 3)."""
    turns = np.tile(np.eye(3), (3, 1, 1))
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        turns[axis, [one, two], [one, two]] = np.cos(angle)
        turns[axis, one, two], turns[axis, two, one] = -np.sin(angle), np.sin(angle)
    return turns


@cache
def _interval() -> ngsolve.Mesh:
    """Return the unit interval as a mesh of one element."""
    mesh = Mesh(dim=1)
    ends = [mesh.Add(MeshPoint(Pnt(x, 0, 0))) for x in (0.0, 1.0)]
    mesh.Add(Element1D(ends, index=1))
    for number, end in enumerate(ends, start=1):
        mesh.Add(Element0D(end, index=number))
    return ngsolve.Mesh(mesh)
