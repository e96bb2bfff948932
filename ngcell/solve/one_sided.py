"""A quadratic plus one-sided penalty terms: the second-order model of an energy with contact.

It has the linearised gap of every near wall. `ngcell.solve.inner` finds its minimum.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.solve.stiffness import Stiffness

Array = NDArray[np.float64]


class Matrix(Protocol):
    """A symmetric matrix with a lasting pattern, and a solver for it."""

    @property
    def few(self) -> int:
        """Number of solutions that take no more operations than a factorisation."""

    def factorise(self, stiffness: Stiffness, jacobian: sparse.csr_array, penalty: Array) -> None:
        """Prepare to solve systems with this matrix plus ``jacobian.T @ diag(penalty) @ jacobian``."""

    def solve(self, right: Array) -> Array:
        """Return the solution; 0 in rows that are not free."""

    def multiply(self, stiffness: Stiffness, vector: Array) -> Array:
        """Return the product of the symmetric matrix and a vector."""

    def reduced(self, model: OneSidedModel) -> Reduced | None:
        """Return a model of fewer unknowns with the same minimum; None where there is none."""


class Reduced(Protocol):
    """A model without the unknowns that no penalty term touches; see `ngcell.solve.condensed.Reduced`."""

    @property
    def model(self) -> OneSidedModel:
        """The model of the rest."""

    @property
    def matrix(self) -> Matrix:
        """The matrix that solves for it."""

    @property
    def coarse(self) -> Coarse | None:
        """The model among the low modes of bodies; None where there is none."""

    @property
    def change(self) -> float:
        """Change of the whole model as what was left out finds its minimum, the rest at 0."""

    def whole(self, step: Array) -> Array:
        """Return the step of all unknowns from that of the rest."""


@dataclass(frozen=True, eq=False)
class OneSidedModel:
    """``m(d) = gradient d + d K d / 2 + sum_i penalty_i min(0, gap_i + jacobian_i d)^2 / 2``.

    Attributes
    ----------
    gradient : array of float, shape (unknowns,)
        Zero on unknowns that are not free.
    stiffness : Stiffness
        K, on the matrix' pattern.
    gap, jacobian, penalty term : array, csr_array, array
        The penalty terms.
    free : array of bool, shape (unknowns,)
        Unknowns that may move.
    """

    gradient: Array
    stiffness: Stiffness
    gap: Array
    jacobian: sparse.csr_array
    penalty: Array
    free: NDArray[np.bool_]

    @property
    def is_bent(self) -> bool:
        """Whether it has the curvature of gaps."""
        return self.stiffness.moving is not None

    def bent_by(self, curvature: sparse.csr_array | None) -> OneSidedModel:
        """Return the model with another curvature of gaps; without one they are as if linear in displacements."""
        return replace(self, stiffness=replace(self.stiffness, moving=curvature))

    def with_more(self, gap: Array, jacobian: sparse.csr_array, penalty: Array) -> OneSidedModel:
        """Return the model with more penalty terms, after its own."""
        return replace(
            self,
            gap=np.concatenate([self.gap, gap]),
            jacobian=sparse.vstack([self.jacobian, jacobian], format="csr"),
            penalty=np.concatenate([self.penalty, penalty]),
        )

    @cached_property
    def full_gradient(self) -> Array:
        """The gradient at 0, penalty terms included; zero on unknowns that are not free."""
        return np.where(self.free, self.gradient + self.pulled(self.penalty * np.minimum(self.gap, 0)), 0.0)

    def gradient_after(self, curved: Array, moved: Array) -> Array:
        """Return the gradient after a step, with ``curved = K step`` and ``moved = jacobian step``."""
        return np.asarray(self.gradient + curved + self.pulled(self.penalty * np.minimum(self.gap + moved, 0)))

    def pulled(self, forces: Array) -> Array:
        """Return ``jacobian.T forces``."""
        return np.asarray(self._transposed @ forces)

    @cached_property
    def _transposed(self) -> sparse.csc_array:
        return self.jacobian.T

    def stored(self, gap: Array) -> float:
        """Return the energy that the penalty terms store at these gaps."""
        return 0.5 * float((self.penalty * np.minimum(gap, 0) ** 2).sum())

    def change(self, step: Array, curved: Array, moved: Array) -> float:
        """Return ``m(step) - m(0)``, with ``curved = K step`` and ``moved = jacobian step``."""
        before, after = np.minimum(self.gap, 0), np.minimum(self.gap + moved, 0)
        # What penalty terms add to their first-order part, without differences of squares: those drown small steps.
        flipped = (after - before) * (after + before) - 2 * before * moved
        bent = np.where((before < 0) & (after < 0), moved**2, flipped)
        return float(self.full_gradient @ step + 0.5 * (step @ curved) + 0.5 * (self.penalty @ bent))


@dataclass(frozen=True, eq=False)
class Coarse:
    """A model among low modes.

    Attributes
    ----------
    basis : csr_array, shape (unknowns, modes)
        The modes.
    model : OneSidedModel
        The model about a step of nothing, without its gradient.
    matrix : Matrix
        What solves for it.
    """

    basis: sparse.csr_array
    model: OneSidedModel
    matrix: Matrix

    def after(self, gradient: Array, gap: Array) -> OneSidedModel:
        """Return the model about a place with this gradient of the quadratic, and these gaps."""
        model = self.model
        along = np.where(model.free, self.basis.T @ gradient, 0.0)
        return OneSidedModel(along, model.stiffness, gap, model.jacobian, model.penalty, model.free)
