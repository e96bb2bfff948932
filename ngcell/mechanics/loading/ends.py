"""Ends of prisms that are moved, turned against each other and tilted.

Angles and displacement grow in proportion to the load factor, so an end that turns keeps its size on the way: its
displacement does not grow in proportion.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict

from ngcell.geometry.bodies import LOWER_END, UPPER_END
from ngcell.mechanics.applied.traction import Traction
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene.levels import Levels, level_factors
from ngcell.scene.scope import is_planar, refuse
from ngcell.scene.section import Section

Array = NDArray[np.float64]

#: Half of the change of load factor from which the rate of the motion is taken: its error is the square of this.
_NEARBY = 1e-4


class Ends(Section):
    """The ends of prisms: the lower ones are held, the upper ones move together as one rigid plate.

    Parameters
    ----------
    twist : float
        Angle by which the upper end is turned about the tissue's axis at load factor 1, in degrees, in (-180, 180).
    bend : float
        Angle by which the upper end is tilted towards x at load factor 1, in degrees, in (-180, 180). Its centre goes
        to where the tissue's axis ends when it is bent to a circular arc of its own length.
    displacement : tuple of float, shape (3,)
        Displacement of the upper end at load factor 1, besides that of twist and bend; a length.
    levels : int or tuple of float
        Number of equal levels, or the load factors in [0, 1] that are reported.
    """

    supported: ClassVar[str | None] = None
    moved: ClassVar[str] = UPPER_END

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

    def motion(self, space: DisplacementSpace) -> PrescribedMotion:
        """Return the motion."""
        return EndsMotion(space, self)

    def prescribed_displacement(self, space: DisplacementSpace) -> Array:
        """Return the displacement of the upper end at load factor 1 [length], besides that of twist and bend."""
        return np.array(self.displacement)

    def tractions(self) -> tuple[Traction, ...]:
        """Return no forces."""
        return ()


class EndsMotion(PrescribedMotion):
    """The lower end is held and the upper one moves rigidly; in between, the lifting moves, twists and tilts sections
    in proportion to their height.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    load : Ends
        Twist, bend and displacement at load factor 1.
    """

    def __init__(self, space: DisplacementSpace, load: Ends) -> None:
        self._load = load
        (low, high), still = space.bodies.extent, np.zeros((3, 3))
        self._foot = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
        self._length = float(high[2] - low[2])
        ends = [Support(end, still, np.zeros(3), (True,) * 3) for end in (LOWER_END, UPPER_END)]
        super().__init__(space, ends, lambda at: self._section(at, 1.0))
        self._upper_end = space.region_unknowns(UPPER_END)

    def imposed(self, displacement: Array, load_factor: float) -> Array:
        """Return a displacement with the prescribed values of this load factor in place."""
        moved = super().imposed(displacement, load_factor).reshape(self.fixed.shape)
        moved[:, self._upper_end] = self._of_upper_end(load_factor)
        return moved.ravel()

    def lifting(self, load_factor: float) -> Array:
        """Return the lifting at this load factor, shape (unknowns,)."""
        return self.imposed(self._section(self._space.rest, load_factor) * self._space.one, load_factor)

    def rate(self, load_factor: float) -> Array:
        """Return the prescribed values' derivative by the load factor, shape (unknowns,); zero where nothing is."""
        rate = np.zeros(self.fixed.shape)
        later, before = (self._of_upper_end(load_factor + change) for change in (_NEARBY, -_NEARBY))
        rate[:, self._upper_end] = (later - before) / (2 * _NEARBY)
        return rate.ravel()

    def _of_upper_end(self, load_factor: float) -> Array:
        """Return the displacement of the upper end, which is rigid, as unknowns."""
        tilt, twist, prescribed_displacement = self._at(load_factor)
        turned = _about_y(tilt) @ _about_z(twist)
        upper_end = self._foot + [0.0, 0.0, self._length]
        moved = self._foot + _arc(tilt, np.ones(1), self._length)[:, 0] + prescribed_displacement
        return self._space.affine(turned - np.eye(3), moved - turned @ upper_end)[:, self._upper_end]

    def _section(self, at: Array, load_factor: float) -> Array:
        """Return the displacement of reference positions with their sections, both of shape (3, n)."""
        tilt, twist, prescribed_displacement = self._at(load_factor)
        away = at - self._foot[:, None]
        share, across = away[2] / self._length, away * [[1.0], [1.0], [0.0]]
        turn = twist * share
        x, y = np.cos(turn) * across[0] - np.sin(turn) * across[1], np.sin(turn) * across[0] + np.cos(turn) * across[1]
        tilted = np.array([np.cos(tilt * share) * x, y, -np.sin(tilt * share) * x])
        centre = self._foot[:, None] + _arc(tilt, share, self._length)
        return np.asarray(centre + tilted - at + share * prescribed_displacement[:, None])

    def _at(self, load_factor: float) -> tuple[float, float, Array]:
        """Return tilt and twist [rad] and displacement [length]."""
        load = self._load
        tilt, twist = (load_factor * float(np.radians(angle)) for angle in (load.bend, load.twist))
        return tilt, twist, load_factor * np.array(load.displacement)


def _arc(tilt: float, share: Array, length: float) -> Array:
    """Return points at shares of a circular arc in the x-z plane that starts along z and ends tilted, shape (3, n)."""
    # np.sinc(x) is sin(pi x) / (pi x): an arc without tilt is straight.
    half = tilt * share / 2
    chord = length * share * np.sinc(half / np.pi)
    return np.array([chord * np.sin(half), np.zeros_like(share), chord * np.cos(half)])


def _about_z(angle: float) -> Array:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _about_y(angle: float) -> Array:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
