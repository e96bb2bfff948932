"""What a user gets wrong is told in one line, with the right exit code, and costs nothing: whole processes."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from ngcell import threads
from ngcell.cli import ngcell

SMALL = ["shear-empty-3x3"]
for _setting in ("tissue.rows=1", "tissue.cols=2", "mesh.order=1", "load.levels=2", "accuracy=inf"):
    SMALL += ["--set", _setting]


def command(*arguments: str, **how: object) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-m", "ngcell", *arguments]
    return subprocess.run(words, text=True, timeout=60, **{"stdout": -1, "stderr": -1} | how)  # type: ignore[call-overload,no-any-return]


def told(*arguments: str) -> Result:
    return CliRunner().invoke(ngcell, list(arguments))


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def assert_one_line(answer: Result, exit_code: int, *words: str) -> None:
    assert answer.exit_code == exit_code, answer.stderr
    (line,) = answer.stderr.splitlines()
    assert all(word in line for word in words), line


@pytest.mark.parametrize("value", ["-0.1", "abc", "nan", "[1,2,3]", "[[1, -1]]", "{a = 1}", "true"])
def test_mistyped_pressure_is_one_line(value):
    answer = told("check", "shear-pressurised", "--set", f"lumen.pressure={value}")
    assert_one_line(answer, 3, "lumen.pressure", "is not possible", "a finite number >= 0 or a list")


def test_sheet_of_the_wrong_pressures_is_one_line():
    assert_one_line(
        told("check", "shear-pressurised", "--set", "lumen.pressure=[[1.0], [2.0]]"), 3, "as many as there are cells"
    )


BLOCK = (
    'bodies = [{name = "a", kind = "block", low = [0, 0], high = [HIGH], '
    'material = {kind = "mooney-rivlin", c1 = 1.0, c2 = 1.0, bulk_modulus = 10.0}}]'
)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BLOCK.replace("HIGH", "1, 1e-300"), ["bodies[0].high[1] = 1e-300", "allowed"]),
        (BLOCK.replace("HIGH", "1e-20, 1e-20"), ["body a", "too small"]),
        (BLOCK.replace("HIGH", "1, 1e-30"), ["body a", "allowed"]),
        ("a = " + "[" * 5000 + "]" * 5000, ["nested too deep"]),
        ("a = " + "{b=" * 5000 + "1" + "}" * 5000, ["nested too deep"]),
    ],
    ids=["1e-300 high", "a dot", "a line", "lists", "tables"],
)
def test_bad_case_is_one_line(tmp_path, text, words):
    (tmp_path / "bad.toml").write_text(text)
    assert_one_line(told("check", str(tmp_path / "bad.toml")), 3, *words)


@pytest.mark.parametrize(
    "override", ["a=" + "[" * 3000 + "]" * 3000, ".".join("a" * 3000) + "=1"], ids=["a value", "a key"]
)
def test_deep_overrides_are_one_line(override):
    assert_one_line(told("check", "shear-empty", "--set", override), 3, "nested too deep")


def test_folder_and_impossible_name_as_case(tmp_path):
    assert_one_line(told("check", str(tmp_path)), 3, "a folder without a case.toml")
    assert_one_line(told("check", "x" * 5000), 3, "no such case file")


@pytest.mark.parametrize(
    ("case", "setting"),
    [
        ("shear-empty", "mesh.size=1e-9"),
        ("shear-empty-3x3", "mesh.layers=1000000"),
        ("shear-empty-3d", "mesh.slices=1000000000"),
        ("hertz-cylinders", "mesh.size=1e-9"),
        ("stacked-blocks", "mesh.size=1e-40"),
    ],
)
@pytest.mark.parametrize("verb", ["check", "solve"])
def test_meshes_beyond_the_memory_are_refused_before_they_are_made(tmp_path, verb, case, setting):
    began, out = time.process_time(), ["--out", str(tmp_path / "out")] if verb == "solve" else []
    assert_one_line(told(verb, case, "--set", setting, *out), 3, "elements", "GiB", "allowed")
    assert time.process_time() - began < 3


def test_two_runs_into_one_folder(tmp_path):
    out, many = str(tmp_path / "out"), ["--set", "load.levels=500"]
    first = subprocess.Popen(
        [sys.executable, "-m", "ngcell", "solve", *SMALL, *many, "--out", out], stderr=subprocess.PIPE, text=True
    )
    assert first.stderr is not None and first.stderr.readline().startswith("step")
    for second in (["solve", *SMALL, "--out", out, "--force"], ["solve", "--resume", out]):
        assert_one_line(told(*second), 4, "is in use", str(first.pid))
    first.kill()
    first.communicate()
    answer = told("solve", "--resume", out, "--max-minutes", "0.001", "--quiet")
    assert "in use" not in answer.stderr
    assert answer.exit_code == 4 and "--max-minutes" in answer.stderr


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("result") / "out"
    assert told("solve", *SMALL, "--out", str(out), "--quiet").exit_code == 0
    return out


def test_no_more_threads_run_than_there_are_cores(monkeypatch, caplog):
    monkeypatch.setattr(threads, "available_cores", lambda: 1)
    assert [threads.threads_for(asked) for asked in (100_000, 1, None)] == [1, 1, 1]
    assert caplog.messages == ["100000 threads were asked for; 1 run, one for each core that this process may use"]
    monkeypatch.undo()
    assert threads.available_cores() == len(os.sched_getaffinity(0))


@pytest.mark.parametrize("settings", [["--set", "mesh.size=1e-9"], ["--max-minutes", "0.00001"]])
def test_a_result_outlives_a_forced_run_that_accepts_nothing(result, settings):
    before = contents(result)
    assert told("solve", *SMALL, *settings, "--out", str(result), "--force").exit_code in (3, 4)
    assert contents(result) == before


def test_pictures_are_png_files(result, tmp_path):
    answer = told("view", str(result), "--screenshot", str(tmp_path / "v.xyz"))
    assert answer.exit_code == 2
    assert "allowed: a file that ends with .png" in answer.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["tissue.pvd", "tissue_0001.vtu", "walls_0001.vtu"])
@pytest.mark.parametrize("left", [0, 300])
def test_damaged_snapshots_cannot_be_viewed(result, tmp_path, capfd, name, left):
    for path in result.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes()[: left if path.name == name else None])
    answer = told("view", str(tmp_path), "--screenshot", str(tmp_path / "a.png"))
    assert_one_line(answer, 4, "cannot read the last snapshot")
    assert not capfd.readouterr().err  # of VTK, which writes beside Python's streams


def test_full_standard_output_is_one_line():
    for words in (["cases"], ["--help"]):
        with open("/dev/full", "w") as full:
            answer = command(*words, stdout=full)
        assert answer.returncode == 4
        assert answer.stderr.splitlines() == [
            "cannot write the answer: No space left on device; what was written to folders is kept there"
        ]


def test_a_run_needs_no_standard_streams(tmp_path):
    words = " ".join(f"'{word}'" for word in [sys.executable, "-m", "ngcell", "solve", *SMALL, "--out", str(tmp_path)])
    assert subprocess.run(f"{words} <&- >&- 2>&-", shell=True, stdout=subprocess.DEVNULL).returncode == 0
    assert (tmp_path / "history.csv").read_text().startswith("step,")
    assert '"finished"' in (tmp_path / "summary.json").read_text()
