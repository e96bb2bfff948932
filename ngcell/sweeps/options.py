"""Where a sweep runs, and what it leaves besides its table."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from ngcell.errors import CaseError
from ngcell.sweeps.driver import Function
from ngcell.sweeps.worker import run_task


@dataclass(frozen=True)
class SweepOptions:
    """Where a sweep runs; no number of its table depends on it.

    Attributes
    ----------
    store : Path, optional
        Folder of results, which sweeps may share; by default `store` in the folder of the sweep.
    scheduler : str, optional
        Address of a Dask scheduler, as ``tcp://host:8786``; by default a cluster on this machine is started.
    workers : int, optional
        Processes of that cluster, by default one for each core.
    memory : float, optional
        Memory that a run may take [GiB].
    function : callable
        What a worker does with a task.
    pictures : int
        Cases, spread over the study, that get a small picture of their tissue, >= 0.
    wait : float
        Time that the sweep waits while there is no worker [minutes], > 0.

    Raises
    ------
    CaseError
        `memory`, `pictures` or `wait` is out of range.
    """

    store: Path | None = None
    scheduler: str | None = None
    workers: int | None = None
    memory: float | None = None
    function: Function = run_task
    pictures: int = 24
    wait: float = 60.0

    def __post_init__(self) -> None:
        if not self.wait > 0:
            raise CaseError(f"wait = {self.wait}; allowed: a number > 0 [minutes]")
        if self.memory is not None and not (isfinite(self.memory) and self.memory > 0):
            raise CaseError(f"memory = {self.memory}; allowed: a finite number > 0 [GiB]")
        if self.pictures < 0:
            raise CaseError(f"pictures = {self.pictures}; allowed: a whole number >= 0")
