"""What a sweep takes beside its runs, at a small size; `python -m tools.studies sweeps` measures the large one."""

from __future__ import annotations

import json
import subprocess
import sys

from tests.sweeps.conftest import SMALLER
from tools.studies.sweeps import use_of_cores


def test_the_driver_keeps_nothing_of_runs_that_have_ended(tmp_path):
    # A process of its own: that of the tests is as large as all that ran in it before.
    script = "import json, sys; from pathlib import Path; from tools.studies.sweeps import memory_along\n"
    script += "print(json.dumps(memory_along(600, Path(sys.argv[1]))))"
    command = [sys.executable, "-c", script, str(tmp_path / "out")]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    rows = json.loads(run.stdout.splitlines()[-1])
    first, last = (next(row for row in rows if row["done"] == done) for done in (300, 600))
    assert len(rows) == 21 and rows[-1]["done"] == 600
    assert last["memory_mib"] - first["memory_mib"] < 3.0  # 300 results of 10 kB would be as much


def test_the_use_of_cores_is_told_for_a_study_and_for_its_repetition(tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(f"{SMALLER}[axes]\ntissue.wall = [0.1, 0.12]\n")
    first, again = (use_of_cores(str(file), tmp_path / "out") for _ in range(2))
    assert first["computed"] == first["cases"] == first["certified"] == 2 and again["computed"] == 0
    assert 0 < first["cores_share"] <= 1 and first["cores_share"] <= first["wanted_share"] <= 1
