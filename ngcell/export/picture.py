"""The picture of the deformed tissue.

Matplotlib's Agg canvas draws it, which needs neither display nor GPU nor OpenGL library. Only the outside of the
tissue and open gaps are white: lumens are tinted, so that a gap is not taken for one.
"""

from __future__ import annotations

import io
import zlib
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ngcell.export.atomic import replace_file
from ngcell.export.cell_size import CellSize
from ngcell.export.outline import Loop, bodies_that_are, cell_loops, planar_view, triangulate
from ngcell.export.series import NOT_CERTIFIED
from ngcell.results.snapshot import Grid, Snapshot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import TriMesh
    from matplotlib.figure import Figure

INK = "#222222"
NOTE_INK = "#5a6068"
SOFT_INK = "#8a8f98"
_LUMEN, _FREE = "#e4e9efc8", "#f6b26b"
#: Width of the outline of a cell [points], and what share of the cell it has at most.
_OUTLINE = 0.6, 0.012
#: Outlines that are thinner show no dashes [points].
_DASHED = 0.35
#: How rigid bodies are filled.
RIGID: dict[str, Any] = {"facecolors": "#aab0b8", "edgecolors": INK, "linewidths": 0.6}
#: Characters of a title in one line, and in each of two lines of a smaller size.
_LINE, _LONG_LINE = 62, 78
_REFERENCE = "#c3c8cf"
_ALARM = "#d21f1f"
_WIDTH, _LEFT, _RIGHT, _BOTTOM, _TOP = 8.6, 0.72, 1.25, 0.62, 0.78  # of the figure and its margins [inch]


def draw_tissue(snapshot: Snapshot, path: Path, *, title: str, certified: bool) -> Path:
    """Draw the deformed tissue coloured by X displacement, over a faint outline of the reference state.

    Cells that nothing holds are outlined by dashes, or have an orange lumen where cells are too small for dashes. Lines
    are thinner, and the picture has more pixels, where cells are many. An uncertified result is labelled.

    Parameters
    ----------
    snapshot : Snapshot
        A planar tissue, or one of prisms, which are seen from above.
    path : Path
        The PNG file.
    title : str
        Heading; may be empty.
    certified : bool
        Whether the result passed every check.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    OutputError
        If the cells are not planar or the file cannot be written.
    """
    bulk = planar_view(snapshot.bulk)
    deformed = (bulk.points + bulk.point_data["displacement"])[:, :2]
    loops = cell_loops(bulk)
    at_rest = bulk.points[:, :2]
    figure, axes, size = canvas(np.vstack([deformed, at_rest]), at_rest, len(np.unique(bulk.cell_data["cell_id"])))
    line = size.at_most(*_OUTLINE)
    _draw_reference(axes, bulk, loops, line)
    free, rigid = bodies_that_are("free", bulk), bodies_that_are("rigid", bulk)
    colours = _draw_bodies(axes, bulk, deformed, loops, tinted=free if line < _DASHED else set())
    _add_colour_bar(figure, axes, colours)
    _draw_outlines(axes, deformed, loops, free, line)
    _draw_rigid(axes, deformed, [loop for loop in loops if loop.cell_id in rigid])
    _add_heading(axes, title, snapshot, free=len(free), mark="dashed" if line >= _DASHED else "orange")
    if not certified:
        mark_uncertified(figure)
    return save_png(figure, path)


def save_png(figure: Figure, path: Path) -> Path:
    """Render a figure without a display and write it as PNG, in full or not at all."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    image = io.BytesIO()
    canvas: Any = FigureCanvasAgg(figure)  # its method is not annotated
    canvas.print_png(image, pil_kwargs={"compress_type": zlib.Z_RLE})  # areas of one colour are runs of equal bytes
    replace_file(Path(path), image.getvalue())
    return Path(path)


def mark_uncertified(figure: Figure) -> None:
    """Write NOT CERTIFIED across a figure."""
    size = 5.5 * min(figure.get_figwidth(), 1.6 * figure.get_figheight())
    figure.text(
        0.48, 0.5, NOT_CERTIFIED, color=_ALARM, alpha=0.75, fontsize=size, fontweight="bold", rotation=24,
        ha="center", va="center", zorder=10,
        bbox={"boxstyle": "round,pad=0.25", "facecolor": "#ffffff66", "edgecolor": _ALARM, "linewidth": 2.5},
    )  # fmt: skip


def style_axes(axes: Axes) -> None:
    """Draw axes as two thin lines with small outward ticks."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set(color=SOFT_INK, linewidth=0.8)
    axes.tick_params(colors=INK, labelsize=10, color=SOFT_INK, width=0.8)


def canvas(points: NDArray[Any], at_rest: NDArray[Any], count: int) -> tuple[Figure, Axes, CellSize]:
    """Return a figure and axes in the proportions of these points, shape (points, 2), and how large a cell is in it.

    The `count` cells have at rest the places `at_rest`, shape (places, 2).
    """
    from matplotlib.figure import Figure

    low, high = _window(points)
    inches = float((_WIDTH - _LEFT - _RIGHT) / (high - low).max())
    width, height = (high - low) * inches
    size, cell = (width + _LEFT + _RIGHT, height + _BOTTOM + _TOP), CellSize.of(at_rest, count, inches)
    figure = Figure(figsize=size, dpi=cell.dpi, facecolor="white")
    axes = figure.add_axes((_LEFT / size[0], _BOTTOM / size[1], width / size[0], height / size[1]))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_xlabel("X", fontsize=11, color=INK)
    axes.set_ylabel("Y", fontsize=11, color=INK, rotation=0, labelpad=10)
    style_axes(axes)
    return figure, axes, cell


def _window(points: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the lower and upper corner of the axes: all points and a margin, widened if too flat or too slim."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, span = (low + high) / 2, 1.06 * (high - low)
    span = np.maximum(span, [0.65 * span[1], 0.3 * span[0]])
    return middle - span / 2, middle + span / 2


def _draw_reference(axes: Axes, bulk: Grid, loops: Iterable[Loop], width: float) -> None:
    from matplotlib.collections import PolyCollection

    lines = [bulk.points[loop.points, :2] for loop in loops if loop.outer]
    axes.add_collection(
        PolyCollection(lines, facecolors="none", edgecolors=_REFERENCE, linewidths=width, zorder=1),
        autolim=False,
    )


def _draw_bodies(axes: Axes, bulk: Grid, deformed: NDArray[Any], loops: Iterable[Loop], *, tinted: set[int]) -> TriMesh:
    from matplotlib.collections import PolyCollection
    from matplotlib.tri import Triangulation

    outer = [loop for loop in loops if loop.outer]
    insides, colours = (
        [deformed[loop.points] for loop in outer],
        [_FREE if loop.cell_id in tinted else _LUMEN for loop in outer],
    )
    axes.add_collection(PolyCollection(insides, facecolors=colours, linewidths=0, zorder=2), autolim=False)
    x_displacement = np.asarray(bulk.point_data["displacement"])[:, 0]
    low, high = float(x_displacement.min()), float(x_displacement.max())
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        low, high = low - 0.5, high + 0.5
    x, y = deformed.T
    return axes.tripcolor(
        Triangulation(x, y, triangulate(bulk)), x_displacement,
        shading="gouraud", cmap="viridis", vmin=low, vmax=high, zorder=3,
    )  # fmt: skip


def _draw_rigid(axes: Axes, deformed: NDArray[Any], loops: Iterable[Loop]) -> None:
    """Fill rigid bodies, which are shells for the solver only, and say what they are."""
    from matplotlib.collections import PolyCollection

    outlines = [deformed[loop.points] for loop in loops if loop.outer]
    axes.add_collection(PolyCollection(outlines, zorder=5, **RIGID), autolim=False)
    for outline in outlines:
        x, y = (outline.min(0) + outline.max(0)) / 2
        axes.text(x, y, "rigid", ha="center", va="center", fontsize=8, color=INK, zorder=6)


def _draw_outlines(axes: Axes, deformed: NDArray[Any], loops: Iterable[Loop], free: set[int], width: float) -> None:
    """Outline every cell, those held by nothing by dashes."""
    from matplotlib.collections import PolyCollection

    for dashed, style in ((False, "solid"), (True, (0, (2.2, 1.6)))):
        lines = [deformed[loop.points] for loop in loops if (loop.cell_id in free) == dashed]
        axes.add_collection(
            PolyCollection(lines, facecolors="none", edgecolors=INK, linewidths=width, linestyles=[style], zorder=4),
            autolim=False,
        )


def _add_colour_bar(figure: Figure, axes: Axes, colours: TriMesh) -> None:
    place = axes.get_position()
    width = figure.get_figwidth()
    bar_axes = figure.add_axes((place.x1 + 0.28 / width, place.y0, 0.16 / width, place.height))
    bar = figure.colorbar(colours, cax=bar_axes)
    bar.set_label("X displacement", fontsize=11, color=INK, labelpad=8)
    bar.ax.tick_params(labelsize=10, colors=INK, color=SOFT_INK, width=0.8)
    bar.outline.set(edgecolor=SOFT_INK, linewidth=0.8)


def _add_heading(axes: Axes, title: str, snapshot: Snapshot, *, free: int, mark: str) -> None:
    facts = [
        f"plate displacement {snapshot.plate_displacement:.4g}",
        f"load factor {snapshot.load_factor:.4g}",
    ]
    if free:
        facts.append(f"{mark}: {free} {'cell' if free == 1 else 'cells'} held by nothing")
    heading = partial(axes.annotate, xycoords="axes fraction", textcoords="offset points")
    lines = title if len(title) <= _LINE else "\n".join(wrap(title, _LONG_LINE, max_lines=2, placeholder=" …"))
    size = 13.0 if lines == title else 10.0
    heading(lines, (0, 1), (0, 26), fontsize=size, fontweight="bold", color=INK)
    heading(" · ".join(facts), (0, 1), (0, 10), fontsize=10, color=NOTE_INK)
