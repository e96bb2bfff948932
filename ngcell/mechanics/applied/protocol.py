"""What a load that acts on a boundary or in a body offers.

A further load is one file beside this one and one line in `ngcell.scene.registry`; a script may hand over any object
with these members.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import ngsolve

from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.swept import SweptArea, SweptVolume


@runtime_checkable
class AppliedLoad(Protocol):
    """A load that grows in proportion to the load factor."""

    @property
    def boundary(self) -> str | None:
        """Name of the boundary that it acts on; None if it acts in a body."""

    @property
    def body(self) -> str | None:
        """Name of the body that it acts in; None if it acts on a boundary."""

    @property
    def pressure(self) -> float:
        """Pressure that stays normal to its boundary as it deforms [stress]; 0 for any other load.

        Where boundaries under different pressures meet, a rim has to be held; see `ngcell.mechanics.swept`.
        """

    def check(self, dimension: int) -> None:
        """Raise CaseError if it cannot act on bodies of this dimension."""

    def density(
        self, space: DisplacementSpace, displacement: ngsolve.CoefficientFunction, swept: SweptArea | SweptVolume
    ) -> ngsolve.CoefficientFunction:
        """Return its potential at load factor 1 for each reference length, area or volume; its force is minus the
        derivative.

        Parameters
        ----------
        space : DisplacementSpace
            The unknowns.
        displacement : ngsolve.CoefficientFunction
            The displacement [length].
        swept : SweptArea or SweptVolume
            What boundaries sweep as they move.
        """

    def region(self, space: DisplacementSpace) -> ngsolve.comp.DifferentialSymbol:
        """Return what the density is integrated over: ``ngsolve.ds`` or ``ngsolve.dx``, with its boundary or body."""
