"""A rigid indenter, or a cutting wedge, that is pressed into a tissue from above."""

from __future__ import annotations

from itertools import pairwise
from math import asin, ceil, pi, radians, tan
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ngcell.errors import CaseError
from ngcell.geometry.bodies import INDENTER, LOWER_PLATE, BodyMesh
from ngcell.geometry.rigid_body import with_rigid_body
from ngcell.geometry.rounded import arcs_between
from ngcell.mechanics.applied.traction import Traction
from ngcell.mechanics.loading.load import held_sides
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.scene.levels import Levels, level_factors
from ngcell.scene.scope import is_planar, refuse
from ngcell.scene.section import PositiveNumber, Section

Array = NDArray[np.float64]

#: What each shape is told by.
_SIZES = {"flat": {"width"}, "disc": {"radius"}, "wedge": {"width", "angle"}}
#: Distance at rest between the indenter and the tissue's upper edge, as a share of the wall: they do not touch.
_CLEARANCE = 0.1
#: Elements of the indenter to a side of a cell, and the fewest of a disc.
_EDGES, _FEWEST = 4, 16


class Indenter(Section):
    """A rigid indenter without friction, pressed downwards into a planar tissue whose lower edge a plate holds.

    Parameters
    ----------
    shape : {"flat", "disc", "wedge"}
        A punch with a flat end and sharp corners, a round bar, or a wedge whose sharp edge points downwards.
    depth : float
        How far its lowest point is below the tissue's upper edge at load factor 1, a length, > 0. At rest it is a tenth
        of the wall above that edge, and moves in proportion to the load factor.
    width : float, optional
        Width of a punch, or of a wedge where it ends, > 0.
    radius : float, optional
        Radius of a disc, > 0.
    angle : float, optional
        Angle between the faces of a wedge in degrees, in (0, 180).
    place : float, optional
        Where its middle is along x; by default in the middle of the tissue.
    sides : {"free", "confined"}
        Whether the sides of the tissue are free, or between rigid walls; see `ngcell.mechanics.loading.plates.Plates`.
    levels : int or tuple of float
        Number of equal levels, or the load factors in [0, 1] that are reported, in the order of the load path.

    Notes
    -----
    The strategy is to be "single-step": cells are never tied to an indenter.
    """

    moved: ClassVar[str] = INDENTER
    #: A tied tissue would not be touched by it; in load stepping the balance of energy breaks where it first touches.
    strategies: ClassVar[tuple[str, ...]] = ("single-step",)

    kind: Literal["indenter"] = "indenter"
    shape: Literal["flat", "disc", "wedge"]
    depth: PositiveNumber
    width: PositiveNumber | None = None
    radius: PositiveNumber | None = None
    angle: Annotated[float, Field(gt=0, lt=180)] | None = None
    place: float | None = None
    sides: Literal["free", "confined"] = "free"
    levels: Levels = 10

    @property
    def supported(self) -> str:
        """Which outer walls it holds: those on the lower plate, where the tissue is confined those at its sides."""
        return "plates" if self.sides == "free" else self.sides

    @property
    def level_factors(self) -> tuple[float, ...]:
        """Load factors of the levels, in [0, 1]."""
        return level_factors(self.levels)

    @model_validator(mode="after")
    def _sizes_of_its_shape(self) -> Self:
        wanted = _SIZES[self.shape]
        for name in ("width", "radius", "angle"):
            if (getattr(self, name) is None) == (name in wanted):
                what = "is missing" if name in wanted else f"is no size of a {self.shape}"
                refuse("{what}; allowed: {names}", name, what=what, names=" and ".join(sorted(wanted)))
        return self

    def check_scope(self, scene: dict[str, Any]) -> None:
        """Refuse prisms."""
        if "tissue" in scene and not is_planar(scene):
            refuse("is for planar cells; allowed: a tissue without height", "kind")

    def with_bodies(self, bodies: BodyMesh) -> BodyMesh:
        """Return the mesh of the tissue and the indenter, in its place at rest.

        Raises
        ------
        CaseError
            If it is not above the tissue, or goes through it.
        """
        (left, low), (right, top) = bodies.extent
        place = self._place(bodies)
        if not left <= place <= right:
            raise CaseError(f"load.place = {place:g} is not above the tissue; allowed: from {left:.6g} to {right:.6g}")
        if self.depth >= top - low:
            raise CaseError(f"load.depth = {self.depth:g} is through the tissue; allowed: below {top - low:.6g}")
        outline, round_count = self._outline(bodies)
        outline += np.array([place, top + _CLEARANCE * bodies.thickness])
        if self.radius is None:
            return with_rigid_body(bodies, outline)
        centre = np.array([place, top + _CLEARANCE * bodies.thickness + self.radius])
        starts, ends = outline[:round_count], np.roll(outline, -1, axis=0)[:round_count]
        return with_rigid_body(bodies, outline, arcs_between(starts, ends, centre, self.radius))

    def motion(self, space: DisplacementSpace) -> PrescribedMotion:
        """Return the motion: the indenter moves down, and the lower plate stays where it is."""
        still, moved = np.zeros((2, 2)), self.prescribed_displacement(space)
        supports = [Support(LOWER_PLATE, still, np.zeros(2)), Support(INDENTER, still, moved)]
        return IndenterMotion(space, [*held_sides(space, self.sides), *supports], moved)

    def prescribed_displacement(self, space: DisplacementSpace) -> Array:
        """Return the displacement of the indenter at load factor 1 [length]."""
        return np.array([0.0, -self.depth - _CLEARANCE * space.bodies.thickness])

    def tractions(self) -> tuple[Traction, ...]:
        """Return no forces."""
        return ()

    @property
    def _slope(self) -> float:
        return 0.0 if self.angle is None else 1 / tan(radians(self.angle) / 2)

    def _place(self, bodies: BodyMesh) -> float:
        return float(bodies.extent[:, 0].mean()) if self.place is None else self.place

    def _outline(self, bodies: BodyMesh) -> tuple[Array, int]:
        """Return the nodes of its outline, anticlockwise about its lowest point (0, 0) [length], shape (nodes, 2), and
        from how many of them, the first ones, it goes on to the next along an arc."""
        size, deepest = bodies.length / _EDGES, self.depth + 2 * bodies.length
        farthest = 2 * float(np.diff(bodies.extent[:, 0]).item())  # wider ones are cut where they touch nothing
        if self.radius is not None:
            if self.radius > farthest:
                return _segment(self.radius, min(farthest / self.radius, 0.9), size, bodies.length)
            angle = 2 * pi * np.arange(count := max(_FEWEST, ceil(2 * pi * self.radius / size))) / count
            return self.radius * np.column_stack([np.sin(angle), 1 - np.cos(angle)]), count
        half = min((self.width or 0) / 2, farthest)
        if half * self._slope > deepest:
            half = deepest / self._slope
        foot = half * self._slope
        head = foot + self.depth + bodies.length
        tip = [(0.0, 0.0)] if self.shape == "wedge" else []
        corners = np.array([*tip, (half, foot), (half, head), (-half, head), (-half, foot)])
        return _divided(corners, size), 0


class IndenterMotion(PrescribedMotion):
    """The indenter moves down as a whole. There is no lifting: cells start from where they were.

    Parameters
    ----------
    space : DisplacementSpace
        The unknowns.
    supports : sequence of Support
        The plate, the sides and the indenter.
    translation : array of float, shape (2,)
        Displacement of the indenter at load factor 1 [length].
    """

    def __init__(self, space: DisplacementSpace, supports: list[Support], translation: Array) -> None:
        super().__init__(space, supports)
        rigid = space.body_of_unknown >= space.bodies.cell_count
        self.fixed[:, rigid] = True
        self._final[:, rigid] = translation[:, None] * space.one[rigid]


def _segment(radius: float, share: float, size: float, above: float) -> tuple[Array, int]:
    """Return the nodes of the lower part of a disc, up to this share of its radius on either side, and of a block on
    it, so far above its ends [length], and how many elements of the disc there are."""
    half = asin(share)
    angle = np.linspace(-half, half, 1 + ceil(2 * half * radius / size))
    arc = radius * np.column_stack([np.sin(angle), 2 * np.sin(angle / 2) ** 2])
    ends = np.array([arc[-1], arc[-1] + [0.0, above], arc[0] + [0.0, above], arc[0]])
    around = [_line(start, end, size) for start, end in pairwise(ends)]
    return np.concatenate([arc[:-1], *around]), len(arc) - 1


def _divided(corners: Array, size: float) -> Array:
    """Return the nodes of a closed line with these corners, at most so far from each other [length]."""
    return np.concatenate(
        [_line(start, end, size) for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    )


def _line(start: Array, end: Array, size: float) -> Array:
    """Return the nodes from one point to another, which is left out, at most so far from each other [length]."""
    count = ceil(float(np.linalg.norm(end - start)) / size)
    return np.asarray(start + (end - start) * (np.arange(count) / count)[:, None])
