"""The verbs that do not solve, and the command as a whole."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import ngcell as package
from ngcell import export
from ngcell.cli import ngcell
from ngcell.errors import GeometryError
from ngcell.scene import read_case
from tests.cli.conftest import FakeRun, accepted_step


def test_check_shows_what_would_be_solved(fake_run: FakeRun) -> None:
    answer = CliRunner().invoke(ngcell, ["check", "shear-empty", "--set", "tissue.cols=6"])
    assert answer.exit_code == 0
    assert answer.stdout.splitlines() == [
        "bodies    30",
        "unknowns  4800",
        "initial gap",
        "  smallest  0",
    ]


def test_check_tells_meshes_in_words_and_no_reason_where_errors_are_estimated() -> None:
    answer = CliRunner().invoke(ngcell, ["check", "shear-empty-3x3"])
    assert "order 2, grading 1, halvings 0, unknowns 2592; order 3" in answer.stdout and "{" not in answer.stdout
    assert "error not estimated" not in answer.stdout
    coarse = CliRunner().invoke(ngcell, ["check", "shear-empty-3x3", "--set", "accuracy=inf"])
    assert "error not estimated" in coarse.stdout


def test_check_answers_3_where_the_shape_cannot_be_built(fake_run: FakeRun) -> None:
    fake_run.error = GeometryError("mesh.size = 3: longer than a wall; allowed: at most side = 1")
    answer = CliRunner().invoke(ngcell, ["check", "shear-empty"])
    assert answer.exit_code == 3
    assert answer.stderr == "mesh.size = 3: longer than a wall; allowed: at most side = 1\n"


def test_cases_lists_names_and_titles() -> None:
    answer = CliRunner().invoke(ngcell, ["cases"])
    assert answer.exit_code == 0
    assert "shear-empty-3x3          A 3x3 tissue of hollow cells under shear" in answer.stdout.splitlines()


def test_schema_is_json() -> None:
    answer = CliRunner().invoke(ngcell, ["schema"])
    assert answer.exit_code == 0
    assert {"tissue", "material", "load", "bodies", "extends"} <= json.loads(answer.stdout)["properties"].keys()


def test_schema_is_written_for_editors(tmp_path: Path) -> None:
    answer = CliRunner().invoke(ngcell, ["schema", "--out", str(tmp_path / "case.schema.json")])
    assert answer.stdout == "first line of a case file beside it: #:schema case.schema.json\n"
    assert "tissue" in json.loads((tmp_path / "case.schema.json").read_text())["properties"]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_complete_commands_and_options(shell: str) -> None:
    from click.shell_completion import get_completion_class

    completion = get_completion_class(shell)
    assert completion is not None
    found = completion(ngcell, {}, "ngcell", "_NGCELL_COMPLETE")
    assert {"solve", "report", "view"} <= {one.value for one in found.get_completions([], "")}
    assert "--resume" in {one.value for one in found.get_completions(["solve"], "--re")}
    assert "shear-empty-3x3" in {one.value for one in found.get_completions(["solve"], "shear-")}
    assert "irregular" in {one.value for one in found.get_completions(["sweep"], "irr")}
    assert "_NGCELL_COMPLETE" in found.source()


def test_view_hands_folder_and_picture_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[tuple[Path, Path | None, float | None]] = []
    monkeypatch.setattr(export, "show", lambda folder, **how: shown.append((folder, how["screenshot"], how["clip"])))
    words = ["view", str(tmp_path), "--screenshot", str(tmp_path / "a.png")]
    assert CliRunner().invoke(ngcell, words).exit_code == 0
    assert CliRunner().invoke(ngcell, [*words, "--clip", "0.5"]).exit_code == 0
    assert shown == [(tmp_path, tmp_path / "a.png", None), (tmp_path, tmp_path / "a.png", 0.5)]
    assert CliRunner().invoke(ngcell, [*words, "--clip", "0"]).exit_code == 2


def test_view_of_a_folder_without_results_is_one_line(tmp_path: Path) -> None:
    answer = CliRunner().invoke(ngcell, ["view", str(tmp_path), "--screenshot", str(tmp_path / "a.png")])
    assert answer.exit_code == 4
    assert len(answer.stderr.splitlines()) == 1
    assert str(tmp_path) in answer.stderr


def test_view_of_nothing_answers_2(tmp_path: Path) -> None:
    assert CliRunner().invoke(ngcell, ["view", str(tmp_path / "nothing")]).exit_code == 2


def test_python_m_ngcell_is_the_command() -> None:
    answer = subprocess.run([sys.executable, "-m", "ngcell", "--version"], capture_output=True, text=True, check=True)
    assert answer.stdout == f"ngcell, version {package.__version__}\n"


def test_every_verb_has_help() -> None:
    for name, verb in ngcell.commands.items():
        answer = CliRunner().invoke(ngcell, [name, "--help"])
        assert answer.exit_code == 0
        assert isinstance(verb, click.Command) and verb.help


def test_help_begins_with_a_first_run_and_names_each_verb_in_full() -> None:
    lines = CliRunner().invoke(ngcell, ["--help"]).stdout.splitlines()
    (first,) = (line.strip() for line in lines if line.strip().startswith("ngcell solve"))
    verb, *words = first.split()[1:]
    options = dict(ngcell.commands[verb].make_parser(click.Context(ngcell.commands[verb])).parse_args(args=words)[0])
    assert read_case(str(options["case"]), options["overrides"]).title
    told = lines[lines.index("Commands:") + 1 :]
    assert len(told) == len(ngcell.commands) and all(line.endswith(".") and "..." not in line for line in told)


def test_live_line_on_a_terminal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    from ngcell.cli.progress import step_line, step_progress

    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    with step_progress() as show:
        show(accepted_step(0, 0.25))
    shown = capsys.readouterr().err
    assert step_line(accepted_step(0, 0.25)) in shown
    assert "building the scene" in shown


@pytest.mark.parametrize(("chosen", "taken"), [(None, "0"), ("1", "1")])
def test_numpy_takes_small_pages_unless_the_user_has_chosen(monkeypatch, chosen, taken):
    monkeypatch.delenv("NUMPY_MADVISE_HUGEPAGE", raising=False)
    if chosen is not None:
        monkeypatch.setenv("NUMPY_MADVISE_HUGEPAGE", chosen)
    assert CliRunner().invoke(ngcell, ["--version"]).exit_code == 0
    assert os.environ["NUMPY_MADVISE_HUGEPAGE"] == taken
