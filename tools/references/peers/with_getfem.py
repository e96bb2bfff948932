"""GetFEM, if some Python here has its module: with an augmented Lagrangian, by ray tracing."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from dataclasses import asdict
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

from tools.references.peers.answer import LIMIT, STOPPED, Answer
from tools.references.peers.problems import C1, C2, Problem

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


def solve(problem: Problem, order: int) -> Answer:
    """Solve a problem.

    Raises
    ------
    RuntimeError
        If GetFEM ends without a result.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "peer.json")
        file.write_text(json.dumps(told(problem, order)))
        # That Python knows nothing of this package: it starts where the module stands.
        call = f"from getfem_run import main; main({str(file)!r})"
        command, alone = ["timeout", str(LIMIT), _python(), "-c", call], {**os.environ, "OMP_NUM_THREADS": "1"}
        here, started = Path(__file__).parent, perf_counter()
        ended = subprocess.run(command, capture_output=True, text=True, check=False, env=alone, cwd=here)
        seconds = perf_counter() - started
    lines = [line.removeprefix("ANSWER ") for line in ended.stdout.splitlines() if line.startswith("ANSWER ")]
    answer: dict[str, Any] = json.loads(lines[-1]) if lines else {}
    if "force" not in answer:
        raise RuntimeError(answer.get("error", STOPPED if ended.returncode == 124 else "no result"))
    return Answer(answer["force"], answer["opening"], seconds, answer["unknowns"])


def told(problem: Problem, order: int) -> dict[str, Any]:
    """Return what the module there is told."""
    bodies = {}
    for name, grid in problem.bodies.items():
        sides = {side: nodes.tolist() for side, nodes in grid.sides.items()}
        bodies[name] = {"places": grid.places.tolist(), "elements": grid.elements.tolist(), "sides": sides}
        bodies[name]["start"] = problem.start[name].tolist() if name in problem.start else []
    return {
        "order": order,
        "law": [C1 / 2, C2 / 2, problem.kappa / 2],
        "modulus": problem.kappa + 4 / 3,
        "bodies": bodies,
        "pairs": [asdict(pair) for pair in problem.pairs],
        "supports": [asdict(support) for support in problem.supports],
        "steps": problem.steps,
        "opening": None if problem.opening is None else asdict(problem.opening),
        "normal": problem.normal.tolist(),
    }
