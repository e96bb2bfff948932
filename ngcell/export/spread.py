"""The picture of all members of a case: each of them, their mean, and the band of one standard deviation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ngcell.export.cell_size import DPI
from ngcell.export.curves import load_axis
from ngcell.export.picture import INK, mark_uncertified, save_png, style_axes
from ngcell.results.spread import Member, Spread, numbers_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANELS = {"plate_force": "#1f5f8b", "energy": "#4a7a3a", "mean_gap": "#b3361e"}
_FAILED = "#d21f1f"


def draw_spread(members: Sequence[Member], spreads: Sequence[Spread], path: Path) -> Path:
    """Draw plate force, energy and mean gap over the load.

    Thin lines are members; crosses are levels at which one is not certified, which do not count.

    Parameters
    ----------
    members : sequence of Member
        At least one of them has reached a level.
    spreads : sequence of Spread
        Over those that count.
    path : Path
        The PNG file.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    found = [(level, record) for one in members for level, record in enumerate(one.levels) if record]
    load, load_name = load_axis([record for _, record in found])
    places = {level: float(place) for (level, _), place in zip(found, load, strict=True)}
    figure, panels = _canvas(load_name)
    for axes, (name, colour) in zip(panels, _PANELS.items(), strict=True):
        for member in members:
            _draw_member(axes, member, places, name, colour)
        _draw_band(axes, [row for row in spreads if row.number == name], places, colour)
        axes.set_ylabel(name.replace("_", " "), fontsize=11.5, color=INK)
    certified = sum(all(record and record.certified for record in one.levels) for one in members)
    told = f"{len(members)} members" if certified == len(members) else f"{len(members)} members, {certified} certified"
    counted = f"{told}: mean, one standard deviation, and each of them"
    panels[0].set_title(counted, fontsize=11, color=INK, loc="left", pad=14)
    if not certified:
        mark_uncertified(figure)
    return save_png(figure, path)


def _draw_member(axes: Axes, member: Member, places: Mapping[int, float], name: str, colour: str) -> None:
    reached = {level: record for level, record in enumerate(member.levels) if record}
    values = {level: numbers_of(record)[name] for level, record in reached.items()}
    axes.plot([places[level] for level in values], list(values.values()), color=colour, linewidth=0.6, alpha=0.6)
    failed = [level for level, record in reached.items() if not record.certified]
    axes.plot([places[level] for level in failed], [values[level] for level in failed], "x", color=_FAILED)


def _draw_band(axes: Axes, rows: Sequence[Spread], places: Mapping[int, float], colour: str) -> None:
    load = np.array([places[row.level] for row in rows])
    mean, deviation = (np.array([getattr(row, name) for row in rows]) for name in ("mean", "deviation"))
    axes.plot(load, mean, color=colour, linewidth=1.9, marker="o", markersize=4)
    axes.fill_between(load, mean - deviation, mean + deviation, color=colour, alpha=0.25, linewidth=0)


def _canvas(load_name: str) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 7.8), dpi=DPI, facecolor="white")
    panels: list[Axes] = []
    for number in range(len(_PANELS)):
        place = (0.13, 0.68 - 0.305 * number, 0.84, 0.27)
        panels.append(figure.add_axes(place, sharex=panels[0] if panels else None))
        style_axes(panels[-1])
        panels[-1].grid(color="#e6e8eb", linewidth=0.8)
        panels[-1].ticklabel_format(axis="y", style="sci", scilimits=(-3, 3))
        panels[-1].tick_params(labelbottom=number == len(_PANELS) - 1)
    panels[-1].set_xlabel(load_name, fontsize=11.5, color=INK)
    return figure, panels
