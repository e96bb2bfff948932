"""A rectangle."""

from __future__ import annotations

from typing import Literal

from netgen import occ
from pydantic import ValidationInfo, field_validator

from ngcell.geometry.user_bodies.body import UserBody, named_face
from ngcell.scene.scope import refuse
from ngcell.scene.section import PlanarVector


class Block(UserBody):
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

    @property
    def face(self) -> occ.Face:
        """Its face, in the plane z = 0, with the names of its boundaries on its edges."""
        (left, bottom), (right, top) = self.low, self.high
        face = occ.MoveTo(left, bottom).Rectangle(right - left, top - bottom).Face()
        lines = {"bottom": (1, bottom), "top": (1, top), "left": (0, left), "right": (0, right)}
        return named_face(face, self, lines, right - left + top - bottom, (right - left) * (top - bottom))

    @field_validator("high")
    @classmethod
    def _beyond_low(cls, high: tuple[float, float], info: ValidationInfo) -> tuple[float, float]:
        low = info.data.get("low", high)
        if "low" in info.data and not (low[0] < high[0] and low[1] < high[1]):
            refuse("allowed: a corner above and to the right of low = {low}", low=str(list(low)))
        return high
