"""A disc, or what planes of symmetry leave of it."""

from __future__ import annotations

from math import pi
from typing import Literal

from netgen import occ

from ngcell.geometry.user_bodies.body import Part, UserBody, cuts_of, named_face, part_of
from ngcell.scene.section import PlanarVector, PositiveNumber


class Disc(UserBody):
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
        return cuts_of(self.part)

    @property
    def face(self) -> occ.Face:
        """Its face, in the plane z = 0, with the names of its boundaries on its edges."""
        whole = occ.Circle(self.centre, self.radius).Face()
        face = part_of(whole, self.part, self.centre, self.radius)
        area = pi * self.radius**2 / 2 ** len(self.cuts)
        lines = {"x0": (0, self.centre[0]), "y0": (1, self.centre[1])}
        return named_face(face, self, {side: lines[side] for side in self.cuts}, self.radius, area)
