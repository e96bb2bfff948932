"""The load factors at which a scene is reported."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, Strict
from pydantic_core import PydanticCustomError

#: More levels than this are a typing error; steps between them are chosen by the solver anyway.
MOST_LEVELS = 1000


def _levels(value: Any) -> int | tuple[float, ...]:
    """Return a number of levels, or the load factors themselves, as they were given but checked."""
    if type(value) is int and 1 <= value <= MOST_LEVELS:
        return value
    if isinstance(value, (list, tuple)) and all(type(factor) in (int, float) for factor in value):
        # Written so that a NaN, for which every comparison is false, is refused as well.
        if value and all(0 <= to <= 1 for to in value) and all(before != to for before, to in pairwise(value)):
            return tuple(float(factor) for factor in value)
    raise PydanticCustomError(
        "limit",
        "allowed: a whole number from 1 to {most} of equal levels, "
        "or a list of load factors in [0, 1], each other than the one before it",
        {"most": MOST_LEVELS},
    )


LevelCount = Annotated[int, Field(ge=1, le=MOST_LEVELS)]
LoadFactors = Annotated[tuple[Annotated[float, Field(ge=0, le=1)], ...], Strict(False)]
Levels = Annotated[LevelCount | LoadFactors, BeforeValidator(_levels)]


def level_factors(levels: int | tuple[float, ...]) -> tuple[float, ...]:
    """Return the load factors of the levels, in [0, 1], in the order of the load path."""
    return tuple((n + 1) / levels for n in range(levels)) if isinstance(levels, int) else levels
