"""One case, run in the process that this module is started in: what a worker starts for each case.

The task comes as one line on standard input, and the result goes into a file, out of reach of what libraries print.
Standard input then stays open as long as the worker lives: where it ends, so does this process, in whatever it is.
"""

from __future__ import annotations

import json
import os
import socket
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from threading import Thread
from time import process_time
from typing import Any

from ngcell.errors import CaseError, GeometryError, NgcellError, NotConverged, TooLarge
from ngcell.export.summary import failed_checks
from ngcell.results.record import StepRecord
from ngcell.results.spread import at_levels
from ngcell.run import record
from ngcell.scene import AnyCase, read_case
from ngcell.solve.outcome import Outcome
from ngcell.sweeps.code import own_version
from ngcell.sweeps.ending import Ending
from ngcell.sweeps.identity import content_key
from ngcell.sweeps.pictures import picture_of
from ngcell.sweeps.task import OTHER_CODE, RESULT, Result, Task

#: Endings by the errors that stand for them; the first that fits counts.
_OF_ERRORS = {
    TooLarge: Ending.OUT_OF_MEMORY,
    MemoryError: Ending.OUT_OF_MEMORY,
    GeometryError: Ending.BAD_GEOMETRY,
    CaseError: Ending.REFUSED,
}
#: What errors of NGSolve, numpy and the system's loader say where memory is refused.
_WORDS_OF_MEMORY = ("alloc", "failed to map", "cannot allocate")


def serve(folder: str) -> None:
    """Run the task on standard input and leave its result in a folder."""
    task = Task(**json.loads(sys.stdin.readline()))
    Thread(target=_end_with_the_worker, daemon=True).start()
    _bound_memory(task.memory)
    draft = Path(folder) / "draft.json"
    draft.write_text(json.dumps(run(task, Path(folder))), encoding="utf-8")
    os.replace(draft, Path(folder) / RESULT)


def _end_with_the_worker() -> None:
    with suppress(OSError, ValueError):
        os.read(sys.stdin.fileno(), 1)
    os._exit(1)


def run(task: Task, folder: Path) -> Result:
    """Run a task, its files in a folder of its own, and return what the store keeps of it."""
    return {
        "key": task.key,
        **_ended(task, folder),
        "attempts": task.attempt,
        "processor_seconds": process_time(),  # with the imports
        "waited_seconds": _waited(),
        "memory_gib": _most_memory(),
        "host": socket.gethostname(),
        "ngcell": own_version(),
        "ngsolve": version("ngsolve"),
    }


def _ended(task: Task, folder: Path) -> Result:
    """Return outcome and levels of a run, however it ends."""
    file = folder / "case.toml"
    file.write_text(task.text, encoding="utf-8")
    history: list[StepRecord] = []
    try:
        case = read_case(file)
        if content_key(case) != task.key:
            return _result(Ending.FAILED, OTHER_CODE)
    except CaseError as error:
        return _result(Ending.REFUSED, str(error))
    try:
        recording = record(case, folder / "run", threads=1, max_minutes=task.minutes, pictures=False)
        with suppress(NotConverged):
            history.extend(recording)
        found = _result(_ending(recording.outcome), recording.outcome, case, history, recording.summary)
        picture = None
        with suppress(Exception):  # a run that has ended is worth more than its picture
            picture = picture_of(folder / "run", certified=recording.certified) if task.picture else None
        return found if picture is None else {**found, "picture": picture}
    except Exception as error:  # noqa: BLE001 - one run that fails must not end the others
        told = str(error) if isinstance(error, NgcellError) else f"{type(error).__name__}: {error}"
        return _result(_ending_by(error), told, case)


def _ending(outcome: str) -> Ending:
    """Return which of the closed list the outcome of a run, in words, is."""
    name = next((one.name for one in Outcome if one.value == outcome), Ending.NOT_AS_EXPECTED.name)
    return Ending[name]


def _ending_by(error: Exception) -> Ending:
    """Return which of the closed list an error stands for."""
    found = next((ending for kind, ending in _OF_ERRORS.items() if isinstance(error, kind)), Ending.FAILED)
    lacks_memory = any(words in str(error).lower() for words in _WORDS_OF_MEMORY)
    return Ending.OUT_OF_MEMORY if found is Ending.FAILED and lacks_memory else found


def _result(
    ending: Ending,
    detail: str,
    case: AnyCase | None = None,
    history: Sequence[StepRecord] = (),
    summary: Mapping[str, Any] | None = None,
) -> Result:
    told, factors = summary or {}, () if case is None else case.level_factors
    return {
        "outcome": ending.told,
        "final": ending.is_final,
        "detail": " ".join(detail.split()),
        "failed_checks": failed_checks(told),
        "unknowns": told.get("unknowns"),
        "levels": [
            {"load_factor": factor, "step": None if step is None else _row(step)}
            for factor, step in zip(factors, at_levels(history, factors), strict=True)
        ],
    }


def _row(step: StepRecord) -> dict[str, Any]:
    row = asdict(step)
    return {**{name: value for name, value in row.items() if name != "more"}, **row["more"]}


def _bound_memory(most: float | None) -> None:
    """Let this process take no more memory than this [GiB] besides what its libraries have; Linux knows such a bound.
    """
    if most is not None and sys.platform == "linux":
        import resource

        reserved = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (reserved + int(most * 2**30),) * 2)


def _waited() -> float | None:
    """Return how long this process was ready to run and had no core [s]; None where the system does not tell."""
    with suppress(OSError, ValueError, IndexError):
        return int(Path("/proc/self/schedstat").read_text().split()[1]) / 1e9
    return None


def _most_memory() -> float | None:
    """Return the most memory that this process has taken [GiB]; None where the system does not tell."""
    if sys.platform == "win32":
        return None
    import resource

    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**30
