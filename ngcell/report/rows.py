"""Tables of the page: columns with headings, and cells that can be sorted by their numbers."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from math import isfinite
from typing import Any

from ngcell.report.charts import FORCE
from ngcell.results.verdict import with_error

#: A table of more rows than this shows the last level only.
_MOST_ROWS = 6000


@dataclass(frozen=True)
class Column:
    """Heading of a column, and whether it holds words."""

    title: str
    is_text: bool = False


@dataclass(frozen=True)
class Cell:
    """What a cell shows, the number that it is sorted by, if any, and how it is set."""

    text: str
    value: float | None = None
    kind: str = ""


@dataclass(frozen=True)
class Row:
    """Cells of a row, the level that it belongs to, and whether it is marked as not certified."""

    cells: Sequence[Cell]
    level: str = ""
    refused: bool = False


@dataclass(frozen=True)
class Table:
    """A table of the page, and the levels that may be chosen."""

    key: str
    title: str
    columns: Sequence[Column]
    rows: Sequence[Row]
    levels: Sequence[tuple[str, str]] = ()
    note: str = ""
    sortable: bool = True


def number(value: object) -> str:
    """Return a number in four digits; a dash where there is none."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    if not isinstance(value, float) or not isfinite(value):
        return "–" if value is None or isinstance(value, float) else str(value)
    return f"{value:.4g}"


def cell_of(value: object, kind: str = "") -> Cell:
    """Return the cell of a value: one that is sorted by its number if it has one."""
    if isinstance(value, (int, float)):
        return Cell(number(value), float(f"{value:.9g}") if isfinite(value) else None, kind)
    if value is None:
        return Cell(number(value), None, kind)
    return Cell(number(value), None, kind or "text")


def checks_table(key: str, summary: Mapping[str, Any]) -> list[Table]:
    """Return the checks of the certificate, those that failed first; no table where there are none."""
    checks = {name: one for name, one in (summary.get("certificate") or {}).items() if isinstance(one, Mapping)}
    meaning = summary.get("meaning_of_checks") or {}
    columns = columns_of(("check", "verdict", "worst", "limit", "meaning"), ("check", "verdict", "meaning"))
    rows = [
        Row(
            [
                Cell(name.replace("_", " "), None, "text"),
                Cell("passed" if one.get("passed") else "NOT PASSED", None, "text"),
                cell_of(one.get("worst")),
                cell_of(one.get("limit")),
                Cell("; ".join(filter(None, [meaning.get(name, ""), one.get("place", "")])), None, "long text"),
            ],
            refused=not one.get("passed"),
        )
        for name, one in sorted(checks.items(), key=lambda item: bool(item[1].get("passed")))
    ]
    return [Table(f"{key}-checks", "Checks of the certificate", columns, rows)] if rows else []


def expected_table(key: str, summary: Mapping[str, Any]) -> list[Table]:
    """Return measured beside expected numbers; no table where the case expects none."""
    columns = columns_of(_EXPECTED, ("quantity", "verdict", "origin"))
    rows = [
        Row(
            [
                Cell(" ".join(filter(None, [one["quantity"].replace("_", " "), one.get("place")])), None, "text"),
                Cell("met" if one["passed"] else "NOT MET", None, "text"),
                *(cell_of(one.get(name)) for name in ("load_factor", "measured", "expected", "deviation", "tolerance")),
                Cell(str(one.get("origin", "")), None, "long text"),
            ],
            refused=not one["passed"],
        )
        for one in summary.get("expected") or ()
    ]
    return [Table(f"{key}-expected", "Expected numbers", columns, rows)] if rows else []


_EXPECTED = ("quantity", "verdict", "load factor", "measured", "expected", "deviation", "tolerance", "origin")


def records_table(key: str, title: str, records: Sequence[Any], *, refused: Iterable[int] = ()) -> list[Table]:
    """Return rows of `walls.csv` or `cells.csv`, with their levels to choose from; none where there are no records.

    Parameters
    ----------
    key, title : str
        Name of the table in the page, and its heading.
    records : sequence of WallRecord or CellRecord
        The rows.
    refused : iterable of int
        Steps that are not certified.
    """
    if not records:
        return []
    not_certified, note = set(refused), ""
    if len(records) > _MOST_ROWS:
        records = [one for one in records if one.step == records[-1].step]
        note = "The last level only, to keep this page small."
    names = [one.name for one in fields(records[0]) if one.name not in _NOT_SHOWN]
    more = list(getattr(records[0], "more", {}))
    rows = [
        Row(
            [*(cell_of(getattr(one, name)) for name in names), *(cell_of(one.more.get(name)) for name in more)],
            str(one.step),
            one.step in not_certified,
        )
        for one in records
    ]
    levels = {str(one.step): _level_words(one, one.step in not_certified) for one in records}
    columns = columns_of([*names, *more], ())
    return [Table(key, title, columns, rows, list(levels.items()), note)]


#: Columns of walls and cells that the choice of the level tells, and the field of the further ones.
_NOT_SHOWN = ("step", "load_factor", "plate_displacement", "more")


def _level_words(record: Any, refused: bool) -> str:
    return f"load factor {record.load_factor:.4g}{', not certified' if refused else ''}"


#: Columns of the table of levels: numbers of a step, with errors and without.
_OF_LEVELS = ("energy", "contact_force", "mean_gap", "largest_gap")
_COUNTS = ("parted_pairs", "components", "iterations", "seconds")


def levels_table(key: str, history: Sequence[Any]) -> list[Table]:
    """Return the numbers of the released steps, each with its estimated error."""
    rows = []
    for one in history:
        values = {name: (getattr(one, name), getattr(one, f"{name}_error")) for name in _OF_LEVELS}
        values["plate_force"] = (FORCE.value(one), FORCE.error(one))
        told = [Cell(with_error(value, error), value) for value, error in values.values()]
        counts = [*(cell_of(getattr(one, name)) for name in _COUNTS), *map(cell_of, one.more.values())]
        verdict = Cell("certified" if one.certified else "NOT CERTIFIED", None, "text")
        place = [cell_of(one.load_factor), cell_of(one.plate_displacement), verdict]
        rows.append(Row([*place, *told, *counts], refused=not one.certified))
    names = [
        "load_factor",
        "plate_displacement",
        "verdict",
        *_OF_LEVELS,
        "plate_force",
        *_COUNTS,
        *(history[0].more if history else ()),
    ]
    columns = columns_of(names, ("verdict",))
    return [Table(f"{key}-levels", "Numbers of each level", columns, rows)] if rows else []


def columns_of(names: Iterable[str], words: Container[str]) -> list[Column]:
    """Return columns with these headings, and which of them hold words."""
    return [Column(name.replace("_", " "), name in words) for name in names]


def value_of(text: str | None) -> Cell:
    """Return the cell of a text in a table: a number where it is one."""
    if text in ("True", "False"):
        return Cell("yes" if text == "True" else "NO", None, "text")
    try:
        value = float(text or "nan")
    except ValueError:
        return Cell((text or "").replace("_", " "), None, "text")
    return cell_of(int(value) if isfinite(value) and "." not in (text or "") and value.is_integer() else value)
