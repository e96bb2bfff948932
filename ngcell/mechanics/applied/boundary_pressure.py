"""A pressure on a boundary, which acts on the body as it deforms.

With the outward normal N at rest, its force for each reference length (or area) is ``-p cof(F) N``, and its potential
is p times what the loaded boundary sweeps; see `ngcell.mechanics.swept`. A pressure on a boundary whose rim is free has
no potential at all, and is refused.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import ngsolve

from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.swept import SweptArea, SweptVolume
from ngcell.scene.section import Name, Section


class Pressure(Section):
    """A pressure ``load_factor * value`` on a boundary, which stays normal to it as it deforms.

    Parameters
    ----------
    boundary : str
        Name of a boundary, as for a support.
    value : float
        Pressure at load factor 1 [stress]; > 0 acts into the body.

    Notes
    -----
    It has an energy, and so a place here, where no end of the loaded line is free: the line is closed, or meets a
    line under the same pressure, or its end is held, or it slides along a support that stays in place. The same goes
    for the rim of a solid's face.
    """

    body: ClassVar[str | None] = None

    kind: Literal["pressure"] = "pressure"
    boundary: Name
    value: float

    @property
    def pressure(self) -> float:
        """The pressure."""
        return self.value

    def check(self, dimension: int) -> None:
        """A pressure acts on bodies of any dimension."""

    def density(
        self, space: DisplacementSpace, displacement: ngsolve.CoefficientFunction, swept: SweptArea | SweptVolume
    ) -> ngsolve.CoefficientFunction:
        """Return the pressure times what its boundary sweeps."""
        return self.value * swept.outward * swept.swept(displacement)

    def region(self, space: DisplacementSpace) -> ngsolve.comp.DifferentialSymbol:
        """Return its boundary."""
        return ngsolve.ds(definedon=space.mesh.Boundaries(self.boundary))
