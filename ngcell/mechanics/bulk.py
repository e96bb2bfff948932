"""The energy of all bodies: one symbolic NGSolve energy a material, and the potential of loads, if there are any.

What fills lumens is nearly incompressible, and would lock: its volumetric energy is taken by a rule of as many points
in each direction as its order, fewer than the full one. For quadrilaterals that is the mixed method with a
discontinuous pressure one order lower, without the unknowns of that pressure and with an energy that is minimised.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.bodies import FILLING
from ngcell.mechanics.filling import reduced_rules
from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.loads import BoundaryLoads
from ngcell.mechanics.space import DisplacementSpace

Array = NDArray[np.float64]


class BulkEnergy:
    """Stored energy of the bodies plus the potential of their loads, its gradient and its tangent.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    laws : sequence of HyperelasticLaw
        Law of each body, by number.
    loads : BoundaryLoads, optional
        Loads on boundaries, taken at the load factor that was last applied to them. By default there are none.
    filling : HyperelasticLaw, optional
        Law of what fills the lumens; needed where there is something.
    fibre_direction : array of float, shape (elements, 2), in three dimensions (elements, 6), optional
        Unit vector in the plane from which angles of fibres are measured, in each element, and in three dimensions the one
        towards which they are; needed where a law has any.
    """

    def __init__(
        self,
        space: DisplacementSpace,
        laws: Sequence[HyperelasticLaw],
        loads: BoundaryLoads | None = None,
        filling: HyperelasticLaw | None = None,
        fibre_direction: Array | None = None,
    ) -> None:
        self._space = space
        self.laws = tuple(laws)
        self.filling = filling
        self.loads = loads
        self.fibre_direction = fibre_direction
        direction = None if fibre_direction is None else _by_element(space, fibre_direction)
        trial = space.vector.TrialFunction()
        gradient = ngsolve.Id(space.dimension) + ngsolve.Grad(trial)
        self._form = ngsolve.BilinearForm(space.vector, symmetric=True)
        for law in dict.fromkeys(self.laws):
            names = "|".join(name for name, mine in zip(space.bodies.body_names, self.laws, strict=True) if mine == law)
            region = space.bodies.mesh.Materials(names)
            energy = law.stored_energy(gradient)
            if law.fibres is not None:
                energy += law.fibres.stored_energy(gradient, direction)
            self._form += ngsolve.Variation(energy.Compile() * ngsolve.dx(definedon=region))
        if filling is not None:
            region = space.bodies.mesh.Materials(FILLING)
            reduced = ngsolve.dx(definedon=region, intrules=reduced_rules(space))
            isochoric, volumetric = (part.Compile() for part in filling.energy_parts(gradient))
            self._form += ngsolve.Variation(isochoric * ngsolve.dx(definedon=region))
            self._form += ngsolve.Variation(volumetric * reduced)
        for term in loads.terms(trial) if loads is not None else ():
            self._form += ngsolve.Variation(term)
        self._state = ngsolve.GridFunction(space.vector).vec
        self._force = self._state.CreateVector()
        self._is_assembled = False

    def materials(self) -> Iterator[tuple[HyperelasticLaw, NDArray[np.bool_]]]:
        """Yield each law and the elements that follow it, shape (elements,)."""
        bodies = self._space.bodies
        in_wall = np.ones(len(bodies.body_of_element), dtype=bool)
        if self.filling is not None and bodies.is_filling is not None:
            in_wall = ~bodies.is_filling
            yield self.filling, bodies.is_filling
        for law in dict.fromkeys(self.laws):
            yield law, in_wall & np.array([mine == law for mine in self.laws])[bodies.body_of_element]

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
        self._is_assembled = True
        return self._form.mat

    @property
    def matrix(self) -> ngsolve.la.BaseMatrix:
        """The matrix of the last tangent; its pattern is that of all."""
        return self._form.mat if self._is_assembled else self.tangent(np.zeros(self._space.unknowns))

    def _at(self, displacement: Array) -> ngsolve.BaseVector:
        self._state.FV().NumPy()[:] = displacement
        return self._state


def _by_element(space: DisplacementSpace, values: Array) -> tuple[ngsolve.GridFunction, ...]:
    """Return functions that are constant in each element, from values of shape (elements, components)."""
    functions = tuple(ngsolve.GridFunction(ngsolve.L2(space.bodies.mesh, order=0)) for _ in values.T)
    for function, column in zip(functions, values.T, strict=True):
        function.vec.FV().NumPy()[:] = column
    return functions
