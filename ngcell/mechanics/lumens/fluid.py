"""An incompressible fluid in every cell; its mechanics are in `ngcell.mechanics.fluid`."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

from ngcell.geometry.bodies import LUMEN
from ngcell.geometry.tissues.protocol import TissueGeometry
from ngcell.mechanics.fluid import LumenFluids
from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.lumens.lumen import CLOSED
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Term
from ngcell.scene.scope import are_open_prisms, refuse
from ngcell.scene.section import PositiveNumber, Section


class Fluid(Section):
    """An incompressible fluid that fills every cell: each lumen keeps its area, whatever pressure that takes.

    In three dimensions a closed lumen keeps its volume.

    Parameters
    ----------
    fill : float
        Area, or volume, of the fluid at load factor 1 over that of the lumen at rest, > 0; more than 1 makes cells
        turgid.
    ramp : {"with-load", "first"}
        Whether cells are filled up in proportion to the load, or hold that much at every level.
    """

    kind: Literal["fluid"] = "fluid"
    fill: PositiveNumber = 1.0
    ramp: Literal["with-load", "first"] = "with-load"
    goes_with_cohesion: ClassVar[bool] = False
    keeps_volume: ClassVar[bool] = True

    @property
    def before_load(self) -> str | None:
        """What is there in full before the load, in words."""
        return "fluids in lumens"

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse prisms that are open at their ends."""
        if are_open_prisms(scene):
            refuse(f"flows out of hollow prisms; {CLOSED}", "kind")

    @property
    def solid(self) -> None:
        """No solid fills the lumens."""
        return None

    def regions(self, tissue: TissueGeometry) -> None:
        """Return nothing: all lumens are one region."""

    def terms(
        self, space: DisplacementSpace, motion: PrescribedMotion, tissue: TissueGeometry, wall: HyperelasticLaw
    ) -> tuple[Term, ...]:
        """Return the fluids of all cells."""
        first = self.ramp == "first"
        return (LumenFluids(space, LUMEN, modulus=wall.shear_modulus, fill=self.fill, in_full=first),)
