"""A sweep: the runs of a study that are missing, and the table of all of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from random import sample
from time import monotonic
from typing import Any

from ngcell.errors import CaseError, OutputError
from ngcell.export import read_summary, write_summary
from ngcell.export.ownership import PROGRAM, claim_folder
from ngcell.export.summary import FIRST_CASE, SUMMARY
from ngcell.scene import resolved_toml
from ngcell.scene.study import Study
from ngcell.scene.study_reader import WrittenStudy, read_study
from ngcell.sweeps.cases import Cases
from ngcell.sweeps.driver import connected, finished, threads_of, waiting_on
from ngcell.sweeps.ending import Ending
from ngcell.sweeps.extra import needed
from ngcell.sweeps.foresee import Costs, Outlook, outlook
from ngcell.sweeps.identity import content_key
from ngcell.sweeps.options import SweepOptions
from ngcell.sweeps.outputs import outputs_of
from ngcell.sweeps.pace import Left, Pace
from ngcell.sweeps.pictures import Pictures, pictured
from ngcell.sweeps.store import Store
from ngcell.sweeps.table import Row, Table, read_table, refused
from ngcell.sweeps.task import Result, Task

#: What is asked, or the file that says it.
Asked = Study | WrittenStudy | str | Path

#: Key by which the folder of a sweep is known.
SWEEP = "sweep"
#: Runs in the store that times are told from.
_SAMPLE = 200
_LIBRARIES = ("distributed", "pandas", "pyarrow")


@dataclass(frozen=True)
class Ended:
    """A run of a sweep that has ended now, or was there before.

    Attributes
    ----------
    number : int
        Number of the case.
    result : table
        How it ended; see `ngcell.sweeps.case_run`.
    done, total : int
        Cases that have a result, and all.
    left : Left, optional
        Time that the others will take; None as long as too few have run to tell.
    """

    number: int
    result: Result
    done: int
    total: int
    left: Left | None


class Sweep:
    """The runs of a study: iterate over it to run those that are missing.

    Parameters
    ----------
    study : Study, WrittenStudy, str or Path
        What is asked, or its file.
    out : Path
        The folder of the table.
    options : SweepOptions
        Where it runs.

    Attributes
    ----------
    outcomes : Counter of str
        How many cases have ended in which way.
    reused, computed : int
        Cases whose result was in the store, and those that were run.

    Raises
    ------
    CaseError
        The study is none of this case; one line.
    DependencyError
        A library of the extra `sweep` is missing.
    """

    def __init__(self, study: Asked, out: Path, options: SweepOptions | None = None) -> None:
        for library in _LIBRARIES:
            needed(library)
        self.out, self.options = Path(out), options or SweepOptions()
        self.written = written_study(study)
        self.cases = Cases(self.written)
        self.costs, self._keys = Costs(), list[str]()
        self.refused: dict[int, str] = {}
        self._resolve()
        self.outputs = outputs_of(self.written, self.cases, self.refused)
        self._table = Table(self.cases.coordinates, self.outputs)
        self.outcomes: Counter[str] = Counter()
        self.reused = self.computed = 0

    @property
    def certified(self) -> bool:
        """Whether every case has been run and is certified."""
        return self.outcomes[Ending.CERTIFIED.told] == len(self.cases)

    def missing(self, store: Store) -> list[int]:
        """Return the numbers of cases that have no result; of cases that are the same, the first one."""
        first = {key: number for number, key in reversed(list(enumerate(self._keys))) if key}
        return sorted(number for key, number in first.items() if not store.holds(key))

    def store(self) -> Store:
        """Return the store of results."""
        return Store(self.options.store or self.out / "store")

    def __iter__(self) -> Iterator[Ended]:
        lock = claim_folder(self.out)
        try:
            self._check_ours()
            self._note("running")
            store = self.store()
            yield from self._run(store)
        finally:
            lock.release()

    def _run(self, store: Store) -> Iterator[Ended]:
        waiting, status = {self._keys[number]: number for number in self.missing(store)}, "stopped"
        self.reused = len([key for key in self._keys if key]) - len(waiting)
        try:
            if waiting:
                with connected(self.options.scheduler, self.options.workers) as client:
                    yield from self._ended(waiting, store, client)
            status = "finished"
        finally:
            self._table.write(self.out, self._rows(store))
            self._note(status)

    def _ended(self, waiting: dict[str, int], store: Store, client: Any) -> Iterator[Ended]:
        """Yield runs as they end, and take each from those that wait: numbers of cases by the names of their results.
        """
        started, pace = monotonic(), Pace(sum(self.costs.seconds[number] for number in waiting.values()))
        pace.threads = threads_of(client)
        ahead, how = waiting_on(self.options.scheduler), self.options
        for result in finished(self._tasks(waiting, store), client, how.function, ahead, how.wait):
            store.write(result)
            self.computed += 1
            number = waiting.pop(result["key"])
            pace.ended(self.costs.seconds[number], monotonic() - started)
            yield Ended(number, result, len(self.cases) - len(waiting), len(self.cases), pace.left)

    def outlook(self) -> Outlook:
        """Return what is left to be run, and what it takes; nothing is written."""
        folder = self.options.store or self.out / "store"
        store = Store(folder) if folder.is_dir() else None
        missing = [number for number, key in enumerate(self._keys) if key] if store is None else self.missing(store)
        measured: list[tuple[int, float]] = []
        if store is not None:
            ended = sorted({*range(len(self._keys))} - {*missing} - {*self.refused})[:_SAMPLE]
            found = ((number, store.read(self._keys[number])) for number in ended)
            measured = [(number, float(result["seconds"])) for number, result in found if result]
        return outlook(self.costs, missing, len(self.refused), measured)

    def table(self) -> Any:
        """Return the table (pandas): a row for each case and level, in the order of the cases."""
        return read_table(self.out)

    def _resolve(self) -> None:
        """Note by which name the result of each case is known, and how long its run takes beside the others."""
        for number in range(len(self.cases)):
            try:
                case = self.cases.case(number)
            except CaseError as error:
                self.refused[number] = str(error)
                self._keys.append("")
                self.costs.skip()
            else:
                self._keys.append(content_key(case))
                self.costs.add(case)
        self.cases.check(self.refused)

    def _tasks(self, waiting: dict[str, int], store: Store) -> Iterator[Task]:
        """Yield a task for each case that waits, unless another sweep has run it meanwhile.

        They come in any order: those that have run tell how long the others take, and of two sweeps that share a store
        each meets what the other has run.
        """
        shown = pictured([number for number, known in enumerate(self._keys) if known], self.options.pictures)
        for key, number in sample(list(waiting.items()), len(waiting)):
            if store.holds(key):
                del waiting[key]
                self.reused += 1
            else:
                text, minutes = resolved_toml(self.cases.case(number)), self.written.study.minutes
                yield Task(key, text, minutes, self.options.memory, picture=number in shown)

    def _rows(self, store: Store) -> Iterator[Row]:
        self.outcomes.clear()
        pictures = Pictures(self.out)
        for number, key in enumerate(self._keys):
            result = store.read(key) if key else refused(self.refused[number])
            if result is not None:
                self.outcomes[result["outcome"]] += 1
                pictures.keep(number, result)
                yield from self._table.rows(number, self.cases.values(number), result)

    def _check_ours(self) -> None:
        if (self.out / SUMMARY).exists() and SWEEP not in read_summary(self.out):
            raise OutputError(f"{self.out} holds the result of a run; choose another folder for the sweep")

    def _note(self, status: str) -> None:
        ended = sum(self.outcomes.values())
        study = self.written.study
        write_summary(
            self.out,
            {
                "program": PROGRAM,
                "status": status,
                "title": study.title,
                "accepted_steps": ended,  # a run asks before it replaces them
                SWEEP: {"cases": len(self.cases), "ended": ended, "outcomes": dict(self.outcomes)},
                "certified": self.certified,
                "study": _with_words(study.model_dump()),
                FIRST_CASE: self._first_case(),
            },
        )

    def _first_case(self) -> str:
        """Return the text of the first case that can be run, fully resolved; empty where there is none."""
        return next((resolved_toml(self.cases.case(number)) for number, key in enumerate(self._keys) if key), "")


def _with_words(value: Any) -> Any:
    """Return what a study says with infinite numbers as words, as JSON has none."""
    if isinstance(value, dict):
        return {name: _with_words(entry) for name, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_with_words(entry) for entry in value]
    return str(value) if isinstance(value, float) and not isfinite(value) else value


def written_study(study: Asked) -> WrittenStudy:
    """Return a study, read from its file where it is one."""
    if isinstance(study, WrittenStudy):
        return study
    return WrittenStudy(study) if isinstance(study, Study) else read_study(study)


def sweep(
    study: Study | str | Path,
    out: str | Path,
    *,
    store: Path | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    memory: float | None = None,
    pictures: int = 24,
    wait: float = 60.0,
) -> Any:
    """Run what is missing of a study, and return its table (pandas).

    Parameters
    ----------
    study, out
        What is asked, or its file; the folder of the table, and of the results unless `store` names another one.
    store, scheduler, workers, memory, pictures, wait
        As for `ngcell.sweeps.options.SweepOptions`.

    Returns
    -------
    pandas.DataFrame
        A row for each run and level, failed ones included; `ngcell.table_to_xarray` shows it on the axes.

    Raises
    ------
    CaseError, DependencyError, OutputError
        If the study is not allowed, a library is missing, or a folder cannot be used or a cluster has no worker.
    """
    runs = Sweep(study, Path(out), SweepOptions(store, scheduler, workers, memory, pictures=pictures, wait=wait))
    for _ in runs:
        pass
    return runs.table()


def read_sweep(folder: str | Path) -> Any:
    """Return the table of a sweep (pandas) from its folder.

    Raises
    ------
    OutputError
        It holds none.
    """
    return read_table(Path(folder))
