"""A sweep on a page: its table, and its numbers at the last level over each axis."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from math import nan
from typing import TYPE_CHECKING

from ngcell.export.summary import FIRST_CASE
from ngcell.report.charts import Figure, draw_errors, draw_points, svg_of
from ngcell.report.overall import Part
from ngcell.report.pictures import pictures_of_cases
from ngcell.report.rows import Row, Table, columns_of, value_of
from ngcell.report.sources import SWEEP_TABLE, Rows, Source, level_is_certified, run_is_certified
from ngcell.report.view import Verdict, asked

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Columns between which the keys of the axes stand.
_BEFORE, _AFTER = "case", "level"
#: Columns that tell how a run was made, which the page leaves to the table.
_NOT_SHOWN = {"attempts", "seconds", "processor_seconds", "memory_gib", "host", "ngcell", "ngsolve", "key"}
#: Numbers that are drawn over the axes, if the table has them, before others.
_FIRST = ("energy", "plate_force_x", "plate_force_y", "contact_force", "mean_gap", "largest_gap", "parted_pairs",
          "components")  # fmt: skip
#: Column of the estimated error of a number that is not called as the number is.
_ERROR = {"plate_force_x": "plate_force_error", "plate_force_y": "plate_force_error"}
#: Most rows that the page shows, most curves of one figure, and most numbers that are drawn over an axis.
_MOST_ROWS, _MOST_CURVES, _MOST_NUMBERS = 3000, 6, 8


def sweep_part(source: Source, key: str) -> Part:
    """Return verdict, figures and table of a sweep."""
    rows, names = source.rows, [name for name in (source.rows[0] if source.rows else ()) if name not in _NOT_SHOWN]
    refused = not source.certified
    last = list({row.get("case", ""): row for row in rows}.values())
    pictures = list(pictures_of_cases(source, last, axes_of(names)))
    return Part(
        key=key,
        title="Sweep",
        refused=refused,
        verdict=Verdict(source.certified, [*_said(source, last), *source.unread]),
        lines=[f"{_POINTS} {_errors_said(last)}"] if last else [],
        figures=list(_figures(last, axes_of(names), key)),
        tables=[_table(rows, last, names, key)] if rows else [],
        asked=list(asked(source.summary.get("study") or {})),
        figures_first=True,
        pictures=pictures,
        pictured=f"Tissues of {len(pictures)} of {len(last)} cases at the last level that they reached",
        case_title="The first of the cases, fully resolved",
        case_text=str(source.summary.get(FIRST_CASE) or ""),
        effort=list(_effort(rows, last)),
    )


_POINTS = "Each point is the last level of a run; a red cross marks one that is not certified."


def _errors_said(last: Rows) -> str:
    """Return whether errors are shown, and if not, why."""
    named = [name for name in last[0] if name.endswith("_error")]
    if any(_number(row.get(name)) is not None for row in last for name in named):
        return "Bars are estimated errors."
    return "Errors are not estimated." if named else "Estimated errors are not among the outputs of this study."


def _effort(rows: Rows, last: Rows) -> Iterator[tuple[str, str]]:
    """Yield what the runs took together, and by which versions they were made."""
    seconds = [value for row in last if (value := _number(row.get("processor_seconds"))) is not None]
    if seconds:
        yield "time", f"{sum(seconds):.0f} s of the processor for {len(seconds)} runs"
    for name in ("ngcell", "ngsolve"):
        if versions := sorted({row[name] for row in rows if row.get(name)}):
            yield name, ", ".join(versions)


def axes_of(names: Sequence[str]) -> list[str]:
    """Return the names of the columns that say what was varied."""
    if _BEFORE not in names or _AFTER not in names:
        return []
    return list(names[names.index(_BEFORE) + 1 : names.index(_AFTER)])


def _said(source: Source, last: Rows) -> Iterator[str]:
    told = source.summary.get("sweep") or {}
    counted = Counter(row.get("outcome") or "no outcome" for row in last)
    yield (
        f"{len(last)} of {told.get('cases', len(last))} cases have ended: "
        + ", ".join(f"{count} {outcome}" for outcome, count in counted.most_common())
        + "."
    )
    failed = sum(not level_is_certified(row) for row in source.rows)
    if failed:
        yield f"{failed} of {len(source.rows)} rows of the table are not certified."


def _table(rows: Rows, last: Rows, names: Sequence[str], key: str) -> Table:
    note = ""
    if len(rows) > _MOST_ROWS:
        rows = last[:_MOST_ROWS]
        note = f"The last level of {len(rows)} cases, to keep this page small; {SWEEP_TABLE} holds all."
    cells = [Row([value_of(row.get(name)) for name in names], refused=not level_is_certified(row)) for row in rows]
    words = {name for place, name in enumerate(names) if any(row.cells[place].kind == "text" for row in cells)}
    return Table(f"{key}-table", "Runs and levels", columns_of(names, words), cells, note=note)


def _figures(last: Rows, axes: Sequence[str], key: str) -> Iterator[Figure]:
    """Yield each number over each axis of numbers that is varied; what else is varied tells curves apart."""
    drawn = _drawn(last)
    for axis in axes:
        points = [row for row in last if _number(row.get(axis)) is not None]
        if len({row[axis] for row in points}) < 2:
            continue
        others = [name for name in axes if name != axis and len({row[name] for row in points}) > 1]
        for name in drawn:
            shown = [row for row in points if _number(row.get(name)) is not None]
            if any(_number(row[name]) for row in shown):
                yield _figure(shown, axis, name, others, key)


def _drawn(last: Rows) -> list[str]:
    """Return the outputs that are drawn: numbers, the best known first."""
    names = list(last[0]) if last else []
    if "load_factor" not in names or "certified" not in names:
        return []
    outputs = names[names.index("load_factor") + 1 : names.index("certified")]
    numbers = [name for name in outputs if not name.endswith("_error")]
    known = [name for name in _FIRST if name in numbers]
    return [*known, *(name for name in numbers if name not in known)][:_MOST_NUMBERS]


def _figure(points: Rows, axis: str, name: str, others: Sequence[str], key: str) -> Figure:
    groups: dict[str, list[Mapping[str, str]]] = {}
    for row in points:
        groups.setdefault(", ".join(f"{other.rpartition('.')[2]} {row[other]}" for other in others), []).append(row)
    named = len(groups) <= _MOST_CURVES
    title = f"{name.replace('_', ' ')} over {axis}"

    def draw(axes: Axes) -> None:
        for number, (label, rows) in enumerate(groups.items()):
            rows = sorted(rows, key=lambda row: float(row[axis]))
            places, values = [float(row[axis]) for row in rows], [float(row[name]) for row in rows]
            draw_errors(axes, places, values, [_error(row, name) for row in rows], number=number)
            draw_points(
                axes,
                places,
                values,
                [not run_is_certified(row) for row in rows],
                label=label,
                number=number,
                joined=named,
            )
        axes.set_xlabel(axis, fontsize=9)
        if named and others:
            axes.legend(frameon=False, fontsize=8)

    refused = any(not run_is_certified(row) for row in points)
    values = [float(row[name]) for row in points]
    described = f"{len(points)} runs, {min(values):.3g} to {max(values):.3g}"
    return Figure(title, svg_of(draw, label=f"{key} {title}", refused=refused), described)


def _error(row: Mapping[str, str], name: str) -> float:
    """Return the estimated error of a number; NaN where there is none."""
    error = _number(row.get(_ERROR.get(name, f"{name}_error")))
    return nan if error is None else error


def _number(text: str | None) -> float | None:
    try:
        value = float(text or "nan")
    except ValueError:
        return None
    return value if value == value else None
