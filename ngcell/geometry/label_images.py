"""Cells from a label image: one whole number a cell, 0 where there is none.

Walls are traced between pixels of different labels. Where three regions meet there is a junction; between junctions a
wall goes through the middles of the pixels' edges, as marching squares would have it, and is then simplified to a
tolerance (Douglas and Peucker, Cartographica 10, 1973, doi:10.3138/FM57-6770-U75U-7727). Each wall is simplified once,
for both cells, so that they share it exactly.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ngcell.errors import DependencyError, GeometryError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Labels that a picture in floating point numbers holds exactly are below this.
_MOST_LABELS = 2**53
#: Fewest pixels of a cell: smaller ones are noise.
_FEWEST_PIXELS = 4


def read_labels(file: Path) -> Index:
    """Return the labels of an image, shape (rows, columns), the uppermost row first.

    Raises
    ------
    DependencyError
        If the library that reads images is not installed.
    GeometryError
        If it cannot be read, or is no label image.
    """
    try:
        from PIL import Image, UnidentifiedImageError
    except ImportError as error:
        raise DependencyError("label images need pillow; install ngcell[image]") from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # below twice its limit
            with Image.open(file, formats=("PNG", "TIFF")) as image:
                labels = np.asarray(image)
    except UnidentifiedImageError as error:
        raise GeometryError(f"{file}: is no image; allowed: a PNG or TIFF with one whole number a pixel") from error
    except Image.DecompressionBombError as error:
        raise GeometryError(f"{file}: {error}; allowed: fewer pixels: cut the image, or make it coarser") from error
    except OSError as error:
        reason = error.strerror or error
        raise GeometryError(f"{file}: cannot be read ({reason}); allowed: a readable PNG or TIFF") from error
    if labels.ndim != 2:
        raise GeometryError(
            f"{file}: has {labels.shape[2]} channels; allowed: one, a label image rather than a picture of it"
        )
    whole = np.isfinite(labels) & (labels == np.round(labels)) & (labels >= 0) & (labels < _MOST_LABELS)
    if not whole.all():
        raise GeometryError(f"{file}: has pixels that are no whole number >= 0; allowed: 0 and the numbers of cells")
    return labels.astype(np.int64)


def check_walls_touch(labels: Index, narrowest: float) -> None:
    """Check that cells touch, and are not separated by lines of background as a watershed leaves them.

    Parameters
    ----------
    labels : array of int, shape (rows, columns)
        The image.
    narrowest : float
        Width of the narrowest pore between cells, in pixels; lines of one pixel are too narrow in any case.

    Raises
    ------
    GeometryError
        If two cells are separated by narrower background along more pixels than they touch along.
    """
    touching: list[Index] = []
    apart: list[Index] = []
    for image in (labels, labels.T):
        for width in range(max(1, min(int(narrowest), image.shape[1] - 2)) + 1):
            one, two = image[:, : image.shape[1] - width - 1], image[:, width + 1 :]
            met = (one != two) & (one > 0) & (two > 0)
            for between in range(1, width + 1):
                met &= image[:, between : image.shape[1] - width - 1 + between] == 0
            (apart if width else touching).append(np.sort(np.column_stack([one[met], two[met]])))
    pairs, which = np.unique(np.concatenate([*touching, *apart]), axis=0, return_inverse=True)
    more = np.repeat([-1, 1], [sum(map(len, touching)), sum(map(len, apart))])
    along = np.bincount(which.ravel(), more, len(pairs))
    if (along > 0).any():
        first, second = pairs[int(along.argmax())]
        raise GeometryError(
            f"labels {first} and {second} are separated by a line of background; allowed: labels that touch, or pores "
            f"wider than {max(1, int(narrowest))} pixels, half of a wall"
        )


def traced_cells(labels: Index, tolerance: float) -> tuple[list[Array], Index]:
    """Return the outline of each cell, (corners, 2), x to the right and y upwards in pixels, and the cells' labels.

    Parameters
    ----------
    labels : array of int, shape (rows, columns)
        The image, the uppermost row first.
    tolerance : float
        Largest distance of a wall from the line through the middles of its pixels' edges, in pixels, >= 0.

    Raises
    ------
    GeometryError
        If there is one label only, or a cell is of several pieces, has a hole, or is too small or thin to be traced.
    """
    import shapely

    known = np.unique(labels[labels > 0])
    if len(known) < 2:
        said = f"one label only, {known[0]}" if len(known) else "no label but 0"
        raise GeometryError(f"the image has {said}; allowed: a number for each cell, two cells or more")
    padded = np.pad(labels, 1)
    lines = [_simplified(wall, tolerance) for wall in _walls(padded)]
    faces = shapely.get_parts(shapely.polygonize(lines))
    label = _labels_of(faces, padded)
    _check_pieces(padded, known)
    count = np.bincount(np.searchsorted(known, label[label > 0]), minlength=len(known))
    for wrong, what in ((count < 1, "has no area left"), (count > 1, "falls apart")):
        if wrong.any():
            raise GeometryError(
                f"label {known[int(wrong.argmax())]} {what} once its walls are simplified; allowed: a smaller "
                f"tolerance than {tolerance:g} pixels, or an image of more pixels"
            )
    cells = faces[label > 0][np.argsort(label[label > 0])]
    holed = np.flatnonzero(shapely.get_num_interior_rings(cells) > 0)
    if len(holed):
        raise GeometryError(f"label {known[holed[0]]} has a hole; allowed: cells without holes (pores lie between)")
    return [np.asarray(cell.exterior.coords)[:-1] - 1 for cell in cells], known


def _walls(padded: Index) -> list[Array]:
    """Return the lines between pixels of different labels, from junction to junction or closed, each (n, 2).

    Corners of the image are junctions, so that cells that end there keep their corners.
    """
    import shapely

    rows = len(padded)
    row, col = np.nonzero(padded[1:] != padded[:-1])
    level = np.stack([np.column_stack([col, rows - 1 - row]), np.column_stack([col + 1, rows - 1 - row])], axis=1)
    row, col = np.nonzero(padded[:, 1:] != padded[:, :-1])
    upright = np.stack([np.column_stack([col + 1, rows - 1 - row]), np.column_stack([col + 1, rows - row])], axis=1)
    edges = shapely.linestrings(np.concatenate([level, upright]).astype(float))
    merged = shapely.get_parts(shapely.line_merge(shapely.multilinestrings(edges)))
    corners = np.array([(x, y) for x in (1, padded.shape[1] - 1) for y in (1, rows - 1)])
    return [part for line in merged for part in _split(shapely.get_coordinates(line), corners)]


def _split(wall: Array, corners: Array) -> list[Array]:
    """Return the parts of a wall between points that are among these corners."""
    at = np.flatnonzero((wall[:, None] == corners).all(2).any(1))
    if len(at) and (wall[0] == wall[-1]).all():
        wall = np.concatenate([wall[at[0] : -1], wall[: at[0] + 1]])
        at = np.flatnonzero((wall[:, None] == corners).all(2).any(1))
    ends = np.unique([0, *at, len(wall) - 1])
    return [wall[one : two + 1] for one, two in zip(ends[:-1], ends[1:], strict=True)]


def _simplified(wall: Array, tolerance: float) -> object:
    """Return a wall as a line through the middles of its edges and its ends, simplified."""
    import shapely

    middles = (wall[1:] + wall[:-1]) / 2
    if (wall[0] == wall[-1]).all():
        # A closed wall has no junction: its first middle and the one furthest from it stay.
        turned = np.concatenate([middles, middles[:1]])
        half = int(np.linalg.norm(middles - middles[0], axis=1).argmax())
        parts = [shapely.LineString(part).simplify(tolerance) for part in (turned[: half + 1], turned[half:])]
        return shapely.LineString([*parts[0].coords, *parts[1].coords[1:]])
    return shapely.LineString([wall[0], *middles, wall[-1]]).simplify(tolerance)


def _labels_of(faces: NDArray[np.object_], padded: Index) -> Index:
    """Return the label at a point inside of each face, shape (faces,)."""
    import shapely

    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    row, col = len(padded) - 1 - np.floor(inside[:, 1]).astype(int), np.floor(inside[:, 0]).astype(int)
    return np.asarray(padded[row, col])


def _check_pieces(padded: Index, known: Index) -> None:
    """Check that the pixels of each label are connected along edges, and enough."""
    from ngcell.geometry.near import components

    number = np.arange(padded.size).reshape(padded.shape)
    level, upright = padded[:, 1:] == padded[:, :-1], padded[1:] == padded[:-1]
    one = np.concatenate([number[:, :-1][level], number[:-1][upright]])
    two = np.concatenate([number[:, 1:][level], number[1:][upright]])
    piece = components(padded.size, one, two)
    first = np.unique(piece, return_index=True)[1]
    pieces = np.bincount(np.searchsorted(known, padded.ravel()[first][padded.ravel()[first] > 0]), minlength=len(known))
    if (pieces > 1).any():
        at = int(pieces.argmax())
        raise GeometryError(
            f"label {known[at]} is of {pieces[at]} pieces; allowed: pixels of a label that touch along their edges"
        )
    size = np.bincount(np.searchsorted(known, padded[padded > 0]), minlength=len(known))
    if size.min() < _FEWEST_PIXELS:
        at = int(size.argmin())
        raise GeometryError(f"label {known[at]} has {size[at]} pixels; allowed: {_FEWEST_PIXELS} or more")
