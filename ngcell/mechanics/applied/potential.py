"""The potential of all loads that act on boundaries and in bodies, as one term; it grows with the load factor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import ngsolve
import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.applied.protocol import AppliedLoad
from ngcell.mechanics.drive import Drive
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.swept import swept_by
from ngcell.mechanics.symbolic import Integrals, SymbolicTerm
from ngcell.mechanics.term import Configuration, Role

Array = NDArray[np.float64]


class AppliedLoads(SymbolicTerm):
    """All loads of a scene: their potential.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    loads : sequence of AppliedLoad
        The loads; those on the same boundary or body add up.
    motion : PrescribedMotion
        The supports, which hold the rims of boundaries under pressure.
    in_full : bool
        Whether loads act in full at every load factor, instead of growing with it.
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
        loads: Sequence[AppliedLoad],
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
            load.check(space.dimension)
        self._swept = swept_by(space, self.pressures)
        self._swept.check(motion)

    @property
    def pressures(self) -> dict[str, float]:
        """Pressure on each boundary at the full load [stress]."""
        return _pressures(self._loads)

    @property
    def has_others(self) -> bool:
        """Whether there are loads that are no pressures."""
        return any(load.boundary is None or not load.pressure for load in self._loads)

    @property
    def in_full(self) -> bool:
        """Whether loads act in full at every load factor above 0."""
        return self._in_full

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
        densities = (load.density(self.space, displacement, self._swept) for load in self._loads)
        regions = (load.region(self.space) for load in self._loads)
        return [self.factor * density * region for density, region in zip(densities, regions, strict=True)]

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
        try:
            yield
        finally:
            self.factor.Set(applied)


def _pressures(loads: Sequence[AppliedLoad]) -> dict[str, float]:
    """Return the pressure on each boundary region."""
    pressures: dict[str, float] = {}
    for load in loads:
        if load.boundary is not None and load.pressure:
            pressures[load.boundary] = pressures.get(load.boundary, 0.0) + load.pressure
    return pressures
