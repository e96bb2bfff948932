"""A force in a body that keeps its direction, such as weight, with the potential ``-integral of b . u``."""

from __future__ import annotations

from typing import ClassVar, Literal

import ngsolve

from ngcell.mechanics.applied.vector import Vector, check_vector, extra_degrees, work
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.swept import SweptArea, SweptVolume
from ngcell.scene.section import Name, Section


class BodyForce(Section):
    """A force ``load_factor * vector`` for each unit of a body's area or volume at rest, in a fixed direction.

    Parameters
    ----------
    body : str
        Name of a body.
    vector : tuple of float, shape (dimension,), or function of the place
        Force for each reference area or volume at load factor 1 [stress / length].
    """

    boundary: ClassVar[str | None] = None
    pressure: ClassVar[float] = 0.0

    kind: Literal["body-force"] = "body-force"
    body: Name
    vector: Vector

    def check(self, dimension: int) -> None:
        """Raise CaseError if the vector is one of other dimensions."""
        check_vector(self.vector, f"force on {self.body}", dimension)

    def density(
        self, space: DisplacementSpace, displacement: ngsolve.CoefficientFunction, swept: SweptArea | SweptVolume
    ) -> ngsolve.CoefficientFunction:
        """Return minus the work of the force."""
        return -work(self.vector, space, displacement)

    def region(self, space: DisplacementSpace) -> ngsolve.comp.DifferentialSymbol:
        """Return its body."""
        return ngsolve.dx(definedon=space.mesh.Materials(self.body), bonus_intorder=extra_degrees(self.vector))
