"""Tables of results: CSV files that are read, written and extended by rows, and Markdown."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path


def read(table: Path) -> list[dict[str, str]]:
    """Return the rows that are there; none where there is no file."""
    if not table.exists():
        return []
    with table.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def append(table: Path, columns: Sequence[str], rows: Iterable[Mapping[str, object]]) -> None:
    """Append rows, after a header if the table is new; entries that a row lacks stay empty."""
    table.parent.mkdir(parents=True, exist_ok=True)
    _add(table, columns, rows, is_new=not table.exists())


def write(table: Path, columns: Sequence[str], rows: Iterable[Mapping[str, object]]) -> None:
    """Write rows in place of those that are there, which are kept if it fails."""
    table.parent.mkdir(parents=True, exist_ok=True)
    new = table.with_suffix(".new")
    new.unlink(missing_ok=True)
    _add(new, columns, rows, is_new=True)
    new.replace(table)


def _add(table: Path, columns: Sequence[str], rows: Iterable[Mapping[str, object]], *, is_new: bool) -> None:
    with table.open("a", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns, restval="", lineterminator="\n")
        if is_new:
            writer.writeheader()
        writer.writerows(rows)


def markdown(columns: Sequence[str], lines: Iterable[Iterable[object]]) -> str:
    """Return a Markdown table without a newline at its end."""
    head = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    return "\n".join([*head, *("| " + " | ".join(map(str, line)) + " |" for line in lines)])
