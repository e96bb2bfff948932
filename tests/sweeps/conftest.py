"""Studies of a tissue of two cells, and workers that only pretend to run them."""

from __future__ import annotations

import socket
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import distributed
import pytest

from ngcell.sweeps.task import Task

#: Two cells on a coarse mesh: a run of a second.
SMALL = """\
case = "shear-empty-3x3"

[set]
accuracy = inf
tissue = { rows = 1, cols = 2 }
mesh.order = 1
load.levels = 2
load.displacement = [0.1, 0.0]

"""
#: One level, which takes half of the time.
SMALLER = SMALL.replace("levels = 2", "levels = 1")


def pretend(task: Task) -> dict[str, Any]:
    """Return a result that follows from the case, at once."""
    case = tomllib.loads(task.text)
    energy = case["tissue"]["wall"] ** 3 * case["material"]["c1"]
    levels = case["load"]["levels"]
    steps = [{"energy": energy * (level + 1), "certified": True, "parted_pairs": level} for level in range(levels)]
    return {
        "key": task.key, "outcome": "certified", "final": True, "detail": "", "failed_checks": [], "unknowns": 10,
        "levels": [{"load_factor": (n + 1) / levels, "step": step} for n, step in enumerate(steps)],
        "attempts": task.attempt, "seconds": 0.1, "processor_seconds": 0.1, "memory_gib": 0.1,
        "host": socket.gethostname(), "ngcell": "0", "ngsolve": "0",
    }  # fmt: skip


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """A study of six cases."""
    file = tmp_path / "study.toml"
    file.write_text(f"{SMALL}[axes]\ntissue.wall = [0.08, 0.1, 0.12]\nmaterial.c1 = [0.5, 1.0]\n")
    return file


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """Address of a scheduler with two workers in threads of this process."""
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, protocol="tcp", host="127.0.0.1", dashboard_address=None
    ) as cluster:
        yield cluster.scheduler_address
