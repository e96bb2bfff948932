"""From a case file to the folder it leaves, by the front door."""

from __future__ import annotations

import csv
import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import pyvista

import ngcell
from ngcell.errors import OutputError

PAGE = Path(__file__).parents[2] / "docs" / "output.md"
SMALL = ["tissue.rows=2", "tissue.cols=3", "load.displacement=[0.3, 0.0]", "load.levels=2", "accuracy=0.1"]


def arguments(*more: str, out: Path) -> list[str]:
    sets = [word for entry in (*SMALL, *more) for word in ("--set", entry)]
    return [sys.executable, "-m", "ngcell", "solve", "shear-empty-3x3", "--out", str(out), *sets]


def rows(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("run") / "out"
    run = subprocess.run(arguments(out=out), capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("certified    yes: converged; ")
    return out


def test_a_tissue_that_nothing_holds_together_says_so_and_tells_no_round_off(tmp_path: Path):
    sets = ["tissue.cols=1", "load.displacement=[0.0, 0.3]", "load.levels=1", "accuracy=inf", "mesh.order=1"]
    run = subprocess.run(arguments(*sets, out=tmp_path / "out"), capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert "no wall is strained" in run.stdout and "largest gap    0.3\n" in run.stdout
    assert "energy   " not in run.stdout and "plate force" not in run.stdout


def test_the_folder_holds_what_its_page_lists(solved: Path):
    named = re.findall(r"^\| (`[^|]+`) \|", PAGE.read_text(), flags=re.MULTILINE)
    files = [name.strip("` ") for entry in named for name in entry.split(",")]
    assert {"case.toml", "history.csv", "summary.json", "gap.png"} <= set(files)
    assert all((solved / name).stat().st_size > 0 for name in files)


def test_the_summary_carries_certificate_and_seconds(solved: Path):
    summary = json.loads((solved / "summary.json").read_text())
    assert summary["certified"] and all(check["passed"] for check in summary["certificate"].values())
    phases = summary["seconds"]["processor_by_phase"]
    assert {"meshing", "pairs and energies", "assembly", "factorisation", "output"} <= set(phases)
    assert sum(phases.values()) <= summary["seconds"]["processor"] * 1.01


def test_the_resolved_case_gives_the_same_numbers_again(solved: Path):
    last = [row for row in rows(solved / "history.csv") if row["phase"] == "released"][-1]
    again = ngcell.simulate(ngcell.read_case(solved / "case.toml"))[-1].record
    for column in ("energy", "plate_force_x", "mean_gap", "largest_gap"):
        assert getattr(again, column) == pytest.approx(float(last[column]), rel=1e-8)


def test_every_level_has_a_row_for_every_facing_pair(solved: Path):
    history = [row for row in rows(solved / "history.csv") if row["phase"] == "released"]
    walls = rows(solved / "walls.csv")
    assert [float(row["load_factor"]) for row in history] == [0.5, 1.0]
    assert len(walls) == 2 * 9  # 2 x 3 cells: 2 * 2 pairs in rows, 5 between them
    for row in history:
        mine = [wall for wall in walls if wall["step"] == row["step"]]
        assert max(float(wall["largest_gap"]) for wall in mine) == pytest.approx(float(row["largest_gap"]))
        assert sum(wall["parted"] == "True" for wall in mine) == int(row["parted_pairs"])


def test_the_lines_of_its_page_open_the_result(solved: Path, monkeypatch: pytest.MonkeyPatch):
    (snippet,) = re.findall(r"```python\n(import pyvista.*?)```", PAGE.read_text(), flags=re.DOTALL)
    shown = []
    monkeypatch.setattr(pyvista.UnstructuredGrid, "plot", lambda grid, **how: shown.append((grid, how)))
    exec(snippet.replace("out/shear-empty", str(solved)), {})
    (grid, how) = shown[0]
    assert how["scalars"] in grid.point_data
    moved = grid.points[:, 0] - grid.points[:, 0].min()
    assert np.ptp(moved) > 5.0
    assert set(np.unique(grid.cell_data["cell_id"])) == set(range(6))


def test_a_killed_run_leaves_all_that_it_had_accepted(tmp_path: Path):
    out = tmp_path / "out"
    run = subprocess.Popen(arguments("load.levels=40", out=out), stderr=subprocess.PIPE, text=True)
    assert run.stderr is not None
    for _ in range(4):
        assert "step" in run.stderr.readline()
    time.sleep(0.05)
    run.send_signal(signal.SIGKILL)
    run.wait()
    assert json.loads((out / "summary.json").read_text())["status"] == "running"
    accepted = rows(out / "history.csv")
    assert len(accepted) >= 4 and all(row["certified"] == "True" for row in accepted)
    reader = pyvista.get_reader(out / "tissue.pvd")
    reader.set_active_time_value(reader.time_values[-1])
    assert reader.read()[0].n_cells > 0


def test_an_unusable_folder_is_told_before_anything_is_solved(tmp_path: Path):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    with pytest.raises(OutputError, match="choose another folder"):
        list(ngcell.record(ngcell.read_case("shear-empty"), blocked / "out"))


def test_a_result_that_fails_a_check_is_labelled_everywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    from ngcell.results import certificate

    monkeypatch.setitem(certificate.LIMITS, "penetration_over_wall", 1e-9)
    run = ngcell.record(ngcell.read_case("shear-empty-3x3", [*SMALL, "load.levels=1"]), tmp_path / "out")
    records = list(run)
    assert not run.certified and "failed" in run.outcome
    assert not records[-1].certified
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert not summary["certified"] and "penetration_over_wall" in str(summary["failed_steps"])
    vtu = pyvista.read(sorted((tmp_path / "out").glob("tissue_*.vtu"))[-1])
    assert vtu.field_data["ngcell_verdict"][0] == "NOT CERTIFIED"
