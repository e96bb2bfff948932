"""The energy of all bodies: one symbolic NGSolve energy a material, and the potential of loads, if there are any."""

from __future__ import annotations

from collections.abc import Sequence

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.hyperelastic import MooneyRivlinLaw
from ngcell.mechanics.loads import BoundaryLoads
from ngcell.mechanics.space import DisplacementSpace

Array = NDArray[np.float64]


class BulkEnergy:
    """Stored energy of the bodies plus the potential of their loads, its gradient and its tangent.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    laws : sequence of MooneyRivlinLaw
        Law of each body, by number.
    loads : BoundaryLoads, optional
        Loads on boundaries, taken at the load factor that was last applied to them. By default there are none.
    """

    def __init__(
        self, space: DisplacementSpace, laws: Sequence[MooneyRivlinLaw], loads: BoundaryLoads | None = None
    ) -> None:
        self.laws = tuple(laws)
        self.loads = loads
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
        for term in loads.terms(trial) if loads is not None else ():
            self._form += ngsolve.Variation(term)
        self._state = ngsolve.GridFunction(space.vector).vec
        self._force = self._state.CreateVector()

    def energy(self, displacement: Array) -> float:
        """Return what is minimised: the stored energy and the loads' potential; NaN where an element is inverted."""
        return float(self._form.Energy(self._at(displacement)))

    def load_potential(self, displacement: Array) -> float:
        """Return the loads' part of `energy`, zero at rest."""
        return 0.0 if self.loads is None else self.loads.potential(displacement)

    def gradient(self, displacement: Array) -> Array:
        """Return the internal forces minus those of the loads, shape (unknowns,)."""
        self._form.Apply(self._at(displacement), self._force)
        force = self._force.FV().NumPy().copy()
        return force if self.loads is None else force + self.loads.at_ends(displacement)

    def tangent(self, displacement: Array) -> ngsolve.la.BaseMatrix:
        """Return the tangent; the matrix is overwritten by the next call and its pattern never changes."""
        self._form.AssembleLinearization(self._at(displacement))
        return self._form.mat

    def _at(self, displacement: Array) -> ngsolve.BaseVector:
        self._state.FV().NumPy()[:] = displacement
        return self._state
