"""GetFEM on blocks and rings, if some Python here has its module: with an augmented Lagrangian, by ray tracing."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from time import perf_counter

from tools.references.peers.problems import C1, C2, KAPPA, PRESSED, grids

#: Pythons that may have it: the system's, for which Debian has it as python3-getfem.
PYTHONS = ("/usr/bin/python3", "python3")


@cache
def _python() -> str:
    for python in PYTHONS:
        try:
            found = subprocess.run([python, "-c", "import getfem"], capture_output=True, check=False)
        except OSError:
            continue
        if found.returncode == 0:
            return python
    return ""


def missing() -> str:
    """Return why it cannot run here; empty where it can."""
    return "" if _python() else "GetFEM: no Python with the module `getfem` (Debian: python3-getfem)"


def force(problem: str, count: int, order: int) -> tuple[float, float, int]:
    """Return the force that `exact_force` tells, seconds on the clock, and the number of unknowns.

    Raises
    ------
    RuntimeError
        If GetFEM ends without a result.
    """
    kappa = KAPPA[problem]
    given = {"problem": problem, "order": order, "c1": C1, "c2": C2, "kappa": kappa, "modulus": kappa + 4 / 3}
    given |= {"pressed": PRESSED, "grids": [grid.places.tolist() for grid in grids(problem, count)]}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "peer.json")
        file.write_text(json.dumps(given))
        # That Python knows nothing of this package: it starts where the module stands.
        call = f"from getfem_run import main; main({str(file)!r})"
        command, alone = ["timeout", "120", _python(), "-c", call], {**os.environ, "OMP_NUM_THREADS": "1"}
        here, started = Path(__file__).parent, perf_counter()
        ended = subprocess.run(command, capture_output=True, text=True, check=False, env=alone, cwd=here)
        seconds = perf_counter() - started
    told = [line.removeprefix("ANSWER ") for line in ended.stdout.splitlines() if line.startswith("ANSWER ")]
    answer = json.loads(told[-1]) if told else {"error": "no result"}
    if "error" in answer:
        raise RuntimeError(answer["error"])
    return float(answer["force"]), seconds, int(answer["unknowns"])
