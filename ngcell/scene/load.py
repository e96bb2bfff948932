"""What moves the tissue."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BaseModel, BeforeValidator, Field, Strict, model_validator
from pydantic_core import PydanticCustomError

from ngcell.scene.scope import is_planar, only_for_prisms, refuse
from ngcell.scene.section import SECTION, PlanarVector, PositiveNumber

#: More levels than this are a typing error; steps between them are chosen by the solver anyway.
MOST_LEVELS = 1000

Gradient = tuple[tuple[float, float], tuple[float, float]]


def _levels(value: Any) -> int | tuple[float, ...]:
    """Return a number of levels, or the load factors themselves, as they were given but checked."""
    if type(value) is int and 1 <= value <= MOST_LEVELS:
        return value
    if isinstance(value, (list, tuple)) and all(type(factor) in (int, float) for factor in value):
        factors = tuple(float(factor) for factor in value)
        # Written so that a NaN, for which every comparison is false, is refused as well.
        if factors and all(0 <= to <= 1 and before != to for before, to in pairwise((0.0, *factors))):
            return factors
    raise PydanticCustomError(
        "limit",
        "allowed: a whole number from 1 to {most} of equal levels, "
        "or a list of load factors in [0, 1], each other than the one before it",
        {"most": MOST_LEVELS},
    )


LevelCount = Annotated[int, Field(ge=1, le=MOST_LEVELS)]
LoadFactors = Annotated[tuple[Annotated[float, Field(ge=0, le=1)], ...], Strict(False)]
Levels = Annotated[LevelCount | LoadFactors, BeforeValidator(_levels)]


class Plates(BaseModel):
    """Two plates: the outer walls that face down are held, those that face up are moved, the sides are free.

    Exactly one of `displacement` and `stretch` is given.

    Parameters
    ----------
    displacement : tuple of float, shape (2,), optional
        Displacement of the upper plate at load factor 1, a length.
    stretch : float, optional
        Distance of the plates at load factor 1 over the distance at rest, > 0.
    ends : {"free", "held", "pressed"}, optional
        Whether the ends of prisms are free, as by default, held along z, as in plane strain, or under a pressure.
    end_pressure : float, optional
        Force on both ends of pressed prisms per reference area, a stress, inwards along z whichever way the ends
        turn; it grows with the load. Below 0 it pulls.
    levels : int or tuple of float
        Number of equal levels, or the load factors in [0, 1] that are reported, in the order of the load path;
        it may return, as in ``[0.5, 1.0, 0.5, 0.0]``.
    """

    model_config = SECTION

    #: Which outer walls of the tissue it holds or moves.
    supported: ClassVar[str | None] = "plates"

    kind: Literal["plates"] = "plates"
    displacement: PlanarVector | None = None
    stretch: PositiveNumber | None = None
    ends: Literal["free", "held", "pressed"] | None = None
    end_pressure: float | None = None
    levels: Levels = 10

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1], in the order of the load path."""
        return level_factors(self.levels)

    @model_validator(mode="after")
    def _one_motion(self) -> Self:
        _require_one(displacement=self.displacement, stretch=self.stretch)
        return self

    @model_validator(mode="after")
    def _ends_under_a_pressure(self) -> Self:
        _check_ends(self.ends, self.end_pressure)
        return self

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse keys of prisms in a planar tissue, and a pressure on ends beside what comes before the load."""
        _check_scope_of_ends(self, scene)


class Frame(BaseModel):
    """A frame: all outer walls follow one affine deformation.

    Exactly one of `deformation_gradient`, `stretch` and `shear` is given.

    Parameters
    ----------
    deformation_gradient : tuple of tuple of float, shape (2, 2), optional
        Deformation gradient at load factor 1, without unit. It is reached along the straight line from
        the identity, on which its determinant stays positive.
    stretch : tuple of float, shape (2,), optional
        Stretches along x and y at load factor 1, each > 0.
    shear : float, optional
        Simple shear at load factor 1: displacement along x over height.
    ends : {"free", "held", "pressed"}, optional
        Whether the ends of prisms are free, as by default, held along z, as in plane strain, or under a pressure.
    end_pressure : float, optional
        Force on both ends of pressed prisms per reference area, a stress, inwards along z whichever way the ends
        turn; it grows with the load. Below 0 it pulls.
    levels : int or tuple of float
        Number of equal levels, or the load factors in [0, 1] that are reported, in the order of the load path;
        it may return, as in ``[0.5, 1.0, 0.5, 0.0]``.
    """

    model_config = SECTION

    #: Which outer walls of the tissue it holds or moves.
    supported: ClassVar[str | None] = "frame"

    kind: Literal["frame"] = "frame"
    deformation_gradient: Annotated[tuple[PlanarVector, PlanarVector], Strict(False)] | None = None
    stretch: Annotated[tuple[PositiveNumber, PositiveNumber], Strict(False)] | None = None
    shear: float | None = None
    ends: Literal["free", "held", "pressed"] | None = None
    end_pressure: float | None = None
    levels: Levels = 10

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1], in the order of the load path."""
        return level_factors(self.levels)

    @property
    def final_gradient(self) -> Gradient:
        """Deformation gradient at load factor 1, shape (2, 2), whichever way the load was given."""
        if self.deformation_gradient is not None:
            return self.deformation_gradient
        stretch_x, stretch_y = self.stretch or (1.0, 1.0)
        return (stretch_x, self.shear or 0.0), (0.0, stretch_y)

    @model_validator(mode="after")
    def _one_deformation(self) -> Self:
        _require_one(deformation_gradient=self.deformation_gradient, stretch=self.stretch, shear=self.shear)
        return self

    @model_validator(mode="after")
    def _ends_under_a_pressure(self) -> Self:
        _check_ends(self.ends, self.end_pressure)
        return self

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse keys of prisms in a planar tissue, and a pressure on ends beside what comes before the load."""
        _check_scope_of_ends(self, scene)

    @model_validator(mode="after")
    def _keeps_orientation(self) -> Self:
        smallest = _smallest_determinant(self.final_gradient)
        if smallest <= 0:
            raise PydanticCustomError(
                "limit",
                "turns the frame inside out, its determinant falls to {smallest} on the way; "
                "allowed: a determinant > 0 along the line from the identity to it",
                {"smallest": f"{smallest:.6g}", "place": ("deformation_gradient",)},
            )
        return self


class Ends(BaseModel):
    """The ends of prisms: those at the back are held, those at the front move together as one rigid plate.

    Parameters
    ----------
    twist : float
        Angle by which the front is turned about the tissue's axis at load factor 1, in degrees, in (-180, 180). On the
        way points go straight to where they end.
    bend : float
        Angle by which the front is tilted towards x at load factor 1, in degrees, in (-180, 180). Its centre goes to
        where the tissue's axis ends when it is bent to a circular arc of its own length.
    displacement : tuple of float, shape (3,)
        Displacement of the front at load factor 1, besides that of twist and bend; a length.
    levels : int or tuple of float
        Number of equal levels, or the load factors in [0, 1] that are reported.
    """

    model_config = SECTION

    #: Which outer walls of the tissue it holds or moves.
    supported: ClassVar[str | None] = None

    kind: Literal["ends"] = "ends"
    twist: Annotated[float, Field(gt=-180, lt=180)] = 0.0
    bend: Annotated[float, Field(gt=-180, lt=180)] = 0.0
    displacement: Annotated[tuple[float, float, float], Strict(False)] = (0.0, 0.0, 0.0)
    levels: Levels = 10

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1]."""
        return level_factors(self.levels)

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse a planar tissue, which has no ends."""
        if is_planar(scene):
            refuse("is for prisms; allowed: only beside tissue.height", "kind")


def level_factors(levels: int | tuple[float, ...]) -> tuple[float, ...]:
    """Return the load factors of the levels, in [0, 1], in the order of the load path."""
    return tuple((n + 1) / levels for n in range(levels)) if isinstance(levels, int) else levels


def _require_one(**choices: object) -> None:
    given = [name for name, value in choices.items() if value is not None]
    if len(given) != 1:
        raise PydanticCustomError(
            "limit",
            "{given}; allowed: exactly one of {names}",
            {
                "given": f"both {' and '.join(given)} are given" if given else "nothing says how far to go",
                "names": ", ".join(choices),
            },
        )


def _check_ends(ends: str | None, pressure: float | None) -> None:
    if ends == "pressed" and pressure is None:
        raise PydanticCustomError("limit", "says not how much; allowed: with an end_pressure", {"place": ("ends",)})
    if ends != "pressed" and pressure is not None:
        allowed = 'is on ends that are not pressed; allowed: with ends = "pressed"'
        raise PydanticCustomError("limit", allowed, {"place": ("end_pressure",)})


def _check_scope_of_ends(load: Plates | Frame, scene: dict[str, Any]) -> None:
    only_for_prisms(load, scene, "ends", "end_pressure")
    before_load = getattr(scene.get("lumen"), "before_load", None)
    if load.end_pressure is not None and before_load is not None:
        allowed = 'with empty lumens, inclusions or a lumen.pressure of ramp = "with-load"'
        refuse(f"acts beside {before_load}; allowed: {allowed}", "end_pressure")


def _smallest_determinant(gradient: Gradient) -> float:
    """Return the smallest of ``det(I + s (F - I))`` over s in [0, 1], a parabola in s."""
    (xx, xy), (yx, yy) = gradient
    slope = (xx - 1) + (yy - 1)
    bend = (xx - 1) * (yy - 1) - xy * yx
    exterior_angle = [s for s in [-slope / (2 * bend)] if 0 < s < 1] if bend > 0 else []
    return min(1 + slope * s + bend * s * s for s in (0.0, 1.0, *exterior_angle))
