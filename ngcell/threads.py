"""How many threads NGSolve's sums may use, and where they pay.

A nearly symmetric tissue chooses between equilibria by the last digits of sums. Compared bit by bit on 2592 and on
12 753 unknowns, one thread against two, over repeats: NGSolve's gradient (`Apply`) and tangent
(`AssembleLinearization`) never differ, since elements of one colour share no unknown and colours follow each other in
the same order. The energy (`Energy`, one sum that threads share) differs by 7e-18 of 0.047, the Cholesky factor and its
solutions (updates in the order in which threads finish) by 1e-18 to 2e-17 of 1e-3; those of 142 000 rows by 1e-15. So
small scenes, and all scenes on one thread, have the same bits whenever they are run. Larger factors use threads, too:
two take 0.58 times as long for 96 000 and for 192 000 rows. What differs in them is round-off, which places on the way
lose (`ngcell.solve.last_digits`).
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import ngsolve

#: Rows below which threads wait for each other longer than they help.
_FEWEST_ROWS = 50_000


class _Threads:
    """How many threads there are."""

    count = 1


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Let sums over many rows use so many threads."""
    ngsolve.SetNumThreads(1)
    before, _Threads.count = _Threads.count, count
    try:
        yield
    finally:
        _Threads.count = before


@contextmanager
def in_parallel(rows: int) -> Iterator[None]:
    """Let NGSolve use all threads where it has many rows; outside it has one, since its Cholesky factor starts threads
    by itself."""
    if _Threads.count == 1 or rows < _FEWEST_ROWS:
        yield
        return
    ngsolve.SetNumThreads(_Threads.count)
    try:
        with ngsolve.TaskManager():
            yield
    finally:
        ngsolve.SetNumThreads(1)
