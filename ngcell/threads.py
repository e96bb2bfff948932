"""How many threads sums may use, and where they pay.

A nearly symmetric tissue chooses between equilibria by the last digits of sums. Compared bit by bit on 2592 and on
12 753 unknowns, one thread against two, over repeats: NGSolve's gradient (`Apply`) and tangent
(`AssembleLinearization`) never differ, since elements of one colour share no unknown and colours follow each other in
the same order. The energy (`Energy`, one sum that threads share) differs by 7e-18 of 0.047, the Cholesky factor and its
solutions (updates in the order in which threads finish) by 1e-18 to 2e-17 of 1e-3; those of 142 000 rows by 1e-15. So
small scenes, and all scenes on one thread, have the same bits whenever they are run. Larger factors use threads, too:
two take 0.58 times as long for 96 000 and for 192 000 rows. What differs in them is round-off, which places on the way
lose (`ngcell.solve.last_digits`). Sums of numpy's that do not depend on each other have the same bits on any thread;
two threads take 0.5 to 0.7 times as long for sparse products, for small dense systems and for sums over them.
"""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import copy_context
from itertools import pairwise
from typing import TypeVar

import ngsolve
from threadpoolctl import threadpool_limits

Found = TypeVar("Found")

_log = logging.getLogger(__name__)

#: Rows below which threads wait for each other longer than they help.
_FEWEST_ROWS = 50_000
#: The same for sums of numpy's: a thread is told what to do in 50 microseconds, and a product of a sparse matrix of
#: so many rows takes 2 milliseconds.
_FEWEST_OF_NUMPY = 20_000


class _NoMore:
    """What follows the last item."""


_NO_MORE = _NoMore()


class _Threads:
    """How many threads there are, and those beside the first one."""

    count = 1
    others: ThreadPoolExecutor | None = None


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def threads_for(asked: int | None) -> int:
    """Return the number of threads that run where so many are asked for: at most one for each core."""
    cores = available_cores()
    if asked is not None and asked > cores:
        _log.warning("%d threads were asked for; %d run, one for each core that this process may use", asked, cores)
    return min(asked or cores, cores)


def each_on_threads(items: Iterator[Found], count: int) -> Iterator[Found]:
    """Yield items, each made on so many threads.

    Between two of them threads are as they were: whoever takes the items may follow another run in between.
    """
    while True:
        with threads(count):
            item = next(items, _NO_MORE)
        if isinstance(item, _NoMore):
            return
        yield item


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Let sums over many rows use so many threads."""
    ngsolve.SetNumThreads(1)
    before = _Threads.count, _Threads.others
    pool = ThreadPoolExecutor(max(count - 1, 1))  # it starts threads when it is given something to do
    with threadpool_limits(1, user_api="blas"), pool as others:
        _Threads.count, _Threads.others = count, others
        try:
            yield
        finally:
            _Threads.count, _Threads.others = before


def at_once(rows: int, tasks: Sequence[Callable[[], Found]]) -> list[Found]:
    """Return what tasks find that do not depend on each other, each on a thread of its own where there are many rows.

    They may call numpy, but not NGSolve.
    """
    if _Threads.others is None or _Threads.count == 1 or rows < _FEWEST_OF_NUMPY:
        return [task() for task in tasks]
    # What numpy is told to ignore is told to each thread by itself.
    started = [_Threads.others.submit(copy_context().run, task) for task in tasks[1:]]
    return [tasks[0](), *(other.result() for other in started)]


def parts_of(count: int, rows: int) -> list[slice]:
    """Return parts of so many things, one for each thread; where there are few rows, one of all."""
    number = max(min(_Threads.count, count), 1) if rows >= _FEWEST_OF_NUMPY else 1
    ends = [part * count // number for part in range(number + 1)]
    return [slice(*pair) for pair in pairwise(ends)]


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
