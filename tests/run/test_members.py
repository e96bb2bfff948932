"""Members of a case: tables over all of them, members that fail, and members that were stopped."""

from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import ngcell
from ngcell import ensemble
from ngcell.cli import ngcell as command
from ngcell.errors import NotConverged
from ngcell.report.sources import read_source

CASE = "shear-empty-3x3"
SMALL = ["tissue.rows=1", "tissue.cols=2", "mesh.order=1", "load.displacement=[0.3, 0.0]", "accuracy=inf"]
SMALL += ["load.levels=2"]
SETS = [part for setting in SMALL for part in ("--set", setting)]


def solve(*arguments: str) -> Result:
    return CliRunner().invoke(command, ["solve", *arguments])


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def summary(folder: Path) -> dict:
    return json.loads((folder / "summary.json").read_text())


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three members of two cells that were not stopped."""
    out = tmp_path_factory.mktemp("members") / "out"
    answer = solve(CASE, *SETS, "--members", "3", "--seed", "5", "--spread", "0.01", "--out", str(out), "-q")
    assert answer.exit_code == 0, answer.output
    (out.parent / "answer.txt").write_text(answer.stdout)
    return out


def test_each_member_is_a_run_of_its_own(whole: Path) -> None:
    found = rows(whole / "members.csv")
    assert [(row["member"], row["seed"], row["level"]) for row in found] == [
        (str(number), str(5 + number), level) for number in range(3) for level in "01"
    ]
    for row in found:
        folder = whole / f"member_00{row['member']}"
        released = [step for step in rows(folder / "history.csv") if step["phase"] == "released"]
        step = released[int(row["level"])]
        same = ("energy", "plate_force_x", "mean_gap", "parted_pairs", "load_factor", "energy_error")
        assert [float(row[name]) for name in same] == pytest.approx([float(step[name]) for name in same], nan_ok=True)
        assert row["certified"] == "True" and row["outcome"] == summary(folder)["outcome"]
        case = ngcell.read_case(folder)
        assert case == ngcell.scene.member_of(ngcell.read_case(CASE, SMALL), int(row["seed"]), 0.01)


def test_spread_is_over_the_members_of_the_table(whole: Path) -> None:
    found, members = rows(whole / "spread.csv"), rows(whole / "members.csv")
    for row in found:
        values = [float(one[row["number"]]) for one in members if one["level"] == row["level"]]
        assert float(row["mean"]) == pytest.approx(np.mean(values), rel=1e-12)
        assert float(row["deviation"]) == pytest.approx(np.std(values, ddof=1), rel=1e-9, abs=1e-14)
        assert int(row["members"]) == 3
    energy = [row for row in found if row["number"] == "energy"]
    assert [float(row["load_factor"]) for row in energy] == [0.5, 1.0]
    assert 0.003 < float(energy[-1]["deviation"]) / float(energy[-1]["mean"]) < 0.1
    told = {(row["level"], row["number"]): row["mean"] for row in summary(whole)["spread"]}
    assert told == {(int(row["level"]), row["number"]): float(row["mean"]) for row in found}


def test_the_terminal_has_a_line_for_each_number(whole: Path) -> None:
    lines = (whole.parent / "answer.txt").read_text().splitlines()
    assert lines[0] == "members      3 of 3 certified, seeds 5 to 7, spread 0.01"
    (energy,) = (line for line in lines if line.startswith("  energy "))
    assert ", spread over 3 members " in energy and "(mesh not estimated)" in energy
    assert lines[-1] == f"results      {whole}"
    assert (whole / "spread.png").stat().st_size > 10_000


def test_members_killed_on_their_way_end_with_the_same_tables(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    program = (
        "import os, signal, sys\n"
        "from pathlib import Path\n"
        "from ngcell import ensemble, read_case\n"
        "from ngcell.scene import MemberChoice\n"
        "out, case, *sets = sys.argv[1:]\n"
        "for number, step in ensemble.Ensemble(read_case(case, sets), Path(out), MemberChoice(3, 5, 0.01)):\n"
        "    if (number, step.step) == (1, 1):\n"
        "        os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    killed = subprocess.run([sys.executable, "-c", program, str(out), CASE, *SMALL], env=os.environ)
    assert killed.returncode == -signal.SIGKILL
    assert len(rows(out / "members.csv")) == 2
    before = {path.name: path.stat().st_mtime_ns for path in (out / "member_000").iterdir()}
    answer = solve("--resume", str(out))
    assert answer.exit_code == 0, answer.output
    assert "member 2 of 3  step   2" in answer.stderr and "member 1 of 3" not in answer.stderr
    assert "step   1" not in answer.stderr.splitlines()[0]
    assert {path.name: path.stat().st_mtime_ns for path in (out / "member_000").iterdir()} == before
    for name in ("members.csv", "spread.csv", "case.toml"):
        assert (out / name).read_bytes() == (whole / name).read_bytes(), name
    assert summary(out) == summary(whole)
    again = solve("--resume", str(out))
    assert again.exit_code == 0 and again.stdout.startswith("nothing to resume: the run in ")


def test_members_out_of_time_are_resumed(tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = solve(CASE, *SETS, "--members", "2", "--out", str(out), "-q", "--max-minutes", "1e-9")
    assert answer.exit_code == 4
    assert "after 0 members: the run has taken the time that it was given" in answer.stderr
    assert summary(out)["status"] == "stopped"
    assert solve("--resume", str(out), "-q").exit_code == 0
    assert len(rows(out / "members.csv")) == 4


def test_a_member_without_geometry_is_a_row_and_does_not_count(tmp_path: Path) -> None:
    thick = ("tissue.wall=0.74", "mesh.order=2", "load.displacement=[0.01, 0.0]", "load.levels=1")
    sets = [*SETS, *(word for entry in thick for word in ("--set", entry))]
    answer = solve(CASE, *sets, "--members", "3", "--spread", "0.1", "--out", str(tmp_path / "out"), "-q")
    found = rows(tmp_path / "out" / "members.csv")
    refused = [row for row in found if row["outcome"].startswith("refused: member of seed")]
    assert 0 < len(refused) < 3, "choose a thickness that some members exceed"
    assert all(row["certified"] == "False" and row["energy"] == "nan" for row in refused)
    assert answer.exit_code == 4
    assert f"members      {3 - len(refused)} of 3 certified" in answer.stdout
    assert f"  seed {refused[0]['seed']}: refused: " in answer.stdout
    for row in rows(tmp_path / "out" / "spread.csv"):
        assert int(row["members"]) == 3 - len(refused)


def test_a_member_without_geometry_keeps_no_earlier_result(tmp_path: Path) -> None:
    out = tmp_path / "out"
    ngcell.members(ngcell.read_case(CASE, [*SMALL, "load.levels=1"]), out, count=4, pictures=False)
    thick = ["tissue.wall=0.74", "mesh.order=2", "load.displacement=[0.01, 0.0]", "load.levels=1"]
    case = ngcell.read_case(CASE, [*SMALL, *thick])
    ngcell.members(case, out, count=3, spread=0.1, force=True, pictures=False)
    ran = {row["member"] for row in rows(out / "members.csv") if not row["outcome"].startswith("refused")}
    assert 0 < len(ran) < 3
    assert {path.name for path in out.glob("member_*")} == {f"member_00{number}" for number in ran}
    assert [run.path.name for run in read_source(out).runs] == [f"member_00{number}" for number in sorted(ran)]


def test_a_report_leaves_out_what_an_earlier_run_has_left(whole: Path, tmp_path: Path) -> None:
    out = Path(shutil.copytree(whole, tmp_path / "out"))
    first = (out / "members.csv").read_text().splitlines()[:3]
    (out / "members.csv").write_text("\n".join(first) + "\n")
    assert [run.path.name for run in read_source(out).runs] == ["member_000"]


def test_a_member_that_fails_is_a_row_with_its_outcome(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Failing:
        """A run that accepts one step and finds no equilibrium then."""

        def __init__(self, *arguments, **how):
            self.run, self.summary = record(*arguments, **how), {"certified": False, "outcome": "no equilibrium"}

        def __iter__(self):
            steps = iter(self.run)
            yield next(steps)
            yield next(steps)
            raise NotConverged("at load factor 1: no equilibrium", outcome="RELEASE_FAILED")

    record, calls = ensemble.record, []

    def sometimes(*arguments, **how):
        calls.append(arguments)
        return Failing(*arguments, **how) if len(calls) == 2 else record(*arguments, **how)

    monkeypatch.setattr(ensemble, "record", sometimes)
    found = ngcell.members(ngcell.read_case(CASE, SMALL), tmp_path / "out", count=3, pictures=False)
    energy = [row for row in found if row.number == "energy"]
    assert [row.members for row in energy] == [3, 2]
    table = rows(tmp_path / "out" / "members.csv")
    assert [row["outcome"] for row in table if row["member"] == "1"] == ["no equilibrium"] * 2
    assert [row["energy"] == "nan" for row in table] == [False, False, False, True, False, False]
    assert summary(tmp_path / "out")["outcome"] == "2 of 3 members are certified"


def test_an_earlier_result_is_replaced_by_force_only(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    case = ngcell.read_case(CASE, [*SMALL, "load.levels=1"])
    ngcell.members(case, out, count=3, pictures=False)
    refused = solve(CASE, *SETS, "--members", "2", "--out", str(out))
    assert refused.exit_code == 4 and "--force" in refused.stderr
    ngcell.members(case, out, count=2, spread=0.01, force=True, pictures=False)
    assert len(rows(out / "members.csv")) == 2
    assert sorted(path.name for path in out.iterdir() if path.is_dir()) == ["member_000", "member_001"]
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    thick = ["--set", "tissue.wall=0.86", "--members", "2", "--spread", "0.1", "--force"]
    nothing = solve(CASE, *SETS, *thick, "--out", str(out))
    assert nothing.exit_code == 4 and "refused" in nothing.stdout
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize(
    "arguments", [("--seed", "1"), ("--spread", "0.1"), ("--members", "1"), ("--members", "2", "--verify-penalty")]
)
def test_wrong_usage_answers_2(arguments: tuple[str, ...]) -> None:
    assert solve(CASE, *arguments).exit_code == 2


def test_user_defined_bodies_answer_3_in_one_line(tmp_path: Path) -> None:
    answer = solve("press-fit", "--members", "2", "--out", str(tmp_path / "out"))
    assert answer.exit_code == 3
    assert answer.stderr == (
        "members differ in the cells of a tissue; this scene is of user-defined bodies and has none\n"
    )
    assert not (tmp_path / "out").exists()
