"""Processor time of a run, summed by the phase that took it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from time import process_time


class Clock:
    """Adds up processor time by phase; phases do not nest.

    Attributes
    ----------
    seconds : dict of str to float
        Processor seconds so far, by name of the phase [s], >= 0.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Add the processor time that the block takes to `seconds[name]`."""
        start = process_time()
        try:
            yield
        finally:
            self.seconds[name] += process_time() - start
