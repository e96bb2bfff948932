"""What a Dask worker does with a case: it starts a process of its own for it, and tells how that ended."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from ngcell.sweeps.code import SOURCE, own_version
from ngcell.sweeps.ending import Ending
from ngcell.sweeps.task import RESULT, Result, Task

_PROGRAM = "import sys; from ngcell.sweeps.case_run import serve; serve(sys.argv[1])"
#: What Python, the standard library of C++ and OpenBLAS say where they get no memory.
_NO_MEMORY = ("MemoryError", "bad_alloc", "Memory allocation")
#: One thread for each library: as many runs as cores share the machine.
_ONE_THREAD = {
    name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")
}
#: A run that its own clock does not end is ended after this multiple of its time, and some seconds [s].
_PATIENCE, _GRACE = 2.0, 60.0
_TOO_LONG = "the process of the run did not end in time, and was killed"


def run_task(task: Task) -> Result:
    """Run a case in a process of its own, and return its result, also where that process dies."""
    started = perf_counter()
    with TemporaryDirectory(prefix="ngcell-sweep-") as folder:
        code = _run(task, folder)
        file = Path(folder) / RESULT
        if file.exists():
            found: Result = json.loads(file.read_text(encoding="utf-8"))
            return {**found, "seconds": perf_counter() - started}
        if code is None:
            return died(task, Ending.OUT_OF_TIME, _TOO_LONG, perf_counter() - started)
        ending, detail = _how_it_died(code, _last_line(Path(folder) / "errors"))
        return died(task, ending, detail, perf_counter() - started)


def _run(task: Task, folder: str) -> int | None:
    """Run a task with its files in a folder, and return the code with which its process ends; None if it was ended
    since it took too long."""
    source = str(SOURCE)
    paths = os.pathsep.join([source, *filter(None, [os.environ.get("PYTHONPATH")])])
    limit = None if task.minutes is None else _PATIENCE * 60 * task.minutes + _GRACE
    with (Path(folder) / "errors").open("wb") as errors:
        process = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM, folder],
            env={**os.environ, **_ONE_THREAD, "PYTHONPATH": paths},
            start_new_session=True,  # Ctrl-C is for the driver; where that ends, its workers and their runs follow
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=errors,
        )
        assert process.stdin is not None
        try:
            process.stdin.write(f"{json.dumps(asdict(task))}\n".encode())
            process.stdin.flush()
            return process.wait(limit)
        except subprocess.TimeoutExpired:
            return None
        except BrokenPipeError:
            process.kill()
            return process.wait()
        finally:
            process.kill()
            process.wait()
            process.stdin.close()


def died(task: Task, ending: Ending, detail: str, seconds: float = 0.0) -> Result:
    """Return the result of a task whose process has left none."""
    return {
        "key": task.key,
        "outcome": ending.told,
        "final": False,
        "detail": detail,
        "failed_checks": [],
        "unknowns": None,
        "levels": [],
        "attempts": task.attempt,
        "seconds": seconds,
        "processor_seconds": None,
        "memory_gib": None,
        "host": socket.gethostname(),
        "ngcell": own_version(),
        "ngsolve": None,
    }


def _how_it_died(code: int, last_line: str) -> tuple[Ending, str]:
    """Return what ended a process, by its code and the last line of its errors."""
    lacks_memory = any(word in last_line for word in _NO_MEMORY)
    name = signal.Signals(-code).name if code < 0 else f"code {code}"
    hint = " (as systems do that run out of memory)" if name == "SIGKILL" else ""
    said = f": {last_line}" if last_line else ""
    ending = Ending.OUT_OF_MEMORY if lacks_memory else Ending.KILLED
    return ending, f"the process of the run ended by {name}{hint}{said}"


def _last_line(file: Path) -> str:
    lines = file.read_text(encoding="utf-8", errors="replace").split("\n") if file.exists() else []
    return next((line.strip() for line in reversed(lines) if line.strip()), "")
