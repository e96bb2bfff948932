"""What a load of a tissue offers, and what several of them share: prisms whose ends are held, or under a pressure.

A further load is one file beside this one and one line in `ngcell.scene.registry`; a script may hand over any object with
these members.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from pydantic_core import PydanticCustomError

from ngcell.geometry.bodies import LOWER_END, UPPER_END
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene.bodies import Traction
from ngcell.scene.scope import only_for_prisms, refuse

Array = NDArray[np.float64]


@runtime_checkable
class TissueLoad(Protocol):
    """What moves a tissue."""

    @property
    def supported(self) -> str | None:
        """Which outer walls it holds or moves: "plates", "frame" or none; see `ngcell.geometry.tissues.protocol`."""

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


def check_ends(ends: str | None, pressure: float | None) -> None:
    """Refuse ends of prisms that are pressed by no pressure, and a pressure on others."""
    if ends == "pressed" and pressure is None:
        raise PydanticCustomError("limit", "says not how much; allowed: with an end_pressure", {"place": ("ends",)})
    if ends != "pressed" and pressure is not None:
        allowed = 'is on ends that are not pressed; allowed: with ends = "pressed"'
        raise PydanticCustomError("limit", allowed, {"place": ("end_pressure",)})


def check_scope_of_ends(load: Any, scene: dict[str, Any]) -> None:
    """Refuse keys of prisms in a planar tissue, and a pressure on ends beside what comes before the load."""
    only_for_prisms(load, scene, "ends", "end_pressure")
    before_load = getattr(scene.get("lumen"), "before_load", None)
    if load.end_pressure is not None and before_load is not None:
        allowed = 'with empty lumens, inclusions or a lumen.pressure of ramp = "with-load"'
        refuse(f"acts beside {before_load}; allowed: {allowed}", "end_pressure")


def held_ends(space: DisplacementSpace, ends: str | None) -> list[Support]:
    """Return the supports that hold the ends of prisms along z."""
    if space.dimension == 2 or ends != "held":
        return []
    return [Support(f"{UPPER_END}|{LOWER_END}", np.zeros((3, 3)), np.zeros(3), (False, False, True))]


def end_tractions(end_pressure: float | None) -> tuple[Traction, ...]:
    """Return the forces on the ends of pressed prisms, none for others.

    They keep their direction: a pressure that followed ends with free rims would have no potential.
    """
    if end_pressure is None:
        return ()
    return Traction(UPPER_END, (0.0, 0.0, -end_pressure)), Traction(LOWER_END, (0.0, 0.0, end_pressure))
