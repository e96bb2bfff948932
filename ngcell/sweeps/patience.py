"""Waiting for the next task to end, as long as there is a worker, or one may still come."""

from __future__ import annotations

import logging
from time import monotonic, sleep
from typing import Any

from ngcell.errors import OutputError

_log = logging.getLogger(__name__)

#: How often it is asked whether a task has ended, and whether there is a worker [s].
_PAUSE, _BETWEEN = 0.02, 1.0
#: Without a worker for longer, it is told that one is waited for [s].
_QUIET = 20.0


def next_ended(running: Any, client: Any, minutes: float) -> Any:
    """Return the next task that ends.

    Parameters
    ----------
    running : distributed.as_completed
        Tasks on their way, at least one.
    client : distributed.Client
        The cluster.
    minutes : float
        Time that a cluster may be without a worker, > 0.

    Raises
    ------
    OutputError
        There was no worker for so long.
    """
    asked = seen = monotonic()
    is_told = False
    while not running.has_ready():
        now = monotonic()
        if now - asked >= _BETWEEN:
            asked = now
            if _has_worker(client):
                seen, is_told = now, False
        if now - seen > 60 * minutes:
            raise OutputError(
                f"the Dask cluster has had no worker for {minutes:g} minutes; what has ended is kept: "
                "start workers, and run the sweep again, which goes on where it stopped"
            )
        if now - seen > _QUIET and not is_told:
            _log.warning("the Dask cluster has no worker; the sweep waits %g minutes for one", minutes)
            is_told = True
        sleep(_PAUSE)
    return next(running)


def _has_worker(client: Any) -> bool:
    """Return whether the cluster has a worker; a scheduler that does not answer is told by the tasks that it loses."""
    try:
        return bool(client.nthreads())
    except (OSError, TimeoutError):
        return True
