"""A solid in every cell."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import field_validator

from ngcell.geometry.tissues.protocol import TissueGeometry
from ngcell.mechanics.inclusion import InclusionEnergy
from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Term
from ngcell.scene.choice import OneOf
from ngcell.scene.scope import refuse
from ngcell.scene.section import Section


class Inclusion(Section):
    """A solid that fills every cell and is bonded to its wall.

    Parameters
    ----------
    material : MooneyRivlin
        What it is made of: as a rule softer than the wall, and nearly incompressible.
    """

    kind: Literal["inclusion"] = "inclusion"
    material: Annotated[Any, OneOf("material")]

    @field_validator("material")
    @classmethod
    def _without_fibres(cls, material: Any) -> Any:
        if material.fibres is not None:
            refuse("run along walls, which a lumen has none of; allowed: no fibres in an inclusion", "fibres")
        for key in ("strength", "stretch_limit"):
            if getattr(material, key, None) is not None:
                refuse("is that of walls; allowed: only in [material]", key)
        return material

    @property
    def solid(self) -> HyperelasticLaw:
        """Law of the solid that fills lumens."""
        law: HyperelasticLaw = self.material
        return law

    def regions(self, tissue: TissueGeometry) -> None:
        """Return nothing: inner walls are bonded to what fills the cells."""

    def terms(
        self, space: DisplacementSpace, motion: PrescribedMotion, tissue: TissueGeometry, wall: HyperelasticLaw
    ) -> tuple[Term, ...]:
        """Return its stored energy."""
        return (InclusionEnergy(space, self.solid),)
