"""The picture of what would be solved: cells with their numbers, elements, walls and supports."""

from __future__ import annotations

from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ngcell.export.cell_size import CellSize
from ngcell.export.picture import INK, RIGID, SOFT_INK, canvas, save_png
from ngcell.results.layout import Layout

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BODY, _FILLING, _ELEMENT = "#dbe6ee", "#f3efe2", "#b4c2cd"
_SUPPORTS = ("#b3361e", "#1f5f8b", "#4a7a3a", "#c98a1b")
#: Numbers of bodies are left out where they would be smaller [points].
_SMALLEST_NUMBER = 4.0


def draw_layout(layout: Layout, path: Path, *, title: str = "") -> Path:
    """Draw bodies at rest: elements, walls in black, supports in colours of their own; return `path`.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    places = np.concatenate(layout.elements)
    figure, axes, size = canvas(places, places, int(layout.body.max()) + 1)
    _draw_elements(axes, layout, size)
    _draw_edges(axes, layout, size)
    _draw_rigid(axes, layout)
    _draw_numbers(axes, layout, size.at_most(8, 0.34))
    axes.set_title(title, loc="left", fontsize=12, fontweight="bold", color=INK, pad=22)
    return save_png(figure, path)


def _draw_elements(axes: Axes, layout: Layout, size: CellSize) -> None:
    from matplotlib.collections import PolyCollection

    colours = [_FILLING if filling else _BODY for filling in layout.is_filling]
    width = size.at_most(0.35, 0.008)
    axes.add_collection(
        PolyCollection(layout.elements, facecolors=colours, edgecolors=_ELEMENT, linewidths=width, zorder=1)
    )


def _draw_edges(axes: Axes, layout: Layout, size: CellSize) -> None:
    from matplotlib.collections import LineCollection

    plain = [name for name in layout.edges if name not in layout.support_names]
    for name in plain:
        colour, line = (INK, (0.9, 0.018)) if name in layout.wall_names else (SOFT_INK, (0.6, 0.012))
        axes.add_collection(
            LineCollection(list(layout.edges[name]), colors=colour, linewidths=size.at_most(*line), zorder=2)
        )
    for name, colour in zip(layout.support_names, cycle(_SUPPORTS), strict=False):
        width = size.at_most(2.6, 0.12)
        lines = LineCollection(list(layout.edges[name]), colors=colour, linewidths=width, zorder=3, label=name)
        axes.add_collection(lines)
    if layout.support_names:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, frameon=False, fontsize=9, labelcolor=INK)


def _draw_rigid(axes: Axes, layout: Layout) -> None:
    """Fill rigid bodies, which are shells for the solver only."""
    from matplotlib.collections import PolyCollection

    outlines = [
        np.array([layout.elements[number][0] for number in np.flatnonzero(layout.body == body)])
        for body in _rigid_bodies(layout)
    ]
    axes.add_collection(PolyCollection(outlines, zorder=2.5, **RIGID), autolim=False)


def _rigid_bodies(layout: Layout) -> range:
    count = int(layout.body.max()) + 1
    return range(count - layout.rigid_count, count)


def _draw_numbers(axes: Axes, layout: Layout, height: float) -> None:
    """Write the number of each body in the middle of it, as far as it can be read, and of rigid ones that they are."""
    if height < _SMALLEST_NUMBER:
        return
    for body in range(int(layout.body.max()) + 1):
        places = np.concatenate([layout.elements[number] for number in np.flatnonzero(layout.body == body)])
        x, y = (places.min(0) + places.max(0)) / 2
        is_rigid = body in _rigid_bodies(layout)
        words, colour = ("rigid", INK) if is_rigid else (str(body), SOFT_INK)
        axes.text(x, y, words, ha="center", va="center", fontsize=height, color=colour, zorder=4)
