"""What walls do to each other. A further way is one more class here and one more name in `Contact`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel

from ngcell.scene.section import SECTION, ByKind, PositiveNumber


class Penalty(BaseModel):
    """Frictionless unilateral contact by a penalty on the overlap.

    Parameters
    ----------
    stiffness : float
        Multiple of the penalty stiffness that is derived from material and mesh, > 0, without unit.
    """

    model_config = SECTION

    kind: Literal["penalty"] = "penalty"
    stiffness: PositiveNumber = 1.0


class Mortar(BaseModel):
    """Frictionless unilateral contact by a mortar method: the contact pressure is an unknown, walls do not overlap."""

    model_config = SECTION

    kind: Literal["mortar"] = "mortar"


Contact = Annotated[Penalty | Mortar, ByKind(default="penalty")]
