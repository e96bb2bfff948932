"""Stored energy of what fills lumens.

It is nearly incompressible, and would lock: its volumetric energy is that of the mixed method.
"""

from __future__ import annotations

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.bodies import FILLING
from ngcell.mechanics.laws.law import HyperelasticLaw, in_three_dimensions
from ngcell.mechanics.lobatto import lobatto_across
from ngcell.mechanics.mixed import reduced_measure
from ngcell.mechanics.per_body import by_body, in_bodies
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.symbolic import Integrals, SymbolicTerm
from ngcell.mechanics.term import Configuration, Index

Array = NDArray[np.float64]


class InclusionEnergy(SymbolicTerm):
    """Stored energy of what fills the lumens.

    The isochoric part is integrated by Gauss-Lobatto rules across a cell, as exact as the usual Gauss rules. What is
    soft and keeps its volume on average would fold in a sharp corner of the lumen, where Gauss points see nothing; at
    the corner's own point its energy grows without bounds.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    law : HyperelasticLaw
        Its law, with an isochoric and a volumetric part.
    extra_degrees : int
        Degrees that the rule of the isochoric part integrates exactly besides the usual ones.
    """

    remembers = True

    def __init__(self, space: DisplacementSpace, law: HyperelasticLaw, *, extra_degrees: int = 0) -> None:
        self.space, self.law, self._extra = space, law, extra_degrees

    def integrals(self, displacement: ngsolve.CoefficientFunction) -> Integrals:
        """Return the isochoric energy, and the volumetric one by a reduced rule."""
        gradient = ngsolve.Id(self.space.dimension) + ngsolve.Grad(displacement)
        isochoric, volumetric = (part.Compile() for part in self.law.energy_parts(gradient))
        return [isochoric * self._full_measure, volumetric * reduced_measure(self.space, FILLING)]

    @property
    def _full_measure(self) -> ngsolve.comp.DifferentialSymbol:
        """The measure of the isochoric part."""
        region = self.space.mesh.Materials(FILLING)
        if self._extra:
            return ngsolve.dx(definedon=region, bonus_intorder=self._extra)
        return ngsolve.dx(definedon=region, intrules=lobatto_across(self.space.order))

    def finer(self, extra_degrees: int) -> InclusionEnergy:
        """Return the energy with its isochoric part by a rule of higher order.

        The reduced rule of the volumetric part stays: it is no approximation of an integral, but the mixed method.
        """
        return InclusionEnergy(self.space, self.law, extra_degrees=extra_degrees)

    def stress(self, gradient: Array, element: Index) -> Array:
        """Return the Cauchy stress [stress], shape (n, 3, 3); zero in walls."""
        stress, is_filling = np.zeros_like(gradient), self.space.bodies.is_filling
        assert is_filling is not None
        mine = np.flatnonzero(is_filling[element])
        stress[mine] = self.law.cauchy_stress(gradient[mine])
        return stress

    def stored_in_bodies(self, at: Configuration) -> Array:
        """Return what the filling of each lumen stores [energy], shape (bodies,)."""
        return in_bodies(self, at)

    @property
    def incompressibility(self) -> float:
        """Ratio of bulk to shear modulus."""
        return self.law.bulk_modulus / self.law.shear_modulus

    @property
    def mixed_incompressibility(self) -> float:
        """The same: what fills lumens is always mixed."""
        return self.incompressibility

    def softened(self, ratio: float) -> InclusionEnergy:
        """Return the energy with a bulk modulus of at most `ratio` times the shear modulus."""
        return InclusionEnergy(self.space, self.law.softened(ratio))

    def cell_fields(self, at: Configuration, load_factor: float) -> dict[str, Array]:
        """Return the mean pressure ``-trace(sigma) / 3`` over the deformed volume of each lumen [stress].

        With ``J sigma = dW/dF F^T`` it is ``-dW/dF : F / 3`` over the reference volume, each part of W by the rule that
        it is integrated with.
        """
        space = self.space
        planar = ngsolve.Id(space.dimension) + ngsolve.Grad(space.function(at.displacement))
        gradient = in_three_dimensions(planar).MakeVariable()
        reduced = reduced_measure(space, FILLING)
        rules = [self._full_measure, reduced]
        parts = [part.Diff(gradient) for part in self.law.energy_parts(gradient)]
        works = [ngsolve.InnerProduct(part, gradient) * rule for part, rule in zip(parts, rules, strict=True)]
        volume = by_body(space, ngsolve.Det(gradient) * reduced)
        work = -sum(by_body(space, work) for work in works) / 3
        return {"cell_pressure": np.divide(work, volume, out=np.zeros_like(volume), where=volume != 0)}
