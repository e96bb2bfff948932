"""How far cells have turned."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ngcell.results.quantities import View
from ngcell.scene.section import Section


class Rotation(Section):
    """Mean rotation of each cell in the plane [degree], positive anticlockwise: that of the polar decomposition of the
    affine map that fits its displacement best."""

    kind: Literal["rotation"] = "rotation"

    @property
    def name(self) -> str:
        """Name of the column and of the field."""
        return "rotation"

    def values(self, view: View) -> NDArray[np.float64]:
        """Return the rotation of each body, shape (bodies,)."""
        space = view.problem.space
        body, one, count = space.body_of_unknown, space.one, space.body_count
        number, rest_positions = np.bincount(body, one, count), space.rest
        rest, moved = (
            np.array([row - (np.bincount(body, row * one, count) / number)[body] for row in places[:2]]) * one
            for places in (rest_positions, view.positions)
        )
        def products(places: NDArray[np.float64]) -> NDArray[np.float64]:
            """Sums of products with places at rest, shape (bodies, 2, 2)."""
            sums = [[np.bincount(body, one * other, count) for other in rest] for one in places]
            return np.moveaxis(np.array(sums), -1, 0)

        gradient = products(moved) @ np.linalg.inv(products(rest))
        turn = np.arctan2(gradient[:, 1, 0] - gradient[:, 0, 1], np.trace(gradient, axis1=1, axis2=2))
        return np.asarray(np.degrees(turn))
