"""The table of a sweep on its axes: an array for each column (xarray)."""

from __future__ import annotations

import json
from math import prod
from typing import Any

import numpy as np

from ngcell.errors import CaseError
from ngcell.sweeps.extra import needed
from ngcell.sweeps.table import AXES


def table_to_xarray(table: Any) -> Any:
    """Return the table of a sweep as an xarray dataset on its axes.

    Parameters
    ----------
    table : pandas.DataFrame
        What `ngcell.sweep` or `ngcell.read_sweep` returned, or some of its rows.

    Returns
    -------
    xarray.Dataset
        Dimensions are the axes, by name, and `level`. An axis over one key has its values as coordinate; one over
        several keys is numbered, and each key is a coordinate along it. Where there is no row a number is NaN, and an
        outcome is empty.

    Raises
    ------
    CaseError
        The table does not say which axes it has.
    """
    xarray, axes = needed("xarray"), table.attrs.get(AXES)
    if axes is None:
        raise CaseError("the table does not tell its axes; allowed: one that ngcell.sweep or read_sweep returned")
    keys = [list(axis["values"]) for axis in axes]
    sizes = [len(axis["values"][own[0]]) for axis, own in zip(axes, keys, strict=True)]
    levels = int(table["level"].max()) + 1 if table["level"].notna().any() else 1
    case, level = table["case"].to_numpy(dtype=int), table["level"].fillna(0).to_numpy(dtype=int)
    place = (*np.unravel_index(case, sizes), level)
    names = [axis["name"] for axis in axes]
    varied = {key for own in keys for key in own}
    columns = [name for name in table.columns if name not in varied | {"case", "level"}]
    data = {name: ([*names, "level"], _on_axes(table[name], place, (*sizes, levels))) for name in columns}
    data["case"] = (names, np.arange(prod(sizes)).reshape(sizes))
    return xarray.Dataset(data, coords={**_coordinates(axes), "level": np.arange(levels)})


def _on_axes(column: Any, place: tuple[Any, ...], shape: tuple[int, ...]) -> Any:
    """Return an array of a column."""
    values = column.to_numpy()
    if values.dtype.kind in "iuf":
        found = np.full(shape, np.nan)
    elif values.dtype.kind == "b":
        found = np.zeros(shape, dtype=bool)
    else:
        found = np.full(shape, "", dtype=object)
        values = np.array(["" if value is None or value != value else value for value in values], dtype=object)
    found[place] = values
    return found


def _coordinates(axes: list[dict[str, Any]]) -> dict[str, Any]:
    """Return values along each axis; a value that is no number or text is its JSON text."""
    found: dict[str, Any] = {}
    for axis in axes:
        for key, values in axis["values"].items():
            plain = [value if isinstance(value, (int, float, str)) else json.dumps(value) for value in values]
            found[key] = (axis["name"], plain)
    return found
