"""What the walls are made of. A further law is one more class here and one more name in `Material`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel

from ngcell.scene.section import SECTION, ByKind, NonNegativeNumber, PositiveNumber


class MooneyRivlin(BaseModel):
    """Mooney-Rivlin solid, ``W = c1/2 (I1 - 3) + c2/2 (I2 - 3)`` of the isochoric part, made compressible.

    Parameters
    ----------
    c1 : float
        First constant, a stress, > 0. The shear modulus at rest is ``c1 + c2``.
    c2 : float
        Second constant, a stress, >= 0; 0 is the neo-Hookean solid.
    bulk_modulus : float
        Modulus of the volumetric energy ``bulk_modulus/2 (ln J)**2``, a stress, > 0.
    """

    model_config = SECTION

    kind: Literal["mooney-rivlin"] = "mooney-rivlin"
    c1: PositiveNumber
    c2: NonNegativeNumber
    bulk_modulus: PositiveNumber


Material = Annotated[MooneyRivlin, ByKind()]
