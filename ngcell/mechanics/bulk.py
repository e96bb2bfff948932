"""Stored energy of the bodies, one symbolic energy a material.

The volumetric energy of walls whose bulk modulus is above `ngcell.mechanics.mixed.INCOMPRESSIBLE` shear moduli is that
of the mixed method.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isfinite

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.lobatto import lobatto_across
from ngcell.mechanics.mixed import can_be_mixed, is_incompressible, reduced_measure
from ngcell.mechanics.per_body import in_bodies
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.symbolic import Integrals, Rule, SymbolicTerm, more_degrees
from ngcell.mechanics.term import Configuration, Index, Term

Array = NDArray[np.float64]

#: Times that a rule may be made finer.
_FINEST = 3
#: What of its volume is left where an element is squeezed flat.
_FLAT = 0.5
#: Name of that in the memory of a run.
_MEMORY = "rule_of_bodies"


class BodyEnergy(SymbolicTerm):
    """Stored energy of the bodies.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    laws : sequence of HyperelasticLaw
        Law of each body, by number.
    fibre_direction : array of float, shape (elements, 2), of solids (elements, 6), optional
        Unit vector in the plane from which angles of fibres are measured, in each element, and of solids the one
        towards which they are; needed where a law has any.
    extra_degrees : int
        Degrees that the rule integrates exactly besides the usual ones.
    may_miss : float
        Share of the stored energy that the rule may miss where elements are squeezed flat, before a finer one follows.
        At inf the rule stays.
    mixed : sequence of bool, optional
        Bodies with the volumetric energy of the mixed method; by default those that are nearly incompressible, where
        the elements allow it.
    """

    remembers = True

    def __init__(
        self,
        space: DisplacementSpace,
        laws: Sequence[HyperelasticLaw],
        fibre_direction: Array | None = None,
        *,
        extra_degrees: int = 0,
        may_miss: float = inf,
        mixed: Sequence[bool] | None = None,
    ) -> None:
        self.space, self.laws = space, tuple(laws)
        self._direction, self._extra, self._may_miss = fibre_direction, extra_degrees, may_miss
        self._rank = 0
        if mixed is None:
            mixed = [is_incompressible(law) for law in self.laws]
            mixed = mixed if any(mixed) and can_be_mixed(space) else [False] * len(mixed)
        self.mixed = tuple(mixed)

    def integrals(self, displacement: ngsolve.CoefficientFunction) -> Integrals:
        """Yield the stored energy of each material."""
        gradient = ngsolve.Id(self.space.dimension) + ngsolve.Grad(displacement)
        direction = () if self._direction is None else _by_element(self.space, self._direction)
        names = self.space.bodies.body_names
        given = list(zip(self.laws, self.mixed, strict=True))
        for law, is_mixed in dict.fromkeys(given):
            members = "|".join(name for name, mine in zip(names, given, strict=True) if mine == (law, is_mixed))
            energy, volumetric = law.energy_parts(gradient) if is_mixed else (law.stored_energy(gradient), None)
            if law.fibres is not None:
                energy += law.fibres.stored_energy(gradient, direction)
            yield energy.Compile() * self._measure(members, self._rank)
            if volumetric is not None:
                yield volumetric.Compile() * reduced_measure(self.space, members)

    def _measure(self, bodies: str, rank: int) -> ngsolve.comp.DifferentialSymbol:
        """The measure of bodies, by a rule that has been made finer `rank` times.

        Those of quadrilaterals and hexahedra then have the corners among their points; the first is as exact as the
        usual one.
        """
        region, more = self.space.mesh.Materials(bodies), more_degrees(self.space)
        if rank and can_be_mixed(self.space):
            return ngsolve.dx(definedon=region, intrules=lobatto_across(self.space.order + (rank - 1) * more // 2))
        return ngsolve.dx(definedon=region, bonus_intorder=max(self._extra, rank * more))

    @property
    def rule(self) -> Rule:
        """How many times the rule has been made finer."""
        return (self._rank,)

    @property
    def finer_degrees(self) -> int:
        """Degrees that the rule by which the present one is judged integrates exactly besides the usual ones; the first
        of the finer ones with corners among their points is as exact as the usual one, and judged as that is."""
        below = 1 if self._rank and can_be_mixed(self.space) else 0
        return (1 + self._rank - below) * more_degrees(self.space)

    def take_finer_rule(self, at: Configuration) -> bool:
        """Take a finer rule where elements fold between the points of the present one, or are about to: where they are
        squeezed flat, and it misses too much energy; tell whether that is so.

        They do so in sharp corners that close, and store nothing for it. What a rule misses of volumes that hardly
        change is none of that: there a finer one locks.
        """
        if self._rank >= _FINEST or not isfinite(self._may_miss):
            return False
        found, finer = self.value(at), self.finer_form
        assert finer is not None  # bodies have one
        is_enough = abs(finer.energy(at.displacement) - found) <= self._may_miss * abs(found)
        if not self._has_less_volume(at.displacement, 0.0 if is_enough else _FLAT):
            return False
        self._rank += 1
        return True

    def _has_less_volume(self, displacement: Array, share: float) -> bool:
        """Return whether J = det F is below a share at a point of the next rule, or of that which judges this one."""
        gradient = ngsolve.Id(self.space.dimension) + ngsolve.Grad(self.space.function(displacement))
        is_less = ngsolve.IfPos(share - ngsolve.Det(gradient), 1.0, 0.0)
        walls = "|".join(self.space.bodies.body_names)
        measures = (self._measure(walls, self._rank + 1), self.finer(self.finer_degrees)._measure(walls, 0))
        return any(float(ngsolve.Integrate(is_less * measure, self.space.mesh)) > 0 for measure in measures)

    def memory(self) -> dict[str, Array]:
        """Return how many times the rule has been made finer, if it has."""
        return {_MEMORY: np.array([self._rank])} if self._rank else {}

    def recall(self, memory: Mapping[str, Array]) -> None:
        """Take such a rule up again."""
        self._rank = int(memory[_MEMORY][0]) if _MEMORY in memory else 0

    def start_from(self, before: Term, at: Configuration) -> None:
        """Start with the rule of the stage before, if that is finer."""
        assert isinstance(before, BodyEnergy)
        self._rank = max(self._rank, before._rank)

    def refine(self, coarse: Term, at: Configuration) -> None:
        """Start with the rule of the coarser mesh."""
        assert isinstance(coarse, BodyEnergy)
        self._rank = coarse._rank

    def finer(self, extra_degrees: int) -> BodyEnergy:
        """Return the energy by a rule of higher order; the volumetric one of the mixed method stays."""
        return BodyEnergy(self.space, self.laws, self._direction, extra_degrees=extra_degrees, mixed=self.mixed)

    @property
    def is_mixed(self) -> NDArray[np.bool_]:
        """Which elements have the volumetric energy of the mixed method, shape (elements,)."""
        bodies = self.space.bodies
        in_wall = np.ones(bodies.mesh.ne, dtype=bool) if bodies.is_filling is None else ~bodies.is_filling
        return np.asarray(np.array(self.mixed)[bodies.body_of_element] & in_wall)

    def stress(self, gradient: Array, element: Index) -> Array:
        """Return the Cauchy stress [stress], shape (n, 3, 3); zero in what fills lumens."""
        stress, bodies = np.zeros_like(gradient), self.space.bodies
        in_wall = np.ones(len(element), dtype=bool) if bodies.is_filling is None else ~bodies.is_filling[element]
        for law in dict.fromkeys(self.laws):
            of_law = np.array([other == law for other in self.laws])[bodies.body_of_element[element]]
            mine = np.flatnonzero(of_law & in_wall)
            stress[mine] = law.cauchy_stress(gradient[mine])
            if law.fibres is not None:
                assert self._direction is not None
                stress[mine] += law.fibres.cauchy_stress(gradient[mine], self._direction[element[mine]])
        return stress

    def stored_in_bodies(self, at: Configuration) -> Array:
        """Return what each body stores [energy], shape (bodies,)."""
        return in_bodies(self, at)

    @property
    def incompressibility(self) -> float:
        """Largest ratio of bulk to shear modulus."""
        return max(law.bulk_modulus / law.shear_modulus for law in self.laws)

    @property
    def mixed_incompressibility(self) -> float:
        """Largest ratio of bulk to shear modulus of bodies that are mixed; 0 where there are none."""
        given = zip(self.laws, self.mixed, strict=True)
        return max((law.bulk_modulus / law.shear_modulus for law, is_mixed in given if is_mixed), default=0.0)

    def softened(self, ratio: float) -> BodyEnergy:
        """Return the energy with bulk moduli of at most `ratio` times the shear moduli."""
        softer = [law.softened(ratio) for law in self.laws]
        return BodyEnergy(self.space, softer, self._direction, may_miss=self._may_miss, mixed=self.mixed)


def _by_element(space: DisplacementSpace, values: Array) -> tuple[ngsolve.GridFunction, ...]:
    """Return functions that are constant in each element, from values of shape (elements, components)."""
    functions = tuple(ngsolve.GridFunction(ngsolve.L2(space.mesh, order=0)) for _ in values.T)
    for function, column in zip(functions, values.T, strict=True):
        function.vec.FV().NumPy()[:] = column
    return functions
