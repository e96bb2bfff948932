"""How far a run is, and how long the rest may take: told from the levels that have ended, and only from them."""

from __future__ import annotations

from collections.abc import Sequence
from math import isclose
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ngcell.results.record import StepRecord


class Pace:
    """Times of the levels so far, and what follows from them for the rest.

    Later levels tend to take longer, since more walls are free: with two levels or more a straight line through their
    times is continued, which cannot foresee a level that is harder than the trend. Levels of several members repeat,
    and are expected to take their mean.

    Parameters
    ----------
    factors : sequence of float
        Load factors of the levels, in the order of the load path.
    members : int
        Number of runs along these levels, one after the other.
    """

    def __init__(self, factors: Sequence[float], members: int = 1) -> None:
        self._factors, self._members = tuple(factors), members
        self._times: list[float] = []
        self._seconds, self._ended, self._member = 0.0, 0, 0

    def accept(self, record: StepRecord, member: int = 0) -> None:
        """Count an accepted step, of a member if there are several."""
        if member != self._member:
            self._member, self._ended, self._seconds = member, 0, 0.0
        self._seconds += record.seconds
        ends = self._ended < len(self._factors) and record.phase == "released"
        if ends and isclose(record.load_factor, self._factors[self._ended], abs_tol=1e-12):
            self._times.append(self._seconds)
            self._seconds, self._ended = 0.0, self._ended + 1

    @property
    def seconds_left(self) -> float | None:
        """How long the rest takes if the levels go on as they did [s]; None as long as none has ended."""
        ahead = len(self._factors) * (self._members - self._member) - self._ended
        if not self._times:
            return None
        count = len(self._times)
        mean = sum(self._times) / count
        if self._members > 1 or count < 2:
            return max(0.0, mean * ahead - self._seconds)
        middle = (count - 1) / 2
        squares = sum((n - middle) ** 2 for n in range(count))
        slope = sum((n - middle) * time for n, time in enumerate(self._times)) / squares
        expected = (mean + slope * (count + n - middle) for n in range(ahead))
        return max(0.0, sum(max(time, min(self._times)) for time in expected) - self._seconds)

    @property
    def has_ended(self) -> bool:
        """Whether the last level has been reached."""
        return self._ended == len(self._factors) > 0

    def __str__(self) -> str:
        total = len(self._factors)
        if not total:
            return ""
        here, left = f"{self._ended} of {total} levels", self.seconds_left
        if left is None or not left:
            return here
        few = len(self._times) < 2
        return f"{here}, about {duration(left)} left{' if the others take as long' if few else ''}"


def duration(seconds: float) -> str:
    """Return a time in words, to two digits."""
    for unit, size in (("days", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.2g} {unit}" if seconds < 100 * size else f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"
