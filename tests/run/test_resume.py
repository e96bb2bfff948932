"""A run that was stopped after any step goes on from its folder and ends with the numbers of one that was not."""

from __future__ import annotations

import csv
import json
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import pyvista
from click.testing import CliRunner, Result

import ngcell
from ngcell import clock
from ngcell.build.refinement import Refinement
from ngcell.build.simulation import Simulation
from ngcell.cli import ngcell as command
from ngcell.clock import OutOfTime
from ngcell.errors import OutputError
from ngcell.run import resume

TISSUE = ["tissue.rows=2", "tissue.cols=2", "mesh.order=2", "load.displacement=[0.3, 0.0]", "accuracy=inf"]
TISSUE += ["load.levels=[0.4, 1.0]"]
PRISMS = ["tissue.rows=1", "tissue.cols=2", "tissue.height=0.4", "mesh.order=2", "load.displacement=[0.2, 0.0]"]
BONDED = [*TISSUE, "mesh.order=1", "cohesion.strength=0.01", "cohesion.energy=0.0001", 'strategy.kind="load-stepping"']
REFINED = ["tissue.rows=1", "tissue.cols=2", "accuracy=0.05", "load.displacement=[0.3, 0.0]", "load.levels=[0.4, 1.0]"]
SQUEEZED = ["tissue.rows=1", "tissue.cols=1", "accuracy=inf", 'load={kind="frame", shear=3.0, levels=[1.0]}']
SHORT = ["mesh.order=1", "load.displacement=[0.08, 0.0]"]
INDENTER = 'load={kind="indenter", shape="flat", width=1.0, depth=0.2, levels=2}'
#: Cases, their settings and their number of accepted steps.
RUNS = {
    "sddp": ("shear-empty-3x3", [*TISSUE, "strategy.steps=2"], 4),
    "single-step": ("shear-empty-3x3", [*TISSUE, 'strategy.kind="single-step"', 'contact.kind="mortar"'], 2),
    "prisms": ("shear-empty-3x3", [*PRISMS, "load.levels=1", "accuracy=inf"], 2),
    "refined": ("shear-empty-3x3", [*REFINED, "material.strength=0.001"], 4),
    "refined mortar": ("shear-empty-3x3", [*REFINED, 'strategy.kind="single-step"', 'contact.kind="mortar"'], 2),
    "finer rule": ("shear-empty-3x3", SQUEEZED, 2),
    "incremental": ("parting-rings", ["steps=4", "accuracy=inf"], 4),
    "load path": ("shear-empty-3x3", [*TISSUE, *SHORT, 'strategy.kind="load-stepping"'], 11),
    "indenter": ("shear-empty-3x3", [*TISSUE[:3], "accuracy=inf", INDENTER, 'strategy.kind="single-step"'], 2),
}


#: Kinds whose pictures are drawn and drawn again.
DRAWN = {"sddp"}


def ngcell_command(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "ngcell", *arguments], capture_output=True, text=True)


def solve(*arguments: str) -> Result:
    return CliRunner().invoke(command, ["solve", *arguments])


def kill_after(kind: str, steps: int, out: Path) -> None:
    """Run a case in a process that kills itself, unprepared, just after a step is on disk."""
    program = (
        "import os, signal, sys\n"
        "from ngcell import read_case, record\n"
        "out, steps, case, *sets = sys.argv[1:]\n"
        "for step in record(read_case(case, sets), out):\n"
        "    if step.step + 1 == int(steps):\n"
        "        os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    case, sets, _ = RUNS[kind]
    killed = subprocess.run([sys.executable, "-c", program, str(out), str(steps), case, *sets])
    assert killed.returncode == -signal.SIGKILL


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def fields(folder: Path) -> list[tuple[float, dict[str, np.ndarray]]]:
    """Return time and fields of all snapshots."""
    reader, found = pyvista.get_reader(folder / "tissue.pvd"), []
    for time in reader.time_values:
        reader.set_active_time_value(time)
        for part, block in enumerate(reader.read()):
            found.append((time, {f"{part} {name}": np.array(block.point_data[name]) for name in block.point_data}))
    return found


def assert_same_numbers(mine: list[dict[str, str]], meant: list[dict[str, str]]) -> None:
    assert len(mine) == len(meant)
    for one, two in zip(mine, meant, strict=True):
        for column in two.keys() - {"seconds"}:
            try:
                wanted = pytest.approx(float(two[column]), rel=1e-10, abs=1e-11, nan_ok=True)
                assert float(one[column]) == wanted, column
            except ValueError:
                assert one[column] == two[column]


def leaves(value: object) -> Iterator[object]:
    """Yield the entries of a table, those of its inner tables and lists included."""
    if isinstance(value, (dict, list)):
        for inner in value.values() if isinstance(value, dict) else value:
            yield from leaves(inner)
    else:
        yield value


def assert_same_result(mine: Path, meant: Path) -> None:
    for table in ("history.csv", "walls.csv", "cells.csv"):
        assert_same_numbers(rows(mine / table), rows(meant / table))
    for (time, values), (meant_time, meant_values) in zip(fields(mine), fields(meant), strict=True):
        assert time == meant_time
        for name, field in meant_values.items():
            size = np.nanmax(np.abs(field), initial=1e-3)
            np.testing.assert_allclose(values[name], field, rtol=0, atol=1e-10 * size, err_msg=name)
    one, two = (json.loads((folder / "summary.json").read_text()) for folder in (mine, meant))
    for key in two.keys() - {"seconds", "last_step", "certificate", "expected", "rupture"}:
        assert one[key] == two[key], key
    assert list(leaves(one.get("rupture"))) == [
        pytest.approx(leaf, rel=1e-9) if isinstance(leaf, float) else leaf for leaf in leaves(two.get("rupture"))
    ]
    for key in ("expected", "certificate"):
        assert len(one[key]) == len(two[key])
    for mine_found, meant_found in zip(one["expected"], two["expected"], strict=True):
        assert mine_found["measured"] == pytest.approx(meant_found["measured"], rel=1e-10)
    assert {path.name for path in mine.iterdir()} == {path.name for path in meant.iterdir()}


@dataclass(frozen=True)
class Run:
    """A run that was not stopped, and copies of its folder as they were when each step had been accepted."""

    whole: Path
    stopped: list[Path]


@pytest.fixture(scope="module")
def run_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Run]:
    """Runs by their kind, each made when a test first asks for it."""
    return cache(lambda kind: run_with_copies(kind, tmp_path_factory.mktemp(kind)))


def run_with_copies(kind: str, folder: Path) -> Run:
    case, sets, _ = RUNS[kind]
    whole, stopped = folder / "whole", []
    recording = ngcell.record(ngcell.read_case(case, sets), whole, pictures=kind in DRAWN)
    for record in recording:
        stopped.append(Path(shutil.copytree(whole, folder / str(record.step))))
    assert recording.certified
    return Run(whole, stopped)


@pytest.mark.parametrize(
    ("kind", "steps"), [(kind, steps) for kind, (*_, count) in RUNS.items() for steps in range(1, count + 1)]
)
def test_a_run_stopped_after_any_step_ends_with_the_same_numbers(run_of, kind, steps):
    out = run_of(kind).stopped[steps - 1]
    assert len(rows(out / "history.csv")) == steps
    rest = [record.step for record in resume(out, pictures=kind in DRAWN)]
    assert rest == list(range(steps, RUNS[kind][2]))
    assert_same_result(out, run_of(kind).whole)


def test_bonds_remember_what_broke_before_a_stop(tmp_path):
    whole, stopped = tmp_path / "whole", []
    for record in ngcell.record(ngcell.read_case("shear-empty-3x3", BONDED), whole, pictures=False):
        if 0.3 < record.bonded_share < 0.8 and len(stopped) < 2:
            stopped.append(Path(shutil.copytree(whole, tmp_path / str(record.step))))
    assert len(stopped) == 2
    for out in stopped:
        assert list(resume(out, pictures=False))
        assert_same_result(out, whole)


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("killed") / "out"
    kill_after("sddp", 3, out)
    return out


@pytest.fixture
def whole(run_of: Callable[[str], Run]) -> Path:
    return run_of("sddp").whole


@pytest.fixture
def stopped(killed: Path, tmp_path: Path) -> Path:
    """A folder of a killed run that may be spoilt."""
    return Path(shutil.copytree(killed, tmp_path / "out"))


def test_the_command_line_resumes(whole, stopped):
    answer = ngcell_command("solve", "--resume", str(stopped))
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.startswith("certified    yes: ")
    assert answer.stderr.startswith("step   3")
    assert_same_result(stopped, whole)


def test_what_a_kill_left_half_written_is_computed_again(whole, stopped):
    for table in ("history.csv", "walls.csv", "cells.csv"):
        with (stopped / table).open("a") as file:
            file.write("3,released,0.3")
    (stopped / "tissue_0001.vtu").write_bytes(b"half a file")
    list(resume(stopped))
    assert_same_result(stopped, whole)


def test_a_run_killed_before_its_first_step_starts_anew(stopped):
    kept = {name: (stopped / name).read_bytes() for name in ("case.toml", "summary.json")}
    for path in stopped.iterdir():
        path.unlink()
    (stopped / "case.toml").write_bytes(kept["case.toml"])
    note = json.loads(kept["summary.json"]) | {"accepted_steps": 0}
    (stopped / "summary.json").write_text(json.dumps(note))
    assert len(list(resume(stopped))) == RUNS["sddp"][2]


def test_resuming_an_ended_run_says_so(whole):
    before = {path.name: path.read_bytes() for path in whole.iterdir()}
    answer = ngcell_command("solve", "--resume", str(whole))
    assert answer.returncode == 0
    assert answer.stdout.splitlines() == [f"nothing to resume: the run in {whole} has ended (converged and certified)"]
    assert {path.name: path.read_bytes() for path in whole.iterdir()} == before
    with pytest.raises(OutputError, match="needs no resuming"):
        resume(whole)


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-200])


def change_a_digit(path: Path) -> None:
    text = path.read_text()
    place = text.index("released") + len("released,0.")
    path.write_text(text[:place] + ("7" if text[place] != "7" else "3") + text[place + 1 :])


def tell(folder: Path, **said: object) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    (folder / "summary.json").write_text(json.dumps(summary | said))


DAMAGE = {
    "no restart file": lambda folder: (folder / "restart.npz").unlink(),
    "half a restart file": lambda folder: cut(folder / "restart.npz"),
    "a restart file of nothing": lambda folder: (folder / "restart.npz").write_bytes(b""),
    "no history": lambda folder: (folder / "history.csv").unlink(),
    "a cut history": lambda folder: cut(folder / "history.csv"),
    "a cut snapshot": lambda folder: cut(folder / "tissue_0000.vtu"),
    "a cut snapshot of walls": lambda folder: cut(folder / "walls_0000.vtu"),
    "a changed digit": lambda folder: change_a_digit(folder / "history.csv"),
    "steps that are no number": lambda folder: tell(folder, accepted_steps="many"),
    "fewer steps than none": lambda folder: tell(folder, accepted_steps=-1),
    "no snapshot": lambda folder: (folder / "tissue_0000.vtu").unlink(),
    "no case": lambda folder: (folder / "case.toml").unlink(),
    "another case": lambda folder: (folder / "case.toml").write_text(
        (folder / "case.toml").read_text().replace("wall = 0.1", "wall = 0.2")
    ),
    "a case that is none": lambda folder: (folder / "case.toml").write_text("tissue"),
    "no summary": lambda folder: (folder / "summary.json").unlink(),
    "a summary that is none": lambda folder: (folder / "summary.json").write_text("{"),
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_folder_is_told_in_one_line(stopped, damage):
    damage(stopped)
    answer = solve("--resume", str(stopped))
    assert answer.exit_code == 4
    assert answer.stdout == ""
    (line,) = answer.stderr.splitlines()
    assert str(stopped) in line


def test_a_checkpoint_of_more_steps_than_were_accepted_is_refused(stopped):
    with np.load(stopped / "restart.npz") as content:
        arrays = dict(content)
    (count,) = (name for name in arrays if name.endswith("count"))
    np.savez(stopped / "restart.npz", **arrays | {count: np.array(1000)})
    answer = solve("--resume", str(stopped))
    assert answer.exit_code == 4
    assert "1000 steps where 3 were accepted" in answer.stderr and len(answer.stderr.splitlines()) == 1


def test_a_run_out_of_time_keeps_its_steps_and_is_resumed(whole, tmp_path, monkeypatch):
    times, out = iter([0.0, *[1.0] * 60]), tmp_path / "out"
    monkeypatch.setattr(clock, "monotonic", lambda: next(times, 1e9))
    case, sets, _ = RUNS["sddp"]
    with pytest.raises(ngcell.NotConverged) as ended:
        list(ngcell.record(ngcell.read_case(case, sets), out, max_minutes=1e6))
    assert ended.value.outcome == "OUT_OF_TIME" and len(ended.value.steps) == len(rows(out / "history.csv")) > 0
    summary = json.loads((out / "summary.json").read_text())
    assert summary["status"] == "stopped" and "--max-minutes" in summary["reason"]
    monkeypatch.undo()
    list(resume(out))
    assert_same_result(out, whole)


def test_a_run_out_of_time_tells_what_the_last_mesh_found(tmp_path, monkeypatch):
    """Nothing of it is accepted: resumed, the step is taken anew."""
    refined, out = Refinement._next, tmp_path / "out"

    def once(self, coarse):
        if coarse.level == 1:
            raise OutOfTime
        return refined(self, coarse)

    monkeypatch.setattr(Refinement, "_next", once)
    case = ngcell.read_case("shear-empty-3x3", [*REFINED, "load.levels=1", "accuracy=0.003"])
    told = r"; on mesh 1, not accepted: energy 0\.00\d+ ± \d+ %, mean gap"
    with pytest.raises(ngcell.NotConverged, match=told) as ended:
        list(ngcell.record(case, out))
    assert "plate force" in str(ended.value) and [step.record.phase for step in ended.value.steps] == ["tied"]


def test_a_step_that_is_accepted_is_not_on_the_way():
    simulation = Simulation(ngcell.read_case("shear-empty-3x3", [*REFINED, "load.levels=1"]))
    assert [simulation.refinement.on_the_way for _ in simulation.accepted_steps()] == [None, None]


def test_no_number_of_threads_is_refused():
    with pytest.raises(ngcell.CaseError, match="threads = 0; allowed"):
        ngcell.record(ngcell.read_case("shear-empty-3x3"), Path("nowhere"), threads=0)


@pytest.mark.parametrize("scene", ["shear-empty-3x3", None])
def test_what_is_no_scene_is_told_in_words(scene):
    """A name is read by `ngcell.read_case`."""
    for run in (ngcell.simulate, lambda given: ngcell.record(given, Path("nowhere"))):
        with pytest.raises(ngcell.CaseError, match=f"{scene!r} is no scene; allowed: a Case"):
            run(scene)


def test_no_time_is_refused():
    for minutes in (0, -1, float("nan")):
        with pytest.raises(ngcell.CaseError, match="max_minutes"):
            ngcell.record(ngcell.read_case("shear-empty-3x3"), Path("nowhere"), max_minutes=minutes)


def test_a_run_killed_while_it_replaces_another_starts_anew(stopped):
    case = (stopped / "case.toml").read_text()
    for path in stopped.iterdir():
        path.unlink()
    note = {"program": "ngcell", "status": "running", "accepted_steps": 0, "case": case}
    (stopped / "summary.json").write_text(json.dumps(note))
    assert next(iter(resume(stopped))).step == 0
    assert (stopped / "case.toml").read_text() == case


@pytest.mark.parametrize("more", [("shear-empty",), ("--set", "tissue.wall=0.2"), ("--out", "elsewhere")])
def test_the_case_and_the_folder_come_from_what_is_resumed(stopped, more):
    assert solve("--resume", str(stopped), *more).exit_code == 2


def test_something_to_solve_is_asked_for():
    assert solve().exit_code == 2
    assert solve("--resume", "/nowhere").exit_code == 2


def test_resume_is_a_name_of_the_package():
    assert ngcell.resume is resume
