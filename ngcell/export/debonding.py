"""How the tissue comes apart: open walls and connected components of cells over the load, and where walls opened."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from math import sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ngcell.export.cell_size import CellSize
from ngcell.export.curves import STYLES, draw_curve, load_axis, released_steps
from ngcell.export.picture import INK, SOFT_INK, mark_uncertified, save_png, style_axes
from ngcell.export.plan import places, wall_lines
from ngcell.results.record import StepRecord
from ngcell.results.rupture.cells import BURST, SEPARATED, WHOLE, end_of
from ngcell.results.snapshot import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: The two cells of a wall pair, and where on the load path it opened, NaN if it has not.
PairOnset = tuple[int, int, float]

_SIZE = (10.4, 4.6)  # of the figure [inch]
# Left, bottom, width and height of each panel as shares of the figure. They are fixed since matplotlib's automatic
# layout takes as long as everything else.
_SHARE_PANEL, _COMPONENTS_PANEL = (0.063, 0.545, 0.36, 0.41), (0.063, 0.105, 0.36, 0.41)
_PLAN_PANEL, _BAR_PANEL = (0.455, 0.06, 0.44, 0.86), (0.91, 0.165, 0.0155, 0.67)
#: Width of a wall and of the mark of a cell [points], and what share of the cell each has at most.
_WALL, _MARK = (3.5, 0.12), (10.5, 0.4)
#: Colour and marker of how cells end.
_ENDS = {WHOLE: ("#ffffff", "o"), SEPARATED: ("#1f5f8b", "s"), BURST: ("#b3361e", "X")}
_OPEN, _PARTED, _COMPONENTS, _LARGEST, _CLOSED = "#1f5f8b", "#4a7a3a", "#b3361e", "#c98a1b", "#d5d9df"


def draw_debonding(
    history: Sequence[StepRecord],
    pairs: Sequence[PairOnset],
    cells: Grid,
    path: Path,
    *,
    certified: bool,
    ends: Sequence[str] = (),
) -> Path:
    """Draw open walls and connected components over the load, and a plan of the walls, coloured by where they opened.

    Parameters
    ----------
    history : sequence of StepRecord
        The accepted steps, at least one of them released.
    pairs : sequence of (int, int, float)
        The wall pairs at the last level: two cells, and the plate displacement, or load factor where no plate moves, at
        which their walls opened, NaN if they have not.
    cells : Grid
        The bodies, with `cell_id`.
    path : Path
        The PNG file.
    certified : bool
        Whether the result passed every check.
    ends : sequence of str
        How each cell has ended, "whole", "separated" or "burst"; empty where it is not known what walls bear.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    from matplotlib.figure import Figure

    rows = released_steps(history)
    load, name = load_axis(rows)
    size = _cell_size(cells)
    figure = Figure(figsize=_SIZE, dpi=size.dpi, facecolor="white")
    share, components, plan = (figure.add_axes(place) for place in (_SHARE_PANEL, _COMPONENTS_PANEL, _PLAN_PANEL))
    parted = [row.parted_pairs / max(len(pairs), 1) for row in rows]
    draw_curve(share, load, [row.opened_share for row in rows], label="open wall length", colour=_OPEN, style=STYLES[0])
    draw_curve(share, load, parted, label="parted wall pairs", colour=_PARTED, style=STYLES[1])
    count, largest = [row.components for row in rows], [row.largest_component for row in rows]
    draw_curve(components, load, count, label="connected components of cells", colour=_COMPONENTS, style=STYLES[0])
    draw_curve(components, load, largest, label="cells in the largest", colour=_LARGEST, style=STYLES[1])
    for axes, label in ((share, "share"), (components, "number")):
        style_axes(axes)
        axes.set_ylabel(label, color=INK)
        axes.yaxis.set_label_coords(-0.115, 0.5)
        axes.set_ylim(0, 1.05 * axes.get_ylim()[1])
        axes.legend(frameon=False, fontsize=9, labelcolor=INK)
    share.tick_params(labelbottom=False)
    components.set_xlabel(name, color=INK)
    _draw_plan(figure, plan, pairs, cells, size, name)
    _draw_ends(plan, cells, ends, size)
    if not certified:
        mark_uncertified(figure)
    return save_png(figure, path)


def read_last_pairs(path: Path) -> list[PairOnset]:
    """Return the wall pairs, with their onsets, of the last level in a table."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    last = [row for row in rows if row["step"] == rows[-1]["step"]]
    return [(int(row["cell_a"]), int(row["cell_b"]), float(row["onset"])) for row in last]


def read_last_ends(path: Path) -> list[str]:
    """Return how each cell has ended at the last level in a table; nothing where it does not tell."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows or "burst_at" not in rows[0]:
        return []
    last = [row for row in rows if row["step"] == rows[-1]["step"]]
    return [end_of(float(row["burst_at"]), float(row["separated_at"])) for row in last]


def _cell_size(cells: Grid) -> CellSize:
    """Return how large a cell is in the plan, which fills its panel along x or along y."""
    place, layer = places(cells)
    width = np.ptp(cells.points[:, 0]) + float(np.ptp(place[:, 0])) * bool(layer.any())
    panel = np.multiply(_SIZE, _PLAN_PANEL[2:])
    inches = float((panel / [width, np.ptp(cells.points[:, 1])]).min())
    return CellSize.of(cells.points[:, :2], int((layer == layer.max()).sum()), inches)


def _draw_ends(axes: Axes, cells: Grid, ends: Sequence[str], size: CellSize) -> None:
    """Mark each cell by how it has ended."""
    if not ends:
        return
    place, found = places(cells)[0][: len(ends)], np.array(ends)  # rigid bodies, the last ones, have no end
    area, line = size.at_most(*_MARK) ** 2, size.at_most(0.6, 0.02)
    for end, (colour, marker) in _ENDS.items():
        mine = place[found == end]
        label = f"{len(mine)} {end}"
        axes.scatter(
            mine[:, 0], mine[:, 1], s=area, c=colour, marker=marker, label=label, edgecolor=INK, linewidth=line
        )
    style: dict[str, Any] = {"frameon": False, "fontsize": 9, "labelcolor": INK, "markerscale": _MARK[0] / sqrt(area)}
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.01), ncols=3, **style)


def _draw_plan(
    figure: Figure, axes: Axes, pairs: Sequence[PairOnset], cells: Grid, size: CellSize, load: str
) -> None:
    """Draw the common wall of each pair; those that have not opened dotted and in grey.

    Layers of prisms are laid out side by side, the lowest first; a wall between two layers is a dot in the lower one.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize, to_rgba

    place, layer = places(cells)
    pairs = sorted(pairs, key=lambda pair: bool(np.isfinite(pair[2])))  # opened walls are drawn above the grey ones
    first, second = (np.array([pair[end] for pair in pairs]) for end in range(2))
    onset = np.array([onset for _, _, onset in pairs])
    opened, level = np.isfinite(onset), layer[first] == layer[second]
    walls = wall_lines(cells, np.column_stack([first, second])[level])
    number = np.repeat(np.flatnonzero(level), [len(wall) for wall in walls])
    lines = np.concatenate([np.zeros((0, 2, 2)), *walls])
    earliest, latest = (onset[opened].min(), onset[opened].max()) if opened.any() else (0.0, 1.0)
    scale = Normalize(earliest if earliest < latest else 0.0, latest or 1.0)
    shown = ScalarMappable(scale, "plasma_r")
    colour = np.where(opened[:, None], shown.to_rgba(onset), to_rgba(_CLOSED))
    for which, style in ((~opened, (0, (0.1, 2.8))), (opened, "solid")):
        chosen = which[number]
        look: dict[str, Any] = {"linewidths": size.at_most(*_WALL), "capstyle": "round", "linestyles": [style]}
        axes.add_collection(LineCollection(list(lines[chosen]), colors=colour[number[chosen]], **look))
    dots = np.where(layer[first] < layer[second], first, second)[~level]
    axes.scatter(place[dots, 0], place[dots, 1], s=size.at_most(9.5, 0.3) ** 2, color=colour[~level])
    drawn = np.concatenate([lines.reshape(-1, 2), place[dots]])
    around = 0.1 * sqrt(float(np.ptp(cells.points[:, :2], axis=0).prod()) / len(place))  # a tenth of a cell, about
    axes.set(xlim=_limits(drawn[:, 0], around), ylim=_limits(drawn[:, 1], around), aspect="equal")
    axes.set_axis_off()
    others = "" if opened.all() else " (the others are dotted)"
    axes.set_title(f"{int(opened.sum())} of {len(pairs)} wall pairs have opened{others}", fontsize=10.5, color=INK)
    if opened.any():
        bar = figure.colorbar(shown, cax=figure.add_axes(_BAR_PANEL))
        bar.set_label(f"opened at {load}", color=INK, labelpad=7)
        bar.outline.set(edgecolor=SOFT_INK, linewidth=0.8)


def _limits(values: NDArray[np.float64], around: float) -> tuple[float, float]:
    margin = 0.05 * float(np.ptp(values)) + around
    return float(values.min()) - margin, float(values.max()) + margin
