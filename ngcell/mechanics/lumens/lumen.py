"""What the contents of lumens offer, whatever they are. Without any, cells are hollow, and nothing is built for it.

Further contents are one file beside this one and one line in `ngcell.scene.registry`; a script may hand over any object
with these members.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from ngcell.geometry.tissues.protocol import Lumens, TissueGeometry
from ngcell.mechanics.laws.law import HyperelasticLaw
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Term

#: Words for what only closed prisms can hold.
CLOSED = "allowed: closed ones, with a tissue.end_wall"


@runtime_checkable
class LumenContents(Protocol):
    """What every cell of a tissue holds."""

    @property
    def solid(self) -> HyperelasticLaw | None:
        """Law of the solid that fills lumens, meshed with elements of its own; None where none does."""

    def regions(self, tissue: TissueGeometry) -> Lumens | None:
        """Return the cells whose inner walls form each region; None where nothing tells them apart."""

    def terms(
        self, space: DisplacementSpace, motion: PrescribedMotion, tissue: TissueGeometry, wall: HyperelasticLaw
    ) -> tuple[Term, ...]:
        """Return the terms that it adds to the energy of a tissue with such walls."""


def keeps_volume(contents: LumenContents) -> bool:
    """Return whether cells with these contents rather change their shape than their volume.

    A script's contents may say so by ``keeps_volume``. Solids do where a sheet of them, in plane strain, that is
    stretched by e narrows by more than e / 2: ``nu / (1 - nu) > 1/2``, or a bulk modulus above 8/3 shear moduli.
    """
    said, solid = getattr(contents, "keeps_volume", None), contents.solid
    if said is not None or solid is None:
        return bool(said)
    return bool(3 * solid.bulk_modulus > 8 * solid.shear_modulus)
