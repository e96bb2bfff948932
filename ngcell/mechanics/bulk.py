"""The stored energy of all bodies: one symbolic NGSolve energy a material."""

from __future__ import annotations

from collections.abc import Sequence

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.hyperelastic import MooneyRivlinLaw
from ngcell.mechanics.space import DisplacementSpace

Array = NDArray[np.float64]


class BulkEnergy:
    """Stored energy of the bodies, its gradient and its tangent.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    laws : sequence of MooneyRivlinLaw
        Law of each body, by number.
    """

    def __init__(self, space: DisplacementSpace, laws: Sequence[MooneyRivlinLaw]) -> None:
        self.laws = tuple(laws)
        trial = space.vector.TrialFunction()
        gradient = ngsolve.Id(space.dimension) + ngsolve.Grad(trial)
        self._form = ngsolve.BilinearForm(space.vector, symmetric=True)
        for law in dict.fromkeys(self.laws):
            names = "|".join(
                name for name, mine in zip(space.bodies.body_names, self.laws, strict=True) if mine == law
            )
            region = space.bodies.mesh.Materials(names)
            energy = law.stored_energy(gradient).Compile()
            self._form += ngsolve.Variation(energy * ngsolve.dx(definedon=region))
        self._state = ngsolve.GridFunction(space.vector).vec
        self._force = self._state.CreateVector()

    def energy(self, displacement: Array) -> float:
        """Return the stored energy, NaN where an element is inverted."""
        return float(self._form.Energy(self._at(displacement)))

    def gradient(self, displacement: Array) -> Array:
        """Return the internal forces, shape (unknowns,)."""
        self._form.Apply(self._at(displacement), self._force)
        return self._force.FV().NumPy().copy()

    def tangent(self, displacement: Array) -> ngsolve.la.BaseMatrix:
        """Return the tangent; the matrix is overwritten by the next call and its pattern never changes."""
        self._form.AssembleLinearization(self._at(displacement))
        return self._form.mat

    def _at(self, displacement: Array) -> ngsolve.BaseVector:
        self._state.FV().NumPy()[:] = displacement
        return self._state
