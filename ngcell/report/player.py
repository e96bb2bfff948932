"""The deformed tissue as the page draws it: places and fields at each level, in few bytes.

Numbers are rounded to 16 bits of their range, which is below what a screen shows, and deflated. Where all fields at all
levels are too many bytes, the last of the fields are left out first, then levels, and the page says which.
"""

from __future__ import annotations

import zlib
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ngcell.export.outline import bodies_that_are
from ngcell.report.fields import BODIES, Field, fields_of
from ngcell.report.surface import Surface, is_of_rigid, is_solid, surface_of, wall_lines, wall_triangles
from ngcell.results.snapshot import Grid, Snapshot

Array = NDArray[np.float64]

#: Number that stands for "none".
_NONE = 65535
#: Shares of the points below and above which colours do not change any more.
_PERCENTILES = (0.5, 99.5)
#: Fewest fields and levels that are kept, however large they are.
_FEWEST_FIELDS, _FEWEST_LEVELS = 3, 2


@dataclass(frozen=True, eq=False)
class _Level:
    """What is drawn at one level: the state, its fields by name, and the places of the points that are seen."""

    snapshot: Snapshot
    certified: bool
    fields: Mapping[str, Field]
    shape: str
    places: Array
    wall_places: Array


@dataclass
class Player:
    """The data of a deformed tissue, for the script of the page.

    Attributes
    ----------
    data : dict of str to Any
        What the script reads, as JSON holds it; empty where there is nothing to draw.
    left_out : list of str
        One line for each thing that was left out to keep the page small.
    """

    data: dict[str, Any] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    @property
    def size(self) -> int:
        """Length of its numbers in the page [byte]."""
        return _length(self.data.get("shapes", {})) + _length(self.data.get("levels", []))


def player_of(snapshots: Iterable[tuple[Snapshot, bool]], budget: int) -> Player:
    """Return what a page needs to draw snapshots.

    Parameters
    ----------
    snapshots : iterable of (Snapshot, bool)
        Each with whether its step is certified.
    budget : int
        Bytes that it may have, as far as two levels of three fields fit.
    """
    shapes: dict[str, tuple[Surface, dict[str, Any]]] = {}
    levels = [_level(snapshot, certified, shapes) for snapshot, certified in snapshots]
    if not levels:
        return Player()
    names = [name for name in levels[-1].fields if all(name in level.fields for level in levels)]
    window = _window([level.places for level in levels])
    encoded = [_encoded_level(level, names, window, _ranges(levels, names)) for level in levels]
    common = sum(_length(drawn) for _, drawn in shapes.values())
    kept, numbers, left_out = _fitting(encoded, names, budget - common)
    titles = {name: levels[-1].fields[name].title for name in names}
    data = {
        "solid": is_solid(levels[0].snapshot.bulk),
        "window": [list(end) for end in window],
        "shapes": {key: drawn for key, (_, drawn) in shapes.items() if any(levels[n].shape == key for n in numbers)},
        "fields": [_told_field(levels, name) for name in kept],
        "levels": [_of_fields(encoded[number], kept) for number in numbers],
    }
    lost = [titles[name] for name in names if name not in kept]
    said = [f"fields left out to keep this page small: {', '.join(lost)}"] if lost else []
    return Player(data, said + left_out)


def _level(snapshot: Snapshot, certified: bool, shapes: dict[str, tuple[Surface, dict[str, Any]]]) -> _Level:
    key = str(zlib.crc32(snapshot.bulk.points.tobytes() + np.ascontiguousarray(snapshot.bulk.cells).tobytes()))
    if key not in shapes:
        surface = surface_of(snapshot.bulk)
        shapes[key] = surface, _drawn_shape(surface, snapshot)
    surface, _ = shapes[key]
    rigid = is_of_rigid(snapshot.bulk)
    fields = {one.name: _seen(one, surface, rigid) for one in fields_of(snapshot)}
    return _Level(snapshot, certified, fields, key, _moved(snapshot.bulk)[surface.points], _moved(snapshot.walls))


def _seen(one: Field, surface: Surface, rigid: NDArray[np.bool_]) -> Field:
    """Return a field at the points that are drawn, none in rigid bodies; of walls all points are."""
    if one.where != BODIES:
        return one
    return replace(one, values=np.where(rigid, np.nan, one.values)[surface.points])


def _drawn_shape(surface: Surface, snapshot: Snapshot) -> dict[str, Any]:
    solid = is_solid(snapshot.bulk)
    walls = wall_triangles(snapshot.walls) if solid else wall_lines(snapshot.walls)
    return {
        "triangles": _packed(surface.triangles, "<u4"),
        "lines": _packed(surface.lines, "<u4"),
        "owner": _packed(surface.owner, "<u2"),
        "loops": _packed(_ended(surface.loops), "<i4"),
        "rigid": _packed(_ended(surface.rigid), "<i4"),
        "walls": _packed(walls, "<u4"),
    }


def _ended(loops: Sequence[NDArray[np.integer]]) -> NDArray[np.integer]:
    """Return loops one after the other, each followed by -1."""
    return np.concatenate([np.append(loop, -1) for loop in loops] or [np.zeros(0, dtype=np.int64)])


def _encoded_level(
    level: _Level, names: Sequence[str], window: tuple[Array, Array], ranges: Mapping[str, tuple[float, float]]
) -> dict[str, Any]:
    low, high = window
    state = level.snapshot
    return {
        "step": state.step,
        "load_factor": state.load_factor,
        "plate_displacement": state.plate_displacement,
        "certified": level.certified,
        "shape": level.shape,
        "free": sorted(bodies_that_are("free", state.bulk)),
        "places": _rounded(level.places.T, low[:, None], high[:, None]),
        "wall_places": _rounded(level.wall_places.T, low[:, None], high[:, None]),
        "values": {name: _rounded(level.fields[name].values, *ranges[name]) for name in names},
    }


def _fitting(
    encoded: Sequence[Mapping[str, Any]], names: Sequence[str], budget: int
) -> tuple[list[str], list[int], list[str]]:
    """Return the fields and the numbers of the levels that fit, and what is said of the others."""
    kept, numbers = list(names), list(range(len(encoded)))

    def size() -> int:
        return sum(_length(_of_fields(encoded[number], kept)) for number in numbers)

    while size() > budget and len(kept) > _FEWEST_FIELDS:
        kept.pop()
    while size() > budget and len(numbers) > _FEWEST_LEVELS:
        numbers = numbers[-1::-2][::-1]  # every second one, the last included
    if len(numbers) == len(encoded):
        return kept, numbers, []
    return kept, numbers, [f"{len(numbers)} of {len(encoded)} levels are shown, to keep this page small"]


def _of_fields(level: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    return {**level, "values": {name: level["values"][name] for name in names}}


def _told_field(levels: Sequence[_Level], name: str) -> dict[str, Any]:
    """Return name, heading and range of a field over all levels, and the range that its colours span."""
    low, high = _ranges(levels, [name])[name]
    values = np.concatenate([level.fields[name].values for level in levels])
    values = values[np.isfinite(values)]
    span = np.percentile(values, _PERCENTILES) if len(values) else (0.0, 1.0)
    one = levels[-1].fields[name]
    return {
        "name": name, "title": one.title, "where": one.where, "smallest": low, "largest": high,
        "from": float(span[0]), "to": float(span[1]),
    }  # fmt: skip


def _ranges(levels: Sequence[_Level], names: Sequence[str]) -> dict[str, tuple[float, float]]:
    found = {}
    for name in names:
        values = np.concatenate([level.fields[name].values for level in levels])
        values = values[np.isfinite(values)]
        found[name] = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    return found


def _window(places: Sequence[Array]) -> tuple[Array, Array]:
    return np.min([one.min(0) for one in places], axis=0), np.max([one.max(0) for one in places], axis=0)


def _moved(grid: Grid) -> Array:
    return np.asarray(grid.points + grid.point_data["displacement"])


def _rounded(values: Array, low: float | Array, high: float | Array) -> str:
    """Return values as 16-bit shares of their range, the last number where there is none."""
    width = np.where(np.asarray(high) > low, np.subtract(high, low), 1.0)
    share = np.clip((values - low) / width, 0.0, 1.0)
    return _packed(np.where(np.isfinite(share), np.round(np.nan_to_num(share) * (_NONE - 1)), _NONE), "<u2")


def _packed(values: NDArray[Any], kind: str) -> str:
    """Return numbers of a kind, deflated, in characters that a page may hold.

    Bytes of equal weight stand together, and of each number only the difference to the one before: both deflate better.
    """
    flat = np.ascontiguousarray(values).ravel().astype(kind)
    steps = np.diff(flat, prepend=flat.dtype.type(0)).astype(kind)
    return b64encode(zlib.compress(steps.view("u1").reshape(-1, steps.itemsize).T.tobytes(), 9)).decode()


def _length(data: Any) -> int:
    """Return the length of all texts in nested tables and lists."""
    if isinstance(data, str):
        return len(data)
    parts = data.values() if isinstance(data, Mapping) else data if isinstance(data, list) else ()
    return sum(map(_length, parts))
