"""Tasks to Dask workers in bounded windows, results back as they come.

Only so many tasks are on their way as keep the workers busy, so that neither the driver nor the scheduler grows with
the number of cases. Workers that are started here get one task a thread: where one dies, nothing else was waiting
there. On a cluster that exists further ones wait, for workers that may still join.
"""

from __future__ import annotations

import logging
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import inf
from typing import Any
from uuid import uuid4

from ngcell.errors import OutputError
from ngcell.sweeps.ending import Ending
from ngcell.sweeps.extra import needed
from ngcell.sweeps.patience import next_ended
from ngcell.sweeps.task import OTHER_CODE, Result, Task
from ngcell.sweeps.worker import died
from ngcell.threads import available_cores

#: What a worker does with a task.
Function = Callable[[Task], Result]

#: Endings after which a case is tried once more.
_TRIED_AGAIN = {ending.told for ending in (Ending.KILLED, Ending.OUT_OF_MEMORY, Ending.FAILED)}
_TRIES = 2
#: Tasks that wait on a cluster that exists.
_WAITING = 32


@contextmanager
def connected(scheduler: str | None, workers: int | None) -> Iterator[Any]:
    """Yield a client of a scheduler, or of a cluster on this machine: one process a core, one thread each.

    Raises
    ------
    OutputError
        There is no such scheduler, or the cluster does not start.
    """
    distributed = needed("distributed")
    if scheduler is not None:
        try:
            client = distributed.Client(scheduler, timeout="10s", set_as_default=False)
        except (OSError, ValueError) as error:
            raise OutputError(
                f"no Dask scheduler answers at {scheduler} ({error}); allowed: the address of one, as tcp://HOST:8786"
            ) from error
        with client:
            yield client
        return
    folder = tempfile.mkdtemp(prefix="ngcell-dask-")
    try:
        with (
            _cluster(distributed, workers_here(workers), folder) as cluster,
            distributed.Client(cluster, set_as_default=False) as client,
        ):
            yield client
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _cluster(distributed: Any, workers: int, folder: str) -> Any:
    settings = {
        "distributed.scheduler.allowed-failures": 0,  # the driver tries again
        "distributed.worker.memory.terminate": False,  # runs are processes of their own: Dask does not see their memory
    }
    needed("dask").config.set(settings)
    try:
        return distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address=None,
            memory_limit=0,
            local_directory=folder,
            silence_logs=logging.CRITICAL,
        )
    except RuntimeError as error:
        raise OutputError(
            f"the workers of this machine do not start ({error}); a script that sweeps has to do so under "
            'if __name__ == "__main__":, for each worker reads it'
        ) from error


def workers_here(asked: int | None) -> int:
    """Return the number of workers on this machine where so many are asked for: by default one for each core."""
    return asked or available_cores()


def threads_of(client: Any) -> int:
    """Return how many tasks the workers of a cluster run at a time, at least 1."""
    return max(1, sum(int(count) for count in client.nthreads().values()))


def waiting_on(scheduler: str | None) -> int:
    """Return how many tasks may wait for workers."""
    return 0 if scheduler is None else _WAITING


def finished(
    tasks: Iterable[Task], client: Any, function: Function, waiting: int, minutes: float = inf
) -> Iterator[Result]:
    """Yield the result of each task as it ends; one whose process dies is tried once more.

    Parameters
    ----------
    tasks : iterable of Task
        Taken as workers need them.
    client : distributed.Client
        The cluster.
    function : callable
        What a worker does with a task.
    waiting : int
        Tasks on their way besides one for each thread of the workers.
    minutes : float
        Time that the cluster may be without a worker, > 0.

    Raises
    ------
    OutputError
        The scheduler is gone, there was no worker for that time, or a worker would compute something else.
    """
    distributed, left, sweep = needed("distributed"), iter(tasks), uuid4().hex[:8]
    tried: dict[str, Task] = {}
    running = distributed.as_completed(loop=client.loop)

    def submit(task: Task) -> None:
        name = f"ngcell-{sweep}-{task.key}-{task.attempt}"
        tried[name] = task
        running.add(client.submit(function, task, key=name, pure=False))

    def fill() -> None:
        while len(tried) < threads_of(client) + waiting:
            task = next(left, None)
            if task is None:
                return
            submit(task)

    fill()
    while tried:
        future = next_ended(running, client, minutes)
        task = tried.pop(future.key)
        result = _result_of(future, task)
        future.release()
        if result["outcome"] in _TRIED_AGAIN and result["attempts"] < _TRIES:
            submit(replace(task, attempt=_TRIES))
        else:
            yield result
        fill()


def _result_of(future: Any, task: Task) -> Result:
    """Return the result of a task that has ended, also where its worker has died."""
    if future.status in ("cancelled", "lost"):
        raise OutputError("the Dask scheduler is gone; run the sweep again, which goes on where it stopped")
    error = future.exception()
    if error is None:
        result: Result = future.result()
        if result["detail"] == OTHER_CODE:
            raise OutputError(f"{result['host']}: {OTHER_CODE}")
        return result
    if type(error).__name__ == "KilledWorker":
        return died(task, Ending.KILLED, "the worker that ran it died")
    return died(task, Ending.FAILED, f"{type(error).__name__}: {error}")
