"""The gap curves of a run: how far walls are apart, and how many wall pairs have parted, over the load."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ngcell.export.cell_size import DPI
from ngcell.export.picture import INK, NOTE_INK, SOFT_INK, mark_uncertified, save_png, style_axes
from ngcell.results.record import StepRecord

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LARGEST, _MEAN, _PARTED, _FAILED = "#b3361e", "#1f5f8b", "#4a7a3a", "#d21f1f"
#: Marker and dashes of the first and the second curve of a panel, told apart in grey too.
STYLES: tuple[dict[str, Any], ...] = ({"marker": "o", "linestyle": "-"}, {"marker": "s", "linestyle": (0, (5, 2))})
_FREE = {"free_largest_gap": "free cells"}


def draw_curves(history: Sequence[StepRecord], path: Path, *, certified: bool, onset: float | None = None) -> Path:
    """Draw largest and mean gap, and below them the number of parted wall pairs, over the plate displacement.

    Tied steps are left out if there is a released one, since tied walls have no gap. Under a load that moves no
    plate the curves run over the load factor. Bands show estimated errors; dotted lines the gaps
    of cells that nothing holds, whose place equilibrium does not determine.

    Parameters
    ----------
    history : sequence of StepRecord
        The accepted steps, at least one.
    path : Path
        The PNG file.
    certified : bool
        Whether the result passed every check; if not, the picture says so, and rings mark the steps that
        failed.
    onset : float, optional
        Place on the load path at which gaps start to grow; see `ngcell.results.growth`.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    rows = released_steps(history) or list(history)
    load, name = load_axis(rows)
    figure, gaps, parted = _canvas(name)
    failed = np.array([not row.certified for row in rows])
    for axes, column, colour, style in (
        (gaps, "largest_gap", _LARGEST, STYLES[0]),
        (gaps, "mean_gap", _MEAN, STYLES[1]),
        (parted, "parted_pairs", _PARTED, STYLES[0]),
    ):
        values = np.array([getattr(row, column) for row in rows], dtype=float)
        draw_curve(axes, load, values, label=column.replace("_", " "), colour=colour, style=style)
        errors = np.array([getattr(row, f"{column}_error", np.nan) for row in rows])
        if np.isfinite(errors).any():
            axes.fill_between(load, values - errors, values + errors, color=colour, alpha=0.25, linewidth=0)
        if failed.any():
            _ring(axes, load[failed], values[failed])
    for column, colour, style in (("free_largest_gap", _LARGEST, STYLES[0]), ("free_mean_gap", _MEAN, STYLES[1])):
        values = np.array([getattr(row, column) for row in rows])
        if values.any():
            dotted = style | {"linestyle": ":"}
            draw_curve(gaps, load, values, label=_FREE.get(column), colour=colour, style=dotted, width=1.2)
    _scale(gaps, parted, load)
    if onset is not None:
        _mark_onset((gaps, parted), onset)
    gaps.legend(
        loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False, fontsize=10.5, handlelength=2.4,
        columnspacing=1.2, labelcolor=INK,
    )  # fmt: skip
    if not certified:
        mark_uncertified(figure)
    return save_png(figure, path)


def released_steps(history: Iterable[StepRecord]) -> list[StepRecord]:
    """Return the steps whose walls are free to part."""
    return [row for row in history if row.phase != "tied"]


def load_axis(rows: Sequence[StepRecord]) -> tuple[NDArray[np.float64], str]:
    """Return the load at each step and its name: the plate displacement or, if no plate moves, the load factor."""
    moves = any(row.plate_displacement for row in rows)
    return np.array([row.place_on_path for row in rows]), "plate displacement" if moves else "load factor"


def _canvas(load_name: str) -> tuple[Figure, Axes, Axes]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 5.8), dpi=DPI, facecolor="white")
    gaps = figure.add_axes((0.115, 0.42, 0.855, 0.475))
    parted = figure.add_axes((0.115, 0.105, 0.855, 0.25), sharex=gaps)
    for axes, label in ((gaps, "gap"), (parted, "parted wall pairs")):
        style_axes(axes)
        axes.grid(color="#e6e8eb", linewidth=0.8)
        axes.set_axisbelow(True)
        axes.set_ylabel(label, fontsize=11.5, color=INK)
        axes.yaxis.set_label_coords(-0.085, 0.5)
    gaps.tick_params(labelbottom=False)
    parted.set_xlabel(load_name, fontsize=11.5, color=INK)
    return figure, gaps, parted


def draw_curve(
    axes: Axes,
    load: NDArray[Any],
    values: ArrayLike,
    *,
    label: str | None,
    colour: str,
    style: Mapping[str, Any],
    width: float = 1.9,
) -> None:
    """Draw a curve in a style of `STYLES`; more than forty points are not marked."""
    marked = dict(style) if len(load) <= 40 else {**style, "marker": ""}
    axes.plot(load, values, color=colour, linewidth=width, markersize=4 if width > 1.5 else 2.5, label=label, **marked)


def _ring(axes: Axes, load: NDArray[Any], values: NDArray[Any]) -> None:
    axes.plot(load, values, "o", color=_FAILED, fillstyle="none", markersize=9, markeredgewidth=1.3)


def _scale(gaps: Axes, parted: Axes, load: NDArray[Any]) -> None:
    from matplotlib.ticker import MaxNLocator

    gaps.margins(x=0.02)
    if load.min() >= 0:
        gaps.set_xlim(left=-0.01 * (load.max() or 1.0))
    for axes in (gaps, parted):
        axes.margins(y=0.08)
    parted.yaxis.set_major_locator(MaxNLocator(nbins=5, integer=True))
    top = max(1.0, 1.12 * max(float(np.max(line.get_ydata(), initial=0.0)) for line in parted.lines))
    parted.set_ylim(-0.1 * top, top)


def _mark_onset(panels: Sequence[Axes], onset: float) -> None:
    for axes in panels:
        axes.axvline(onset, color=SOFT_INK, linewidth=1.2, linestyle=(0, (4, 3)), zorder=1)
    # Above the legend: beside the curves it would cross them.
    panels[0].annotate(
        f"vertical line: gaps grow from {onset:.3g}", (1, 1), (0, 27), xycoords="axes fraction",
        textcoords="offset points", fontsize=10, color=NOTE_INK, ha="right",
    )  # fmt: skip
