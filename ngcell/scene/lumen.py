"""What the cells hold. Without this table they are hollow and empty, and nothing is built for it."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, Strict, field_validator

from ngcell.scene.choice import OneOf
from ngcell.scene.scope import is_planar, refuse
from ngcell.scene.section import SECTION, NonNegativeNumber, PositiveNumber

_CLOSED = "allowed: closed ones, with a tissue.end_wall"

Row = Annotated[tuple[NonNegativeNumber, ...], Strict(False)]


class CellPressure(BaseModel):
    """A pressure in every cell, which acts on its wall as it deforms.

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

    @property
    def before_load(self) -> str | None:
        """What is there in full before the load, in words; None where it grows with the load."""
        return "a lumen.pressure that comes first" if self.ramp == "first" else None

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse hollow layers, and another number of pressures than there are cells."""
        tissue = scene.get("tissue")
        if tissue is None:
            return
        if not is_planar(scene) and tissue.end_wall is None and tissue.layers > 1:
            refuse(f"escapes between layers of hollow prisms; {_CLOSED}", "kind")
        rows, cols = tissue.grid
        if isinstance(self.pressure, tuple) and [len(row) for row in self.pressure] != [cols] * rows:
            allowed = "allowed: one pressure, or {rows} rows of {cols}, as many as there are cells"
            refuse(allowed, "pressure", rows=rows, cols=cols)


class Inclusion(BaseModel):
    """A solid that fills every cell and is bonded to its wall.

    Parameters
    ----------
    material : MooneyRivlin
        What it is made of: as a rule softer than the wall, and nearly incompressible.
    """

    model_config = SECTION

    kind: Literal["inclusion"] = "inclusion"
    material: Annotated[Any, OneOf("material")]

    @field_validator("material")
    @classmethod
    def _without_fibres(cls, material: Any) -> Any:
        if material.fibres is not None:
            refuse("run along walls, which a lumen has none of; allowed: no fibres in an inclusion", "fibres")
        return material


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
    goes_with_cohesion: ClassVar[bool] = False

    @property
    def before_load(self) -> str | None:
        """What is there in full before the load, in words."""
        return "fluids in lumens"

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse prisms that are open at their ends."""
        if "tissue" in scene and not is_planar(scene) and scene["tissue"].end_wall is None:
            refuse(f"flows out of hollow prisms; {_CLOSED}", "kind")
