"""Time of a run: processor time summed by the phase that took it, and when there is none left."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic, process_time


class OutOfTime(Exception):  # noqa: N818 - named as what is reported, not as a mistake
    """A run has taken all the time that it was given."""


class Clock:
    """Adds up processor time by phase; phases do not nest.

    Parameters
    ----------
    end : float, optional
        When the run has to end, as `time.monotonic` tells it [s]; by default it may take as long as it needs.

    Attributes
    ----------
    seconds : dict of str to float
        Processor seconds so far, by name of the phase [s], >= 0.
    """

    def __init__(self, end: float | None = None) -> None:
        self.end = end
        self.seconds: dict[str, float] = defaultdict(float)

    def check(self) -> None:
        """Raise `OutOfTime` if there is no time left; what iterates calls it, where nothing is lost by stopping."""
        if self.end is not None and monotonic() > self.end:
            raise OutOfTime

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Add the processor time that the block takes to `seconds[name]`."""
        start = process_time()
        try:
            yield
        finally:
            self.seconds[name] += process_time() - start
