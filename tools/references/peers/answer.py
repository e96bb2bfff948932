"""What a program found, and how long it may take."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

#: Seconds on the clock after which a run is stopped.
LIMIT = 120
#: What is told of a run that was.
STOPPED = f"stopped after {LIMIT} s"


@dataclass(frozen=True)
class Answer:
    """What a program found.

    Attributes
    ----------
    force : float
        The force that is compared [stress * length].
    opening : float or None
        The opening [length], where the problem has one.
    seconds : float
        Seconds on the clock.
    unknowns : int
        Number of unknowns.
    """

    force: float
    opening: float | None
    seconds: float
    unknowns: int


@contextmanager
def stopped_after(limit: int) -> Iterator[None]:
    """Stop what runs in this process when so many seconds are over.

    Raises
    ------
    RuntimeError
        When time is up.
    """

    def stop(*_: object) -> None:
        raise RuntimeError(f"stopped after {limit} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(limit)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
