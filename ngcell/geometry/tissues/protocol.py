"""What a tissue offers, whichever its geometry: the mesh of its cells with the regions that loads and lumens need.

A further geometry is one file beside this one and one line in `ngcell.scene.registry`; a script may hand over any
object with these members.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ngcell.geometry.bodies import BodyMesh

#: Cells whose inner walls belong to each region of lumens.
Lumens = dict[str, NDArray[np.int64]]


class TissueDensity(Protocol):
    """How finely a tissue is to be meshed; None leaves a number to the tissue."""

    @property
    def size(self) -> float | None:
        """Length of an element's edge along the wall [length]."""

    @property
    def layers(self) -> int | None:
        """Elements through the wall."""

    @property
    def grading(self) -> int | None:
        """How often elements are graded towards corners, where stresses are singular."""

    @property
    def halvings(self) -> int | None:
        """How often elements between graded ones are halved along the wall."""

    @property
    def slices(self) -> int | None:
        """Elements along the height of prisms."""


@runtime_checkable
class TissueGeometry(Protocol):
    """Cells, each a body of its own."""

    @property
    def cell_count(self) -> int:
        """Number of cells."""

    @property
    def grid(self) -> tuple[int, int]:
        """Number of rows and of cells in each, for pressures that differ from cell to cell; ``(1, cells)`` will do."""

    @property
    def height(self) -> float | None:
        """Height of the cells along z [length]; None in the plane."""

    def mesh(
        self, supported: str | None, choice: TissueDensity, lumens: Lumens | None = None, *, filled: bool = False
    ) -> BodyMesh:
        """Return the mesh, one body a cell.

        Parameters
        ----------
        supported : {"plates", "confined", "frame", None}
            Which outer walls form regions that a load holds or moves: those that face down at the bottom and up at
            the top, `LOWER_PLATE` and `UPPER_PLATE`; where the tissue is confined, those along its left and right edge
            as well, `LEFT_SIDE` and `RIGHT_SIDE`; all of them, `FRAME`; or none.
        choice : TissueDensity
            How fine it is.
        lumens : dict of str to array of int, optional
            Cells whose inner walls form each region; by default all form the region `LUMEN`.
        filled : bool
            Whether lumens hold elements, in the region `FILLING`.
        """
