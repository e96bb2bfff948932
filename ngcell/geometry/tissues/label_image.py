"""A tissue from a label image: a segmented micrograph, with one whole number a cell."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from ngcell.geometry.label_images import check_walls_touch, read_labels, traced_cells
from ngcell.geometry.outlines import Outlines
from ngcell.geometry.partition import outlines_of
from ngcell.geometry.tissues.outlined import OutlinedCells
from ngcell.scene.section import FilePath, NonNegativeNumber, PositiveNumber

#: Distance in pixels below which corners are one.
_SAME = 1e-6
#: Width of the narrowest pore between cells, as a share of the wall.
_NARROWEST = 0.5


class LabelImage(OutlinedCells):
    """Cells of a label image, in the order of their labels; background of label 0 between them is a pore.

    Walls go through the middles of pixels' edges, simplified once for both cells; see `ngcell.geometry.label_images`.

    Parameters
    ----------
    file : str
        A PNG or TIFF with one channel. Its path is relative to the case file; one that is given beside a case is
        relative to the working folder.
    pixel : float
        Side of a pixel [length], > 0.
    tolerance : float
        Largest distance of a simplified wall from the one in the image, in pixels, >= 0.
    shortest : float
        As for all, but 1/4 by default: an image has sides of any length.

    Notes
    -----
    Further keys are those of `ngcell.geometry.tissues.outlined.OutlinedCells`.
    """

    kind: Literal["image"] = "image"
    shortest: NonNegativeNumber = 0.25
    file: FilePath
    pixel: PositiveNumber
    tolerance: NonNegativeNumber = 1.0

    def drawn(self) -> Outlines:
        """Return the outlines."""
        image = read_labels(Path(self.file))
        check_walls_touch(image, _NARROWEST * self.wall / self.pixel)
        cells, labels = traced_cells(image, self.tolerance)
        names = [f"label {label}" for label in labels]
        return outlines_of([self.pixel * cell for cell in cells], _SAME * self.pixel, names=names)
