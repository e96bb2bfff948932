"""How long the rest of a sweep takes, from what has been run and from what was foreseen of the rest."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

#: Runs that have to have ended before anything is told.
_LEAST = 3


@dataclass(frozen=True)
class Left:
    """Time that a sweep will still take.

    Attributes
    ----------
    seconds : float
        What is expected [s], >= 0.
    share : float
        By which share of it that may be wrong, one standard deviation, >= 0; no less than a tenth.
    """

    seconds: float
    share: float


class Pace:
    """Time on the clock over foreseen seconds, measured as runs end.

    What was foreseen need not be right: it says how runs compare, and the clock says how long they take, with whatever
    else the machine does.

    Parameters
    ----------
    weight : float
        Foreseen seconds of all runs.

    Attributes
    ----------
    threads : int
        Runs at a time.
    """

    def __init__(self, weight: float) -> None:
        self.threads = 1
        self._left, self._done, self._clock = weight, 0.0, 0.0
        self._sum = self._squares = 0.0
        self._count, self._before = 0, 0.0

    def ended(self, weight: float, clock: float) -> None:
        """Note that a run of this foreseen time has ended, so long after the first one began [s]."""
        self._left, self._done, self._clock = self._left - weight, self._done + weight, clock
        rate = (clock - self._before) / max(weight, 1e-9)
        self._before, self._count = clock, self._count + 1
        self._sum, self._squares = self._sum + rate, self._squares + rate * rate

    @property
    def left(self) -> Left | None:
        """Time that is left; None while too few runs have ended to tell."""
        if self._count < max(_LEAST, self.threads) or self._done <= 0:
            return None
        mean = self._sum / self._count
        variance = max(0.0, self._squares / self._count - mean * mean)
        scatter = sqrt(variance / self._count) / mean if mean > 0 else 0.0
        return Left(max(0.0, self._left) * self._clock / self._done, max(0.1, scatter))
