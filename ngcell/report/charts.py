"""Curves over the load as SVG for a page: small, sharp at any width, and readable without colour.

Each curve has its own dashes and its own marker besides its colour, and a name. A band shows the estimated error. Steps
that are not certified are crossed out in the curve, and the figure says so in words.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import hypot, isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ngcell.export.curves import load_axis, released_steps
from ngcell.export.picture import INK, style_axes
from ngcell.results.record import StepRecord

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Colours (Okabe and Ito's, for all sorts of colour vision), dashes and markers, in the order of the curves.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
_DASHES: tuple[Any, ...] = ("solid", (0, (5, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)), (0, (3, 1.5)))
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
_ALARM = "#b00020"
#: Inches; a column of a page on a desk, and the width of a telephone.
_SIZE = (4.6, 3.0)
#: More curves than this in one figure are thin and have no names.
_NAMED = 6


@dataclass(frozen=True)
class Quantity:
    """A number of a step, and where its estimated error is."""

    name: str
    title: str
    value: Callable[[StepRecord], float]
    error: Callable[[StepRecord], float]


def _column(name: str, title: str) -> Quantity:
    def value(row: StepRecord) -> float:
        return float(getattr(row, name))

    return Quantity(name, title, value, lambda row: float(getattr(row, f"{name}_error", nan)))


def plate_force(row: StepRecord) -> float:
    """Return the size of the force of the moved plate."""
    return hypot(row.plate_force_x, row.plate_force_y, row.plate_force_z)


FORCE = Quantity("plate_force", "plate force", plate_force, lambda row: row.plate_force_error)

#: What each figure of a run shows, by its heading.
FIGURES: Mapping[str, tuple[Quantity, ...]] = {
    "Energy": (_column("energy", "energy"),),
    "Plate force": (FORCE,),
    "Gaps": (_column("largest_gap", "largest gap"), _column("mean_gap", "mean gap")),
    "Parted wall pairs": (_column("parted_pairs", "parted wall pairs"),),
    "Connected components of cells": (_column("components", "connected components"),),
    "Dissipation": (_column("dissipation", "dissipation"),),
}


@dataclass(frozen=True)
class Figure:
    """A drawn figure: heading, SVG text, and what it shows in words."""

    title: str
    svg: str
    described: str


def figures_of(runs: Mapping[str, Sequence[StepRecord]], certified: Mapping[str, bool], *, key: str) -> list[Figure]:
    """Draw the curves of one run, or of several in the same axes; figures without any number are left out.

    Parameters
    ----------
    runs : mapping of str to sequence of StepRecord
        History of each run, by its name.
    certified : mapping of str to bool
        Whether each run is certified as a whole.
    key : str
        Name of these figures in the page, unlike any other's.
    """
    released = {name: rows for name, history in runs.items() if (rows := released_steps(history))}
    found = []
    for title, quantities in {**FIGURES, **_further(released.values())}.items():
        values = [quantity.value(row) for quantity in quantities for rows in released.values() for row in rows]
        if any(value for value in values if isfinite(value)):
            for one in [quantities] if len(released) == 1 else [(quantity,) for quantity in quantities]:
                heading = title if len(one) == len(quantities) else one[0].title.capitalize()
                found.append(_figure(heading, one, released, certified, key))
    return found


def _further(histories: Iterable[Sequence[StepRecord]]) -> dict[str, tuple[Quantity, ...]]:
    """Return a figure for each further column: what terms and observables of the scene report."""
    names = dict.fromkeys(name for history in histories for row in history for name in row.more)

    def value_of(name: str) -> Callable[[StepRecord], float]:
        return lambda row: float(row.more.get(name, nan))

    words = {name: name.replace("_", " ") for name in names}
    return {words[name]: (Quantity(name, words[name], value_of(name), lambda row: nan),) for name in names}


def _figure(
    title: str,
    quantities: Sequence[Quantity],
    runs: Mapping[str, Sequence[StepRecord]],
    certified: Mapping[str, bool],
    key: str,
) -> Figure:
    drawn: list[str] = []

    def draw(axes: Axes) -> None:
        many = len(quantities) * len(runs) > _NAMED
        for name, rows in runs.items():
            for quantity in quantities:
                label = quantity.title if len(runs) == 1 else _named(name, certified[name])
                drawn.append(_curve(axes, rows, quantity, label, len(drawn), thin=many))
        axes.set_xlabel(" or ".join(dict.fromkeys(load_axis(rows)[1] for rows in runs.values())), fontsize=9, color=INK)
        if axes.dataLim.x0 >= 0:
            axes.set_xlim(left=0)
        if len(drawn) > 1 and not many:
            axes.legend(frameon=False, fontsize=8.5, labelcolor=INK, handlelength=3.2)

    refused = not all(certified[name] for name in runs)
    svg = svg_of(draw, label=f"{key} {title}", refused=refused)
    return Figure(title, svg, "; ".join(drawn) if len(drawn) <= _NAMED else f"{len(drawn)} curves")


def _named(name: str, is_certified: bool) -> str:
    return name if is_certified else f"{name}, not certified"


def _curve(axes: Axes, rows: Sequence[StepRecord], quantity: Quantity, label: str, number: int, *, thin: bool) -> str:
    """Draw a curve with the band of its error, cross out what is not certified, and describe it."""
    load, axis = load_axis(rows)
    values, errors = np.array([quantity.value(row) for row in rows]), np.array([quantity.error(row) for row in rows])
    colour = _COLOURS[number % len(_COLOURS)]
    known = np.isfinite(errors)
    if known.any():
        below, above = np.where(known, values - errors, np.nan), np.where(known, values + errors, np.nan)
        axes.fill_between(load, below, above, color=colour, alpha=0.22, linewidth=0)
    draw_errors(axes, load, values, errors, number=number)
    failed = [not row.certified for row in rows]
    draw_points(axes, load, values, failed, label=label, number=number, thin=thin)
    refused = f", {sum(failed)} of them not certified" if any(failed) else ""
    ends = f"{values[0]:.3g} to {values[-1]:.3g} over {axis} {load[0]:.3g} to {load[-1]:.3g}"
    return f"{label}: {ends}, {len(rows)} levels{refused}"


def draw_errors(axes: Axes, load: ArrayLike, values: ArrayLike, errors: ArrayLike, *, number: int) -> None:
    """Draw estimated errors as bars in the colour of a curve; none where an error is not known."""
    known = np.isfinite(errors)
    if known.any():
        places = np.asarray(load)[known], np.asarray(values)[known]
        bars, colour = np.asarray(errors)[known], _COLOURS[number % len(_COLOURS)]
        axes.errorbar(*places, yerr=bars, fmt="none", ecolor=colour, elinewidth=0.8, capsize=2.5)


def draw_points(
    axes: Axes,
    load: ArrayLike,
    values: ArrayLike,
    failed: Sequence[bool],
    *,
    label: str,
    number: int,
    thin: bool = False,
    joined: bool = True,
) -> None:
    """Draw points, joined by a line of their own colour, dashes and marker, and cross out those that failed."""
    x, y, crossed = np.asarray(load), np.asarray(values), np.asarray(failed, dtype=bool)
    axes.plot(
        x, y, color=_COLOURS[number % len(_COLOURS)], linewidth=0.8 if thin else 1.7,
        linestyle=_DASHES[number % len(_DASHES)] if joined else "none",
        marker=_MARKERS[number % len(_MARKERS)], markersize=2.5 if thin else 4.5, label=label,
    )  # fmt: skip
    axes.plot(x[crossed], y[crossed], "x", color=_ALARM, markersize=9, markeredgewidth=1.8)


def svg_of(draw: Callable[[Axes], None], *, label: str, refused: bool) -> str:
    """Return the SVG of axes that a function draws into; `refused` writes across it that it is not certified."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure as Canvas

    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": label, "font.sans-serif": ["DejaVu Sans"]}):
        figure = Canvas(figsize=_SIZE, facecolor="none", layout="constrained")
        axes = figure.add_subplot()
        style_axes(axes)
        axes.tick_params(labelsize=9)
        axes.grid(color="#e6e8eb", linewidth=0.8)
        axes.set_axisbelow(True)
        draw(axes)
        _scale(axes)
        axes.yaxis.get_offset_text().set(size=9, color=INK)
        if refused:
            axes.set_title("not certified", fontsize=10, color=_ALARM, fontweight="bold", loc="right")
        text = io.StringIO()
        canvas: Any = FigureCanvasSVG(figure)  # its method is not annotated
        canvas.print_svg(text, metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return _inlined(text.getvalue(), label)


def _scale(axes: Axes) -> None:
    """Let the axes of numbers that are never negative begin at zero, and count what is counted in whole numbers."""
    from matplotlib.ticker import MaxNLocator

    values = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in axes.lines])
    whole = bool(np.all(values[np.isfinite(values)] % 1 == 0))
    axes.yaxis.set_major_locator(MaxNLocator(nbins=6, integer=whole))
    axes.xaxis.set_major_locator(MaxNLocator(nbins=7))
    axes.ticklabel_format(axis="y", style="sci", scilimits=(-3, 4), useMathText=False)
    if np.nanmin(values) >= 0:
        axes.set_ylim(0, 1.05 * axes.get_ylim()[1])


def _inlined(svg: str, label: str) -> str:
    """Return an SVG as a part of a page: no prologue, no size of its own, names that no other figure has."""
    body = svg[svg.index("<svg") :].strip()
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    used = set(re.findall(r'(?:url\(|href=")#([\w-]+)', body))
    own = re.sub(r"[^a-z0-9]", "-", label.lower())
    body = re.sub(r' id="([^"]+)"', lambda found: f' id="{own}-{found[1]}"' if found[1] in used else "", body)
    body = re.sub(r'(url\(|href=")#([\w-]+)', rf"\g<1>#{own}-\g<2>", body)
    head, rest = body[: body.index(">")], body[body.index(">") :]
    return re.sub(r' (width|height)="[^"]*"', "", head) + rest
