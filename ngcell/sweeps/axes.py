"""Kinds of axes over one key: listed, evenly spaced, or drawn from a seed."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, Strict, ValidationInfo, field_validator

from ngcell.scene.scope import refuse
from ngcell.scene.section import PositiveNumber, Section
from ngcell.sweeps.axis import Point

Number = int | float
Seed = Annotated[int, Field(ge=0)]
#: How many points an axis may have that nobody has written down one by one.
Count = Annotated[int, Field(ge=1, le=100_000)]


class OverOneKey(Section):
    """An axis whose name is the key that varies."""

    def keys(self, name: str) -> tuple[str, ...]:
        """Return the dotted key that varies along the axis of this name."""
        return (name,)


class Grid(OverOneKey):
    """Values one by one.

    Parameters
    ----------
    values : list
        The values, of whatever sort the key takes.
    """

    kind: Literal["grid"] = "grid"
    values: Annotated[tuple[Any, ...], Strict(False)]

    @field_validator("values")
    @classmethod
    def _not_empty(cls, values: tuple[Any, ...]) -> tuple[Any, ...]:
        if not values:
            refuse("is empty; allowed: a list of at least one value")
        return values

    def points(self) -> tuple[Point, ...]:
        """Return the values."""
        return tuple((value,) for value in self.values)


class Range(OverOneKey):
    """Evenly spaced numbers, both ends included; whole ones where they fall on whole numbers and both ends are whole.

    Parameters
    ----------
    start, stop : float
        The ends.
    number : int
        How many, from 1 to 100 000.
    """

    kind: Literal["range"] = "range"
    start: Number
    stop: Number
    number: Count

    def points(self) -> tuple[Point, ...]:
        """Return the numbers."""
        found = np.linspace(self.start, self.stop, self.number).tolist()
        whole = isinstance(self.start, int) and isinstance(self.stop, int)
        whole = whole and (self.stop - self.start) % max(1, self.number - 1) == 0
        return tuple((round(value) if whole else value,) for value in found)


class LogRange(OverOneKey):
    """Numbers of which each is the same multiple of the one before, both ends included.

    Parameters
    ----------
    start, stop : float
        The ends, > 0.
    number : int
        How many, from 1 to 100 000.
    """

    kind: Literal["log-range"] = "log-range"
    start: PositiveNumber
    stop: PositiveNumber
    number: Count

    def points(self) -> tuple[Point, ...]:
        """Return the numbers; the ends are exact."""
        return tuple((value,) for value in np.geomspace(self.start, self.stop, self.number).tolist())


class Interval(Section):
    """Where numbers are drawn from.

    Parameters
    ----------
    low, high : float
        The ends, low < high; > 0 where their logarithms are spread evenly.
    scale : {"uniform", "log"}
        Whether the numbers, or their logarithms, are spread evenly.
    """

    scale: Literal["uniform", "log"] = "uniform"
    low: float
    high: float

    @field_validator("high")
    @classmethod
    def _in_order(cls, high: float, info: ValidationInfo) -> float:
        low = info.data.get("low", -np.inf)
        if not low < high:
            refuse("allowed: a number > low = {low}", low=f"{low:g}")
        if info.data.get("scale") == "log" and low <= 0:
            refuse("scale is log, and low = {low}; allowed: 0 < low", low=f"{low:g}")
        return high

    def at(self, share: np.ndarray[Any, Any]) -> list[float]:
        """Return the numbers at shares of the interval, shape (n,), in [0, 1]."""
        if self.scale == "log":
            found: list[float] = np.exp(np.log(self.low) + share * np.log(self.high / self.low)).tolist()
            return found
        return list((self.low + share * (self.high - self.low)).tolist())


class Random(Interval):
    """Numbers drawn from an interval.

    Parameters
    ----------
    low, high, scale
        The interval.
    number : int
        How many, >= 1; the first of more are the same.
    seed : int
        Seed of the generator, >= 0.
    """

    kind: Literal["random"] = "random"
    number: Count
    seed: Seed = 0

    def keys(self, name: str) -> tuple[str, ...]:
        """Return the dotted key that varies along the axis of this name."""
        return (name,)

    def points(self) -> tuple[Point, ...]:
        """Return the numbers."""
        return tuple((value,) for value in self.at(np.random.default_rng(self.seed).random(self.number)))
