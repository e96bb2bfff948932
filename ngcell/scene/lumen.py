"""What the cells hold. Without this table they are hollow and empty, and nothing is built for it.

A further filling is one more class here and one more name in `Lumen`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Strict

from ngcell.scene.material import Material
from ngcell.scene.section import SECTION, ByKind, NonNegativeNumber, PositiveNumber

Row = Annotated[tuple[NonNegativeNumber, ...], Strict(False)]


class CellPressure(BaseModel):
    """A pressure in every cell, which pushes on its wall as it deforms.

    Parameters
    ----------
    pressure : float or tuple of tuple of float, shape (rows, cols)
        Pressure at load factor 1, a stress, >= 0: the same in all cells, or that of each, the lowest row first; the
        rows of further layers of prisms follow.
    ramp : {"with-load", "first"}
        Whether it grows in proportion to the load, or is there in full at every level.
    """

    model_config = SECTION

    kind: Literal["pressure"] = "pressure"
    pressure: NonNegativeNumber | Annotated[tuple[Row, ...], Strict(False)]
    ramp: Literal["with-load", "first"] = "with-load"


class Inclusion(BaseModel):
    """A solid that fills every cell and is bonded to its wall.

    Parameters
    ----------
    material : MooneyRivlin
        What it is made of: as a rule softer than the wall, and nearly incompressible.
    """

    model_config = SECTION

    kind: Literal["inclusion"] = "inclusion"
    material: Material


class Fluid(BaseModel):
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

    model_config = SECTION

    kind: Literal["fluid"] = "fluid"
    fill: PositiveNumber = 1.0
    ramp: Literal["with-load", "first"] = "with-load"


Lumen = Annotated[CellPressure | Inclusion | Fluid, ByKind()]
