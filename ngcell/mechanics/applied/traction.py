"""A traction: a force on a boundary that keeps its direction, with the potential ``-integral of t . u``."""

from __future__ import annotations

from typing import ClassVar, Literal

import ngsolve

from ngcell.mechanics.applied.vector import Vector, check_vector, extra_degrees, work
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.swept import SweptArea, SweptVolume
from ngcell.scene.section import Name, Section


class Traction(Section):
    """A force ``load_factor * vector`` for each unit of a boundary's length or area at rest, in a fixed direction.

    Parameters
    ----------
    boundary : str
        Name of a boundary, as for a support.
    vector : tuple of float, shape (dimension,), or function of the place
        Force on the body for each reference length or area at load factor 1 [stress].
    """

    body: ClassVar[str | None] = None
    pressure: ClassVar[float] = 0.0

    kind: Literal["traction"] = "traction"
    boundary: Name
    vector: Vector

    def check(self, dimension: int) -> None:
        """Raise CaseError if the vector is one of other dimensions."""
        check_vector(self.vector, f"traction on {self.boundary}", dimension)

    def density(
        self, space: DisplacementSpace, displacement: ngsolve.CoefficientFunction, swept: SweptArea | SweptVolume
    ) -> ngsolve.CoefficientFunction:
        """Return minus the work of the traction."""
        return -work(self.vector, space, displacement)

    def region(self, space: DisplacementSpace) -> ngsolve.comp.DifferentialSymbol:
        """Return its boundary."""
        boundaries = space.mesh.Boundaries(self.boundary)
        return ngsolve.ds(definedon=boundaries, bonus_intorder=extra_degrees(self.vector))
