"""A ring, or what planes of symmetry leave of it."""

from __future__ import annotations

from math import pi
from typing import Literal

from netgen import occ
from pydantic import ValidationInfo, field_validator

from ngcell.geometry.user_bodies.body import Part, Point, UserBody, cuts_of, named_face, part_of
from ngcell.scene.scope import refuse
from ngcell.scene.section import PlanarVector, PositiveNumber


class Ring(UserBody):
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
        return cuts_of(self.part)

    @property
    def face(self) -> occ.Face:
        """Its face, in the plane z = 0, with the names of its boundaries on its edges."""
        whole = occ.Circle(self.centre, self.outer).Face() - occ.Circle(self.centre, self.inner).Face()
        face = part_of(whole, self.part, self.centre, self.outer)
        area = pi * (self.outer**2 - self.inner**2) / 2 ** len(self.cuts)
        lines = {"x0": (0, self.centre[0]), "y0": (1, self.centre[1])}
        return named_face(face, self, {side: lines[side] for side in self.cuts}, self.outer, area, self._arc)

    def _arc(self, point: Point) -> str:
        """Return which arc an end of it lies on."""
        distance = ((point[0] - self.centre[0]) ** 2 + (point[1] - self.centre[1]) ** 2) ** 0.5
        return "outer" if distance > (self.inner + self.outer) / 2 else "inner"

    @field_validator("outer")
    @classmethod
    def _around_inner(cls, outer: float, info: ValidationInfo) -> float:
        if outer <= info.data.get("inner", 0.0):
            refuse("allowed: a radius > inner = {inner}", inner=f"{info.data['inner']:g}")
        return outer
