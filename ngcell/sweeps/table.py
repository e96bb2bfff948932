"""The table of a sweep: a row for each run and level, in the order of the cases, as Parquet and as CSV.

It is made from the store in parts, so that a table of any length takes the memory of one part.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from itertools import islice
from math import isfinite
from pathlib import Path
from typing import Any, get_type_hints

from ngcell.errors import CaseError
from ngcell.export.atomic import output_errors
from ngcell.results.record import StepRecord
from ngcell.sweeps.ending import Ending
from ngcell.sweeps.extra import needed
from ngcell.sweeps.task import Result

PARQUET, CSV = "sweep.parquet", "sweep.csv"
#: Key of what the Parquet file, and the attributes of the table, say of the axes.
AXES = "axes"
#: Columns of `history.csv` that are no output: said by others, or not of a level.
_NOT_WANTED = {"step", "phase", "load_factor", "certified", "seconds", "more"}
_BEFORE = {"case": int}
_LEVEL = {"level": int, "load_factor": float}
_AFTER = {
    "certified": bool, "outcome": str, "detail": str, "failed_checks": str, "unknowns": int, "attempts": int,
    "seconds": float, "processor_seconds": float, "memory_gib": float, "host": str, "ngcell": str, "ngsolve": str,
    "key": str,
}  # fmt: skip
#: Columns that tell how a run was made: they differ between two runs of one case.
PROVENANCE = ("attempts", "seconds", "processor_seconds", "memory_gib", "host")
_PART = 1000
#: Whole numbers of a column are below this.
_MOST = 2**63

Row = dict[str, Any]


def known_outputs() -> dict[str, type]:
    """Return the outputs that every run has, with their types."""
    hints = get_type_hints(StepRecord)
    return {each.name: hints[each.name] for each in fields(StepRecord) if each.name not in _NOT_WANTED}


class Table:
    """Columns of a sweep, and how they are written.

    Parameters
    ----------
    axes : sequence of table
        Name of each axis, and the values of its keys.
    outputs : sequence of str
        Columns of `history.csv`.

    Raises
    ------
    CaseError
        An axis has the name of a column.
    """

    def __init__(self, axes: Sequence[Mapping[str, Any]], outputs: Sequence[str]) -> None:
        self._axes, known = axes, known_outputs()
        varied = {key: _type_of(values) for axis in axes for key, values in axis["values"].items()}
        chosen = {name: known.get(name, float) for name in outputs}
        self.columns: dict[str, type] = {**_BEFORE, **varied, **_LEVEL, **chosen, **_AFTER}
        for name in (axis["name"] for axis in axes):
            if name in self.columns and name not in varied:
                raise CaseError(f"axes.{name}: the table has a column of this name; allowed: another name")
        self._varied, self._outputs = varied, chosen

    def rows(self, number: int, values: Mapping[str, Any], result: Result) -> Iterator[Row]:
        """Yield the rows of a case: one for each level, or one without level where nobody knows the levels."""
        shown = {key: value if self._varied[key] is not str or isinstance(value, str) else json.dumps(value)
                 for key, value in values.items()}  # fmt: skip
        told = {name: result.get(name) for name in _AFTER}
        told["failed_checks"] = ", ".join(result.get("failed_checks", ()))
        for level, found in enumerate(result.get("levels") or [None]):
            step = (found or {}).get("step") or {}
            place: Row = {"level": None, "load_factor": None}
            if found is not None:
                place = {"level": level, "load_factor": found["load_factor"]}
            numbers = {name: step.get(name) for name in self._outputs}
            yield {"case": number, **shown, **place, **numbers, **told, "certified": bool(step.get("certified"))}

    def write(self, folder: Path, rows: Iterable[Row]) -> None:
        """Write both tables of all rows, in full or not at all.

        Raises
        ------
        OutputError
            They cannot be written.
        """
        pyarrow, parquet = needed("pyarrow"), needed("pyarrow.parquet")
        types = {int: pyarrow.int64(), float: pyarrow.float64(), bool: pyarrow.bool_(), str: pyarrow.string()}
        schema = pyarrow.schema([(name, types[kind]) for name, kind in self.columns.items()])
        schema = schema.with_metadata({AXES: json.dumps(self._axes)})
        drafts = {name: folder / f".{name}.tmp" for name in (PARQUET, CSV)}
        with output_errors(folder):
            with (
                parquet.ParquetWriter(drafts[PARQUET], schema) as writer,
                drafts[CSV].open("w", newline="", encoding="utf-8") as file,
            ):
                lines = csv.DictWriter(file, list(self.columns), lineterminator="\n")
                lines.writeheader()
                for part in _parts(rows):
                    lines.writerows(part)
                    writer.write_table(pyarrow.Table.from_pylist([self._typed(row) for row in part], schema))
            for name, draft in drafts.items():
                os.replace(draft, folder / name)

    def _typed(self, row: Row) -> Row:
        return {name: _of_kind(row[name], kind) for name, kind in self.columns.items()}


def _of_kind(value: Any, kind: type) -> Any:
    """Return a value as one of a kind; None where there is none, or where nothing of that kind stands for it."""
    is_nan = kind is int and isinstance(value, float) and not isfinite(value)
    return None if value is None or is_nan else kind(value)


def refused(why: str) -> Result:
    """Return the result of a case that is none."""
    return {"outcome": Ending.REFUSED.told, "detail": " ".join(why.split()), "attempts": 0}


def read_table(folder: Path) -> Any:
    """Return the table of a sweep (pandas), with what it says of the axes in its attributes.

    Raises
    ------
    OutputError
        There is none.
    """
    parquet, file = needed("pyarrow.parquet"), Path(folder) / PARQUET
    needed("pandas")
    with output_errors(file):
        found = parquet.read_table(file)
    table = found.to_pandas()
    table.attrs[AXES] = json.loads(found.schema.metadata[AXES.encode()])
    return table


def _parts(rows: Iterable[Row]) -> Iterator[list[Row]]:
    waiting = iter(rows)
    while part := list(islice(waiting, _PART)):
        yield part


def _type_of(values: Sequence[Any]) -> type:
    """Return the type of a column: that of all values, else their text."""
    kinds = {type(value) for value in values}
    if kinds == {int} and not all(-_MOST <= value < _MOST for value in values):
        return str
    if kinds in ({int}, {bool}, {float}):
        return next(iter(kinds))
    return float if kinds == {int, float} else str
