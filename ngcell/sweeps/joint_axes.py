"""Kinds of axes over several keys, which vary together."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, field_validator

from ngcell.scene.dotted import flattened
from ngcell.scene.scope import refuse
from ngcell.scene.section import Section
from ngcell.sweeps.axes import Count, Interval, Seed
from ngcell.sweeps.axis import Point


class Zip(Section):
    """Lists of values that are taken together: the first of each, the second of each, and so on.

    Parameters
    ----------
    values : table
        A list for each dotted key, all of one length.
    """

    kind: Literal["zip"] = "zip"
    values: Annotated[dict[str, list[Any]], BeforeValidator(flattened)]

    @field_validator("values")
    @classmethod
    def _of_one_length(cls, values: dict[str, list[Any]]) -> dict[str, list[Any]]:
        lengths = {key: len(each) for key, each in values.items()}
        if not lengths or not min(lengths.values()):
            refuse("is empty; allowed: a list of at least one value for each key")
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{key} has {length}" for key, length in lengths.items())
            refuse("lists are of unequal lengths ({told}); allowed: as many values for each key", told=told)
        return values

    def keys(self, name: str) -> tuple[str, ...]:
        """Return the dotted keys that vary along the axis of this name."""
        return tuple(self.values)

    def points(self) -> tuple[Point, ...]:
        """Return the values that are taken together."""
        return tuple(zip(*self.values.values(), strict=True))


def _by_key(table: Any) -> Any:
    """Return intervals by dotted key; a list of two numbers is one."""
    if not isinstance(table, dict):
        return table
    found: dict[str, Any] = {}
    for key, value in table.items():
        nested = isinstance(value, dict) and not value.keys() & Interval.model_fields.keys()
        found.update({f"{key}.{rest}": each for rest, each in _by_key(value).items()} if nested else {key: value})
    pairs = {key for key, value in found.items() if isinstance(value, (list, tuple)) and len(value) == 2}
    for key, value in found.items():
        if not (key in pairs or isinstance(value, (dict, Interval))):
            refuse("{key} = {value} is no interval; allowed: [low, high], or a table with low, high, scale",
                   key=key, value=value)  # fmt: skip
    return {key: dict(zip(("low", "high"), value, strict=True)) if key in pairs else value
            for key, value in found.items()}  # fmt: skip


class LatinHypercube(Section):
    """Points of a Latin hypercube: each key has one value in each of as many equal parts of its interval.

    Parameters
    ----------
    over : table
        For each dotted key its interval: ``[low, high]``, or a table with low, high, scale.
    number : int
        How many points, from 1 to 100 000.
    seed : int
        Seed of the generator, >= 0.
    """

    kind: Literal["latin-hypercube"] = "latin-hypercube"
    over: Annotated[dict[str, Interval], BeforeValidator(_by_key), Field(min_length=1)]
    number: Count
    seed: Seed = 0

    def keys(self, name: str) -> tuple[str, ...]:
        """Return the dotted keys that vary along the axis of this name."""
        return tuple(self.over)

    def points(self) -> tuple[Point, ...]:
        """Return the points."""
        from scipy.stats import qmc

        shares = qmc.LatinHypercube(len(self.over), rng=self.seed).random(self.number)
        columns = [interval.at(shares[:, number]) for number, interval in enumerate(self.over.values())]
        return tuple(zip(*columns, strict=True))
