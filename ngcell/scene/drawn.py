"""Bodies that a case file draws: rings, discs and blocks, or what a plane of symmetry leaves of them.

Here they are numbers and names; `ngcell.geometry.drawn` makes faces of them. The sides of a body have names,
``<body>_<side>``, by which supports, loads and expected numbers mean them. A further shape is one more class here, one
more name in `DrawnBody` and one more face there.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, Field, Strict, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from ngcell.scene.material import Material
from ngcell.scene.section import SECTION, ByKind, PlanarVector, PositiveNumber

Part = Literal["whole", "right", "left", "upper", "lower", "upper-right", "upper-left", "lower-right", "lower-left"]
Side = Literal["inner", "outer", "x0", "y0", "bottom", "top", "left", "right"]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]+$")]


class _UserBody(BaseModel):
    """What every drawn body says.

    Parameters
    ----------
    name : str
        Letters, digits, ``_`` and ``-``.
    material : MooneyRivlin
        What it is made of.
    size : float, optional
        Largest length of an element's edge in it, > 0; by default that of the mesh.
    walls : tuple of str, optional
        Sides that may touch other bodies; by default all but the cuts.
    """

    model_config = SECTION

    name: Name
    material: Material
    size: PositiveNumber | None = None
    walls: Annotated[tuple[Side, ...], Strict(False)] | None = None

    @property
    def sides(self) -> tuple[str, ...]:
        """Names of the sides, the cuts last."""
        raise NotImplementedError

    @property
    def cuts(self) -> tuple[str, ...]:
        """Names of the sides that lie in planes of symmetry."""
        return ()

    @property
    def boundaries(self) -> tuple[str, ...]:
        """Names of the boundaries of the mesh, in the order of the sides."""
        return tuple(f"{self.name}_{side}" for side in self.sides)

    @property
    def wall_boundaries(self) -> tuple[str, ...]:
        """Names of the boundaries that may touch other bodies."""
        walls = self.walls if self.walls is not None else [side for side in self.sides if side not in self.cuts]
        return tuple(f"{self.name}_{side}" for side in walls)

    @property
    def round_boundaries(self) -> tuple[str, ...]:
        """Names of the boundaries that are arcs of a circle."""
        return tuple(f"{self.name}_{side}" for side in self.sides if side in ("inner", "outer"))

    @model_validator(mode="after")
    def _walls_are_sides(self) -> Self:
        for number, side in enumerate(self.walls or ()):
            if side not in self.sides:
                raise PydanticCustomError(
                    "limit",
                    "is no side of it; allowed: {sides}",
                    {"sides": ", ".join(self.sides), "place": ("walls", number)},
                )
        return self


class Ring(_UserBody):
    """A ring with the sides ``inner`` and ``outer``, and ``x0``, ``y0`` where it is cut along x or y of its centre.

    Parameters
    ----------
    inner, outer : float
        Radii [length], 0 < inner < outer.
    centre : tuple of float, shape (2,)
        Where the centre is [length].
    part : str
        What is left of it: "whole", or the half or quarter on that side of the centre.
    """

    kind: Literal["ring"] = "ring"
    inner: PositiveNumber
    outer: PositiveNumber
    centre: PlanarVector = (0.0, 0.0)
    part: Part = "whole"

    @property
    def sides(self) -> tuple[str, ...]:
        """Names of the sides, the cuts last."""
        return ("inner", "outer", *self.cuts)

    @property
    def cuts(self) -> tuple[str, ...]:
        """Names of the sides that lie in planes of symmetry."""
        return _cuts(self.part)

    @field_validator("outer")
    @classmethod
    def _around_inner(cls, outer: float, info: ValidationInfo) -> float:
        if outer <= info.data.get("inner", 0.0):
            raise PydanticCustomError(
                "limit", "allowed: a radius > inner = {inner}", {"inner": f"{info.data['inner']:g}"}
            )
        return outer


class Disc(_UserBody):
    """A disc with the side ``outer``, and ``x0``, ``y0`` where it is cut along x or y of its centre.

    Parameters
    ----------
    radius : float
        Its radius [length], > 0.
    centre : tuple of float, shape (2,)
        Where the centre is [length].
    part : str
        What is left of it: "whole", or the half or quarter on that side of the centre.
    """

    kind: Literal["disc"] = "disc"
    radius: PositiveNumber
    centre: PlanarVector = (0.0, 0.0)
    part: Part = "whole"

    @property
    def sides(self) -> tuple[str, ...]:
        """Names of the sides, the cuts last."""
        return ("outer", *self.cuts)

    @property
    def cuts(self) -> tuple[str, ...]:
        """Names of the sides that lie in planes of symmetry."""
        return _cuts(self.part)


class Block(_UserBody):
    """A rectangle with the sides ``bottom``, ``top``, ``left`` and ``right``.

    Parameters
    ----------
    low, high : tuple of float, shape (2,)
        Lower left and upper right corner [length]; ``low < high`` along both axes.
    """

    kind: Literal["block"] = "block"
    low: PlanarVector
    high: PlanarVector

    @property
    def sides(self) -> tuple[str, ...]:
        """Names of the sides."""
        return ("bottom", "top", "left", "right")

    @field_validator("high")
    @classmethod
    def _beyond_low(cls, high: tuple[float, float], info: ValidationInfo) -> tuple[float, float]:
        low = info.data.get("low", high)
        if "low" in info.data and not (low[0] < high[0] and low[1] < high[1]):
            raise PydanticCustomError(
                "limit", "allowed: a corner above and to the right of low = {low}", {"low": str(list(low))}
            )
        return high


UserBody = Annotated[Ring | Disc | Block, ByKind()]


def _cuts(part: str) -> tuple[str, ...]:
    across = ("x0",) if "right" in part or "left" in part else ()
    return (*across, "y0") if "upper" in part or "lower" in part else across
