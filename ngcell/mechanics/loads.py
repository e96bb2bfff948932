"""Loads on boundaries and in bodies, which grow in proportion to the load factor, as energies.

A *traction* t for each reference length (or area, in three dimensions) has the potential ``-integral of t . u``, and so
has a *body force* for each reference area (or volume).

A *pressure* p > 0 acts on the body as it deforms. With the outward normal N at rest, its force for each reference
length is ``-p cof(F) N``, and its potential is p times what the loaded boundary sweeps; see `ngcell.mechanics.swept`.
A pressure on a boundary whose rim is free has no potential at all, and is refused.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.swept import swept_by
from ngcell.mechanics.symbolic import Integrals, SymbolicTerm
from ngcell.mechanics.term import Configuration, Drive, Role
from ngcell.scene import BodyForce, Pressure, Traction
from ngcell.scene.entries import check_dimension

Array = NDArray[np.float64]
Load = Pressure | Traction | BodyForce

#: Degrees that integrals of loads get besides those of displacements where loads depend on the place.
_EXTRA_DEGREES = 6


class BoundaryLoads(SymbolicTerm):
    """All loads of a scene: their potential.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    loads : sequence of Pressure, Traction or BodyForce
        The loads; those on the same boundary or body add up.
    motion : PrescribedMotion
        The supports, which hold the rims of boundaries under pressure.
    in_full : bool
        Whether loads act in full at every load factor above 0, instead of growing with it.
    cell_pressure : array of float, shape (bodies,), optional
        Pressure in each cell at load factor 1 [stress], where the loads are those.

    Attributes
    ----------
    factor : ngsolve.Parameter
        The load factor that the potential is taken at.

    Raises
    ------
    CaseError
        If a boundary under pressure has a rim that no support holds, or that slides along a support that moves, or if
        a vector has another dimension than the bodies.
    """

    def __init__(
        self,
        space: DisplacementSpace,
        loads: Sequence[Load],
        motion: PrescribedMotion,
        *,
        in_full: bool = False,
        cell_pressure: Array | None = None,
    ) -> None:
        self.space = space
        self._in_full, self._cell_pressure = in_full, cell_pressure
        self._loads = tuple(loads)
        self.factor = ngsolve.Parameter(0.0)
        for load in self._loads:
            if not isinstance(load, Pressure) and not callable(load.vector):
                place = f"force on {load.body}" if isinstance(load, BodyForce) else f"traction on {load.boundary}"
                check_dimension(load.vector, f"{place}: vector", space.dimension)
        self._swept = swept_by(space, _pressures(self._loads))
        self._swept.check(motion)

    @property
    def role(self) -> Role:
        """Loads act from outside."""
        return Role.LOAD

    def apply(self, load_factor: float) -> None:
        """Set the load factor of the potential."""
        self.factor.Set(self.share(load_factor))

    def share(self, load_factor: float) -> float:
        """Return the share of the loads that acts at a load factor."""
        return 1.0 if self._in_full else load_factor

    def integrals(self, displacement: ngsolve.CoefficientFunction) -> Integrals:
        """Return the potential at `factor`, whatever it will be, as integrals over boundaries and bodies."""
        return [self.factor * self._density(load, displacement) * self._measure(load) for load in self._loads]

    def beyond_integrals(self, displacement: Array) -> Array:
        """Return what rims add to the gradient, as nodal forces, shape (unknowns,)."""
        return self._swept.at_rims(displacement, self.factor.Get())

    def unstored(self, at: Configuration) -> float:
        """Return the potential: none of it is stored in bodies."""
        return self.potential(at.displacement)

    def drive(self, at: Configuration, load_factor: float) -> Drive:
        """Return the share of the loads, and their potential in full."""
        return Drive(self.share(load_factor), self.potential(at.displacement, 1.0), 0.0)

    def cell_fields(self, at: Configuration, load_factor: float) -> dict[str, Array]:
        """Return the pressure in each cell [stress], where loads are such pressures."""
        given = self._cell_pressure
        return {} if given is None else {"cell_pressure": self.share(load_factor) * given}

    def potential(self, displacement: Array, load_factor: float | None = None) -> float:
        """Return the potential [stress * length**2] at a load factor, by default the one applied; zero at rest."""
        with self.at_factor(load_factor):
            return self.form.energy(displacement)

    @contextmanager
    def at_factor(self, load_factor: float | None) -> Iterator[None]:
        """Take another load factor for a while; None is the one applied."""
        applied = self.factor.Get()
        if load_factor is not None:
            self.apply(load_factor)
        yield
        self.factor.Set(applied)

    def _density(self, load: Load, displacement: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
        """Return the potential for each reference length or area at load factor 1."""
        if isinstance(load, Pressure):
            return load.value * self._swept.outward * self._swept.swept(displacement)
        coordinates = (ngsolve.x, ngsolve.y, ngsolve.z)[: self.space.dimension]
        first, *others = load.vector(*coordinates) if callable(load.vector) else load.vector
        work = first * displacement[0]
        for axis, component in enumerate(others, start=1):
            work = work + component * displacement[axis]
        return -work

    def _measure(self, load: Load) -> ngsolve.comp.DifferentialSymbol:
        """Return what the potential is integrated over."""
        mesh, extra = self.space.bodies.mesh, 0
        if not isinstance(load, Pressure) and callable(load.vector):
            extra = _EXTRA_DEGREES
        if isinstance(load, BodyForce):
            return ngsolve.dx(definedon=mesh.Materials(load.body), bonus_intorder=extra)
        return ngsolve.ds(definedon=mesh.Boundaries(load.boundary), bonus_intorder=extra)


def _pressures(loads: Sequence[Load]) -> dict[str, float]:
    """Return the pressure on each boundary region."""
    pressures: dict[str, float] = {}
    for load in loads:
        if isinstance(load, Pressure):
            pressures[load.boundary] = pressures.get(load.boundary, 0.0) + load.value
    return pressures
