"""`ngcell solve`: exit codes, the summary, the output folder, and what is kept when a run ends early."""

from __future__ import annotations

import csv
import errno
import json
import os
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from ngcell.cli import ngcell
from ngcell.errors import GeometryError, NgcellError, NotConverged
from ngcell.scene import read_case
from tests.cli.conftest import FakeRun

CASE = "shear-empty-3x3"
WRONG_NUMBERS = [(CASE, "--max-minutes", word) for word in ("0", "-1", "nan", "inf", "soon")]
WRONG_NUMBERS += [(CASE, "--threads", "0"), (CASE, "--resume", ".", "--force")]


def solve(*arguments: str) -> Result:
    return CliRunner().invoke(ngcell, ["solve", *arguments])


def history(folder: Path) -> list[dict[str, str]]:
    with (folder / "history.csv").open(newline="") as table:
        return list(csv.DictReader(table))


def test_certified_run_answers_0_and_says_first_what_matters(fake_run: FakeRun, in_empty_folder: Path) -> None:
    answer = solve(CASE)
    assert answer.exit_code == 0
    assert answer.stdout.splitlines() == [
        "certified    yes: converged; 1 check passed at each of 5 accepted steps",
        "how sure     plate displacement 1, load factor 1; with estimated errors",
        "  energy         0.3 ± 1 %",
        "  mean gap       0.004",
        "  largest gap    0.04",
        "  plate force    0.1",
        "  contact force  0.2",
        "came apart   7 of 16 wall pairs opened and 4 parted; 9 cells in 2 connected components; 2 cells held",
        "             by nothing; gaps grow from plate displacement 0.2",
        f"results      out/{CASE}, after 2.5 min; on one page: ngcell report out/{CASE}",
    ]
    assert len(history(in_empty_folder / "out" / CASE)) == 5


def test_progress_is_a_plain_line_for_each_step_where_there_is_no_terminal(
    fake_run: FakeRun, in_empty_folder: Path
) -> None:
    lines = solve(CASE).stderr.splitlines()
    assert len(lines) == 5
    words = " ".join(lines[2].split())
    assert words.startswith("step 2 released load 0.6000 energy 0.3 largest gap 2.000e-02 parted 2")
    assert words.endswith("3 of 5 levels, about 1 s left") and lines[-1].endswith("5 of 5 levels")
    assert solve(CASE, "--quiet", "--force").stderr == ""


def test_arguments_reach_the_run(fake_run: FakeRun, tmp_path: Path) -> None:
    out = tmp_path / "here"
    solve(CASE, "--out", str(out), "--threads", "2", "--set", "mesh.order=3", "--set", "tissue.wall=0.2")
    (case, folder, threads) = fake_run.asked[0]
    assert (folder, threads) == (out, 2)
    assert case == read_case(CASE, ["mesh.order=3", "tissue.wall=0.2"])
    assert read_case(out) == case


def test_uncertified_run_answers_4_and_says_so(fake_run: FakeRun, in_empty_folder: Path) -> None:
    fake_run.certified = False
    answer = solve(CASE)
    assert answer.exit_code == 4
    verdict, failed, *_ = answer.stdout.splitlines()
    assert verdict.startswith("certified    NO: converged, but 1 of 5 accepted steps failed a check")
    assert "how sure     NOT CERTIFIED; " in answer.stdout
    assert failed.startswith("  residual 0.001, limit 1e-06; to try: refine the mesh")
    assert "not certified" in answer.stderr.splitlines()[0]
    assert answer.stderr.splitlines()[-1] == f"not certified; accepted steps kept in out/{CASE}: 5"


def test_run_that_does_not_converge_answers_4_and_says_what_is_kept(fake_run: FakeRun, in_empty_folder: Path) -> None:
    fake_run.stop_after = 3
    fake_run.error = NotConverged("step too small at load 0.7", outcome="step-too-small", steps=(None,) * 3)
    answer = solve(CASE)
    assert answer.exit_code == 4
    assert answer.stdout == ""
    assert answer.stderr.splitlines()[-1] == (f"step too small at load 0.7; accepted steps kept in out/{CASE}: 3")
    assert len(history(in_empty_folder / "out" / CASE)) == 3


@pytest.mark.parametrize(
    ("accepted", "kept"), [(0, "no step was accepted"), (2, f"accepted steps kept in out/{CASE}: 2")]
)
def test_stopped_run_answers_4_and_keeps_what_it_accepted(
    fake_run: FakeRun, in_empty_folder: Path, accepted: int, kept: str
) -> None:
    fake_run.stop_after, fake_run.error = accepted, KeyboardInterrupt()
    answer = solve(CASE)
    assert answer.exit_code == 4
    assert answer.stderr.splitlines()[-1] == f"stopped by Ctrl-C; {kept}"
    folder = in_empty_folder / "out" / CASE
    assert len(history(folder)) == accepted
    assert json.loads((folder / "summary.json").read_text())["status"] == "stopped"


def test_earlier_result_is_replaced_by_force_only(fake_run: FakeRun, in_empty_folder: Path) -> None:
    solve(CASE)
    answer = solve(CASE, "--quiet", "--set", "load.levels=2")
    assert answer.exit_code == 4
    assert answer.stderr.splitlines() == [
        f"out/{CASE} holds the accepted steps of an earlier run; replace them with --force (from Python: force=True) "
        "or choose another folder"
    ]
    assert len(history(in_empty_folder / "out" / CASE)) == 5
    answer = solve(CASE, "--force", "--set", "load.levels=2")
    assert answer.exit_code == 0
    assert len(history(in_empty_folder / "out" / CASE)) == 2


@pytest.mark.parametrize("error", [GeometryError("no"), NotConverged("no", outcome="TIED_FAILED"), KeyboardInterrupt()])
def test_earlier_result_outlives_a_run_without_an_accepted_step(
    fake_run: FakeRun, in_empty_folder: Path, error: BaseException
) -> None:
    solve(CASE)
    folder = in_empty_folder / "out" / CASE
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    fake_run.error, fake_run.stop_after = error, 0
    answer = solve(CASE, "--force")
    assert answer.exit_code == error.exit_code if isinstance(error, NgcellError) else 4
    assert isinstance(error, GeometryError) or "is as it was" in answer.stderr
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_folder_with_something_else_is_left_alone(fake_run: FakeRun, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    answer = solve(CASE, "--out", str(tmp_path))
    assert answer.exit_code == 4
    assert len(answer.stderr.splitlines()) == 1
    assert str(tmp_path) in answer.stderr
    assert "choose another folder" in answer.stderr
    assert [entry.name for entry in tmp_path.iterdir()] == ["thesis.tex"]


def test_folder_that_cannot_be_made_is_one_line(fake_run: FakeRun, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    answer = solve(CASE, "--out", str(tmp_path / "file" / "out"))
    assert answer.exit_code == 4
    assert len(answer.stderr.splitlines()) == 1
    assert str(tmp_path / "file" / "out") in answer.stderr
    assert "choose another folder" in answer.stderr


def test_read_only_folder_is_one_line(fake_run: FakeRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refuse_writes(monkeypatch, after=0, reason=errno.EROFS)
    answer = solve(CASE, "--out", str(tmp_path / "out"))
    assert answer.exit_code == 4
    assert len(answer.stderr.splitlines()) == 1
    assert "Read-only file system" in answer.stderr
    assert "choose another folder" in answer.stderr


def test_full_disk_is_one_line_and_keeps_what_was_accepted(
    fake_run: FakeRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The summary, the case and the summary again come first, then a summary after each accepted step.
    refuse_writes(monkeypatch, after=5, reason=errno.ENOSPC)
    answer = solve(CASE, "--quiet", "--out", str(tmp_path / "out"))
    assert answer.exit_code == 4
    assert len(answer.stderr.splitlines()) == 1
    assert "No space left on device" in answer.stderr
    assert "free some space" in answer.stderr
    assert len(history(tmp_path / "out")) >= 2


def refuse_writes(monkeypatch: pytest.MonkeyPatch, *, after: int, reason: int) -> None:
    """Make the file system refuse whole files once `after` of them are written."""
    written: list[Path] = []
    write_bytes = Path.write_bytes

    def refuse(path: Path, content: bytes) -> int:
        if len(written) >= after:
            raise OSError(reason, os.strerror(reason))
        written.append(path)
        return write_bytes(path, content)

    monkeypatch.setattr(Path, "write_bytes", refuse)


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        (CASE, "--threads", "0"),
        (CASE, "--set", "tissue.wall"),
        (CASE, "--loud"),
        (CASE, "and-another"),
        *WRONG_NUMBERS,
    ],
)
def test_wrong_usage_answers_2(fake_run: FakeRun, arguments: tuple[str, ...]) -> None:
    assert solve(*arguments).exit_code == 2
    assert not fake_run.asked
