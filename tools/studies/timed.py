"""Contact whose seconds are added up: a choice of contact that stands in a case in place of the one that it times."""

from __future__ import annotations

from time import process_time
from typing import Any


class Timed:
    """Anything, with the processor seconds of its calls and properties added up.

    Parameters
    ----------
    timed : object
        What is timed; contact stages and contact sets that it returns are timed as well.
    spent : Stopwatch
        Where the seconds go.
    """

    def __init__(self, timed: Any, spent: Stopwatch) -> None:
        self._timed, self._spent = timed, spent

    def __getattr__(self, name: str) -> Any:
        found = self._spent.of(lambda: getattr(self._timed, name))
        return self._called(found) if callable(found) else found

    def _called(self, call: Any) -> Any:
        def timed(*arguments: Any, **options: Any) -> Any:
            bare = [each._timed if isinstance(each, Timed) else each for each in arguments]
            return self._wrapped(self._spent.of(lambda: call(*bare, **options)))

        return timed

    def _wrapped(self, found: Any) -> Any:
        if isinstance(found, tuple):
            return tuple(self._wrapped(each) for each in found)
        return Timed(found, self._spent) if hasattr(found, "pair") or hasattr(found, "penalty_terms") else found


class Stopwatch:
    """Processor seconds of calls, once where they call each other."""

    def __init__(self) -> None:
        self.seconds, self._runs = 0.0, False

    def of(self, call: Any) -> Any:
        """Return what a call returns."""
        if self._runs:
            return call()
        started, self._runs = process_time(), True
        try:
            return call()
        finally:
            self._runs = False
            self.seconds += process_time() - started
