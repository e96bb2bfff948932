"""What a load of a tissue offers, and what several of them share: prisms whose ends are held, or under a pressure.

A further load is one file beside this one and one line in `ngcell.scene.registry`; a script may hand over any object
with these members.
"""

from __future__ import annotations

from typing import Any, Literal, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator
from pydantic_core import PydanticCustomError

from ngcell.errors import CaseError
from ngcell.geometry.bodies import LEFT_SIDE, LOWER_END, RIGHT_SIDE, UPPER_END, BodyMesh
from ngcell.mechanics.applied.traction import Traction
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene.levels import Levels, level_factors
from ngcell.scene.scope import are_open_prisms, only_for_prisms, refuse
from ngcell.scene.section import Section

Array = NDArray[np.float64]


@runtime_checkable
class TissueLoad(Protocol):
    """What moves a tissue."""

    @property
    def supported(self) -> str | None:
        """Which outer walls it holds or moves: "plates", "confined", "frame" or none; see
        `ngcell.geometry.tissues.protocol`."""

    @property
    def moved(self) -> str:
        """Region whose force and displacement are reported, a regular expression."""

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1], in the order of the load path."""

    def motion(self, space: DisplacementSpace) -> PrescribedMotion:
        """Return what is prescribed."""

    def prescribed_displacement(self, space: DisplacementSpace) -> Array:
        """Return the displacement of the moved region at load factor 1 [length], shape (dimension,)."""

    def tractions(self) -> tuple[Traction, ...]:
        """Return the forces that it exerts besides."""


class EndsOfPrisms(Section):
    """What loads in the plane say of prisms, whose ends are free, held, under a pressure, or in a plane of symmetry.

    Parameters
    ----------
    kind : str
        The kind of load.
    ends : {"free", "held", "mirrored", "pressed"}, optional
        Whether the ends of prisms are free, as by default, held along z, as in plane strain, or under a pressure. Of
        mirrored prisms the lower ends are held along z, and the upper ones are free: they are one half of prisms twice
        as high whose ends are free, in a state that is symmetric about the plane between both halves.
    end_pressure : float, optional
        Force on both ends of pressed prisms per reference area, a stress, inwards along z whichever way the ends
        turn; it grows with the load. Below 0 it pulls.
    levels : int or tuple of float
        Number of equal levels, or the load factors in [0, 1] that are reported, in the order of the load path;
        it may return, as in ``[0.5, 1.0, 0.5, 0.0]``.
    """

    kind: str
    ends: Literal["free", "held", "mirrored", "pressed"] | None = None
    end_pressure: float | None = None
    levels: Levels = 10

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1], in the order of the load path."""
        return level_factors(self.levels)

    @model_validator(mode="after")
    def _pressed_by_a_pressure(self) -> Self:
        if self.ends == "pressed" and self.end_pressure is None:
            refuse("says not how much; allowed: with an end_pressure", "ends")
        if self.ends != "pressed" and self.end_pressure is not None:
            refuse('is on ends that are not pressed; allowed: with ends = "pressed"', "end_pressure")
        return self

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse keys of prisms in a planar tissue, free ends beside a pressure in open prisms, and a pressure on ends
        beside what comes before the load."""
        only_for_prisms(self, scene, "ends", "end_pressure")
        if self.ends == "mirrored" and getattr(scene.get("tissue"), "end_wall", None) is not None:
            refuse("has a tissue.end_wall between both halves; allowed: without one", "ends")
        if are_open_prisms(scene) and self.ends != "held" and getattr(scene.get("lumen"), "needs_held_ends", False):
            refuse('leaves rims free beside a lumen.pressure; allowed: "held", or a tissue.end_wall', "ends")
        before_load = getattr(scene.get("lumen"), "before_load", None)
        if self.end_pressure is not None and before_load is not None:
            allowed = 'with empty lumens, inclusions or a lumen.pressure of ramp = "with-load"'
            refuse(f"acts beside {before_load}; allowed: {allowed}", "end_pressure")

    def held_ends(self, space: DisplacementSpace) -> list[Support]:
        """Return the supports that hold the ends of prisms along z."""
        held = {"held": f"{UPPER_END}|{LOWER_END}", "mirrored": LOWER_END}.get(self.ends or "free")
        if held is None:  # which planar cells refuse, see `check_scope`
            return []
        return [Support(held, np.zeros((3, 3)), np.zeros(3), (False, False, True))]

    def tractions(self) -> tuple[Traction, ...]:
        """Return the forces on the ends of pressed prisms, none for others.

        They keep their direction: a pressure that followed ends with free rims would have no potential.
        """
        if self.end_pressure is None:
            return ()
        ends = ((UPPER_END, -self.end_pressure), (LOWER_END, self.end_pressure))
        return tuple(Traction(boundary=end, vector=(0.0, 0.0, along)) for end, along in ends)


def with_bodies_of(load: TissueLoad, bodies: BodyMesh) -> BodyMesh:
    """Return the mesh of a tissue and of the bodies that its load brings: those that a method ``with_bodies`` adds."""
    add = getattr(load, "with_bodies", None)
    found: BodyMesh = bodies if add is None else add(bodies)
    return found


def motion_of(load: TissueLoad, space: DisplacementSpace, *, keeps_volume: bool) -> PrescribedMotion:
    """Return what a load prescribes; for cells that keep their volume by its method ``motion_at_constant_volume``,
    which takes the space, if there is one."""
    steady = getattr(load, "motion_at_constant_volume", None) if keeps_volume else None
    found: PrescribedMotion = (steady or load.motion)(space)
    return found


def held_sides(space: DisplacementSpace, sides: str) -> list[Support]:
    """Return the supports of confined sides, which keep their place along x; none of free ones.

    Raises
    ------
    CaseError
        If a tissue of a script has no such sides.
    """
    if sides == "free":
        return []
    dimension, along_x = space.dimension, (True, *(False,) * (space.dimension - 1))
    for side in (LEFT_SIDE, RIGHT_SIDE):
        if not len(space.region_unknowns(side)):
            raise CaseError(f'load.sides: the tissue has no region "{side}" to hold; allowed: free sides')
    still = np.zeros((dimension, dimension))
    return [Support(f"{LEFT_SIDE}|{RIGHT_SIDE}", still, np.zeros(dimension), along_x)]


def check_one_given(**choices: object) -> None:
    """Refuse a load that says its motion twice, or not at all."""
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
