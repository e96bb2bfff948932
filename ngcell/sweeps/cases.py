"""The cases of a study: every combination of a point of each axis, the last axis fastest."""

from __future__ import annotations

from collections.abc import Iterator
from math import prod
from typing import Any

import numpy as np

from ngcell.errors import CaseError
from ngcell.scene import AnyCase, find_case
from ngcell.scene.inheritance import read_table
from ngcell.scene.overrides import Setting
from ngcell.scene.reader import variant
from ngcell.scene.study_reader import WrittenStudy
from ngcell.sweeps.axis import Point

#: Kinds of axes whose points nobody has written down: one that is no case is a run that is refused.
_DRAWN = {"random", "latin-hypercube"}


class Cases:
    """The cases of a study by their number, made when they are asked for.

    Parameters
    ----------
    written : WrittenStudy
        The study.

    Attributes
    ----------
    shape : tuple of int
        Number of points of each axis.

    Raises
    ------
    CaseError
        There is no such case to vary.
    """

    def __init__(self, written: WrittenStudy) -> None:
        self.written, axes = written, written.study.axes
        try:
            file = find_case(written.study.case)
        except CaseError as error:
            raise CaseError(f"{written.where('case')}: case: {error}") from None
        self._file, self._said, self._fixed = str(file), read_table(file), written.fixed
        self._keys = {name: axis.keys(name) for name, axis in axes.items()}
        self._points: dict[str, tuple[Point, ...]] = {name: axis.points() for name, axis in axes.items()}
        self._is_drawn = [getattr(axis, "kind", "") in _DRAWN for axis in axes.values()]
        self.shape = tuple(len(points) for points in self._points.values())

    def __len__(self) -> int:
        return prod(self.shape)

    def place(self, number: int) -> tuple[int, ...]:
        """Return the number of the point on each axis."""
        return tuple(int(part) for part in np.unravel_index(number, self.shape))

    def values(self, number: int) -> dict[str, Any]:
        """Return what varies, by dotted key."""
        return {key: value for _, key, value in self._chosen(number)}

    def case(self, number: int) -> AnyCase:
        """Return a case.

        Raises
        ------
        CaseError
            These values make no case; a line for each mistake.
        """
        settings = sorted((*self._fixed, *self._settings(number)), key=lambda setting: len(setting.path))
        return variant(self._file, self._said, settings)  # a table comes before what is set in it

    def check(self, refused: dict[int, str]) -> None:
        """Refuse a value of an axis that somebody has written down and that makes no case, whatever the others are.

        Parameters
        ----------
        refused : dict of int to str
            Why, for each number that is no case.

        Raises
        ------
        CaseError
            There is such a value, or no case at all.
        """
        if len(refused) == len(self):
            raise CaseError(_first_line(refused[0]))
        counts = [np.zeros(size, dtype=int) for size in self.shape]
        first: dict[tuple[int, int], int] = {}
        for number in refused:
            for axis, point in enumerate(self.place(number)):
                counts[axis][point] += 1
                first.setdefault((axis, point), number)
        for (axis, point), number in first.items():
            if counts[axis][point] == len(self) // self.shape[axis] and not self._is_drawn[axis]:
                raise CaseError(_first_line(refused[number]))

    @property
    def coordinates(self) -> list[dict[str, Any]]:
        """Name and keys of each axis, with the values of each key."""
        return [
            {"name": name, "values": dict(zip(keys, map(list, zip(*self._points[name], strict=True)), strict=True))}
            for name, keys in self._keys.items()
        ]

    def _settings(self, number: int) -> Iterator[Setting]:
        for name, key, value in self._chosen(number):
            yield self.written.setting(key, value, "axes", name)

    def _chosen(self, number: int) -> Iterator[tuple[str, str, Any]]:
        for (name, keys), point in zip(self._keys.items(), self.place(number), strict=True):
            for key, value in zip(keys, self._points[name][point], strict=True):
                yield name, key, value


def _first_line(message: str) -> str:
    return message.splitlines()[0]
