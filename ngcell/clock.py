"""Where the seconds go: processor time by phase."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from time import process_time


class Clock:
    """Adds up processor seconds by name; phases do not nest."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Count the time inside the block towards `name`."""
        start = process_time()
        try:
            yield
        finally:
            self.seconds[name] += process_time() - start
