"""Numbers that a case is held to, beside what was measured."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import isclose, isfinite
from typing import Any

from ngcell.results.quantities import View, measured
from ngcell.results.record import StepRecord
from ngcell.scene import BodyExpected, Expected


@dataclass(frozen=True, slots=True)
class Finding:
    """One expected number and the measured one.

    Attributes
    ----------
    quantity : str
        What was measured.
    place : str
        Boundary or boundaries that it was measured on; empty for the whole scene.
    load_factor : float
        Where it was measured, in (0, 1].
    measured, expected : float
        The two numbers, in the units of the case.
    tolerance : float
        Largest deviation that passes, > 0, beside what the measured number may err by.
    origin : str
        Where the expected number comes from.
    error : float
        Estimated error of the measured number, in its units; 0 where none was estimated.
    """

    quantity: str
    place: str
    load_factor: float
    measured: float
    expected: float
    tolerance: float
    origin: str
    error: float = 0.0

    @property
    def deviation(self) -> float:
        """Measured minus expected over the expected number [1]; the difference itself where 0 is expected."""
        return (self.measured - self.expected) / (abs(self.expected) or 1.0)

    @property
    def passed(self) -> bool:
        """Whether the deviation keeps the tolerance, as far as the measured number is known; NaN never does."""
        return abs(self.deviation) <= self.tolerance + self.error / (abs(self.expected) or 1.0)

    def table(self) -> dict[str, Any]:
        """Return everything about it, for the summary."""
        return {name: getattr(self, name) for name in (*self.__slots__, "deviation", "passed")}


def compare(
    expected: Iterable[Expected | BodyExpected], record: StepRecord, view: View, levels: Sequence[float]
) -> Iterator[Finding]:
    """Yield what is expected at the load factor of a step, beside what was measured there.

    Parameters
    ----------
    expected : iterable of Expected or BodyExpected
        All numbers that the case is held to.
    record : StepRecord
        The row of the history.
    view : View
        The accepted step.
    levels : sequence of float
        Load factors of the level of the step and of those to come. A number holds where the load path comes to its load
        factor for the last time; one that names none holds at the last level.
    """
    for entry in expected:
        last = len(levels) - 1
        if entry.level is not None:
            last = max((number for number, level in enumerate(levels) if isclose(entry.level, level)), default=-1)
        if last:
            continue
        error = 0.0
        if isinstance(entry, Expected):
            value = float(getattr(record, entry.quantity))
            name = re.sub("_[xyz]$", "", entry.quantity)
            told = float(getattr(record, f"{name}_error", 0.0))
            error = told if isfinite(told) else 0.0
        else:
            value = measured(view, entry.quantity, entry.boundaries)
        yield Finding(
            entry.quantity, entry.place, record.load_factor, value, entry.value, entry.tolerance, entry.origin, error
        )
