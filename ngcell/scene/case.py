"""A case: everything that a simulation is told, and nothing that it works out."""

from __future__ import annotations

from math import isclose
from typing import Annotated, Any

from pydantic import BaseModel, Strict, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from ngcell.scene.cohesion import Cohesion, check_company
from ngcell.scene.contact import Contact, Penalty
from ngcell.scene.expected import Expected
from ngcell.scene.load import Ends, Load
from ngcell.scene.lumen import CellPressure, Fluid, Inclusion, Lumen
from ngcell.scene.material import Material
from ngcell.scene.mesh import MeshChoice
from ngcell.scene.section import SECTION
from ngcell.scene.strategy import Sddp, Strategy
from ngcell.scene.tissue import Tissue


class Case(BaseModel):
    """One scene, how it is loaded and how it is to be solved.

    Lengths are in the unit of `Tissue.side`, stresses in the unit of the material's constants; every
    other unit follows from these two.

    Parameters
    ----------
    title : str
        One line that says what happens.
    source : str
        Where the scene comes from.
    tissue : Tissue
        The cells.
    material : MooneyRivlin
        What their walls are made of.
    lumen : CellPressure, Inclusion or Fluid, optional
        What the cells hold; by default they are empty.
    load : Plates, Frame or Ends
        What moves them.
    strategy : Sddp or SingleStep
        How the load path is followed.
    contact : Penalty or Mortar
        What walls do to each other.
    cohesion : Cohesion, optional
        What holds walls together; by default nothing does.
    mesh : MeshChoice
        How finely the walls are resolved.
    expected : tuple of Expected
        Numbers that the case is held to.
    """

    model_config = SECTION

    title: str = ""
    source: str = ""
    tissue: Tissue
    material: Material
    lumen: Lumen | None = None
    load: Load
    strategy: Strategy = Sddp()
    contact: Contact = Penalty()
    cohesion: Cohesion | None = None
    mesh: MeshChoice = MeshChoice()
    expected: Annotated[tuple[Expected, ...], Strict(False)] = ()

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1], in the order of the load path."""
        return self.load.level_factors

    @property
    def smallest_step_count(self) -> int:
        """Smallest number of load steps: what the strategy asks for, else one for each level."""
        return self.strategy.steps or len(self.load.level_factors)

    @field_validator("material", "lumen", "load", "contact", "cohesion", "mesh")
    @classmethod
    def _for_prisms_only(cls, value: Any, info: ValidationInfo) -> Any:
        tissue = info.data.get("tissue")
        if tissue is None or tissue.height is not None:
            return value
        for place, is_there in _of_prisms(value).items():
            if is_there:
                raise PydanticCustomError(
                    "limit", "is for prisms; allowed: only beside tissue.height", {"place": (place,)}
                )
        return value

    @field_validator("material")
    @classmethod
    def _along_walls(cls, material: Material) -> Material:
        if material.fibres is not None and material.fibres.direction is not None:
            raise PydanticCustomError(
                "limit",
                "is that of the wall in a tissue; allowed: no direction, or angles from the wall's",
                {"place": ("fibres", "direction")},
            )
        return material

    @field_validator("lumen")
    @classmethod
    def _keeps_fluids(cls, lumen: Lumen | None, info: ValidationInfo) -> Lumen | None:
        tissue = info.data.get("tissue")
        if tissue is None or tissue.height is None or tissue.end_wall is not None:
            return lumen
        closed = "allowed: closed ones, with a tissue.end_wall"
        if isinstance(lumen, Fluid):
            raise PydanticCustomError("limit", f"flows out of hollow prisms; {closed}", {"place": ("kind",)})
        if isinstance(lumen, CellPressure) and tissue.layers > 1:
            escapes = f"escapes between layers of hollow prisms; {closed}"
            raise PydanticCustomError("limit", escapes, {"place": ("kind",)})
        return lumen

    @field_validator("lumen")
    @classmethod
    def _without_fibres(cls, lumen: Lumen | None) -> Lumen | None:
        if isinstance(lumen, Inclusion) and lumen.material.fibres is not None:
            raise PydanticCustomError(
                "limit",
                "run along walls, which a lumen has none of; allowed: no fibres in an inclusion",
                {"place": ("material", "fibres")},
            )
        return lumen

    @field_validator("lumen")
    @classmethod
    def _for_every_cell(cls, lumen: Lumen | None, info: ValidationInfo) -> Lumen | None:
        tissue = info.data.get("tissue")
        if tissue is None or not isinstance(lumen, CellPressure) or not isinstance(lumen.pressure, tuple):
            return lumen
        rows = tissue.rows * tissue.layers
        if [len(row) for row in lumen.pressure] != [tissue.cols] * rows:
            raise PydanticCustomError(
                "limit",
                "allowed: one pressure, or {rows} rows of {cols}, as many as there are cells",
                {"place": ("pressure",), "rows": rows, "cols": tissue.cols},
            )
        return lumen

    @field_validator("load")
    @classmethod
    def _grows_with_all_else(cls, load: Load, info: ValidationInfo) -> Load:
        lumen = info.data.get("lumen")
        if getattr(load, "end_pressure", None) is None or lumen is None or isinstance(lumen, Inclusion):
            return load
        if isinstance(lumen, Fluid) or lumen.ramp == "first":
            what = "fluids in lumens" if isinstance(lumen, Fluid) else "a lumen.pressure that comes first"
            with_load = 'a lumen.pressure of ramp = "with-load"'
            allowed = f"acts beside {what}; allowed: with empty lumens, inclusions or {with_load}"
            raise PydanticCustomError("limit", allowed, {"place": ("end_pressure",)})
        return load

    @field_validator("cohesion")
    @classmethod
    def _with_this_contact(cls, cohesion: Cohesion | None, info: ValidationInfo) -> Cohesion | None:
        return check_company(cohesion, info.data.get("contact"), info.data.get("lumen"))

    @field_validator("expected")
    @classmethod
    def _at_reported_levels(cls, expected: tuple[Expected, ...], info: ValidationInfo) -> tuple[Expected, ...]:
        reported = info.data["load"].level_factors if "load" in info.data else ()
        for number, entry in enumerate(expected if reported else ()):
            if not any(isclose(entry.level, factor) for factor in reported):
                raise PydanticCustomError(
                    "limit",
                    "is not reported; allowed: a level of the load ({reported})",
                    {
                        "place": (number, "level"),
                        "reported": ", ".join(f"{factor:g}" for factor in reported),
                    },
                )
        return expected


def _of_prisms(value: Any) -> dict[str, bool]:
    """Return what of a part of a case only prisms have, by place, and whether it is there."""
    given = {name: getattr(value, name, None) is not None for name in ("ends", "slices", "end_pressure")}
    return {**given, "kind": isinstance(value, Ends)}
