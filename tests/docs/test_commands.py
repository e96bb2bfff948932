"""Every command that a document shows, in a block or in a line, exists with its options; its case can be read."""

from __future__ import annotations

import re
import shlex
from importlib import import_module
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from ngcell.cli import ngcell
from ngcell.scene import read_case, shipped_cases
from tools.places import DOCS, ROOT

DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
SHOWN = re.compile(r"(?:^|`|bin/|&& )((?:ngcell|python -m tools\.\w+) [^`\n#]+)", re.MULTILINE)
COMMANDS = sorted({found.strip() for document in DOCUMENTS for found in SHOWN.findall(document.read_text())})


def parsed(group: click.Group, words: list[str]) -> dict[str, object]:
    """Return the options of a command; a name or an option that does not exist raises."""
    if words[0].startswith("-") or words[0].isupper():  # an option of the whole, or a placeholder
        return {}
    command = group.get_command(click.Context(group), words[0])
    if command is None:
        raise click.UsageError(f"no command {words[0]}")
    return dict(command.make_parser(click.Context(command)).parse_args(args=words[1:])[0])


def known(command: str) -> None:
    """Check one command."""
    words = shlex.split(command)
    if words[0] == "ngcell":
        options = parsed(ngcell, words[1:])
        if options.get("case") in shipped_cases():
            read_case(str(options["case"]), options.get("overrides") or ())
    elif len(words) > 3:
        parsed(import_module(words[2]).commands, words[3:])


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_documents_exists(command: str) -> None:
    known(command)


def test_many_are_found() -> None:
    assert len(COMMANDS) > 40


@pytest.mark.parametrize(
    "command", ["ngcell sove shear-empty", "ngcell solve --sett a=1", "python -m tools.studies no-such-study"]
)
def test_one_that_does_not_exist_is_found(command: str) -> None:
    with pytest.raises(click.UsageError):
        known(command)


#: What shown commands stand for, and what makes their tissue small.
PLACES = {"CASE": "shear-empty-3x3", "DIR...": "out/shear-empty", "DIR": "out/shear-empty", "FILE.feb": "tissue.feb",
          "STUDY": "wall-and-pressure", "STUDY.toml": "irregular"}  # fmt: skip
SMALL = ("tissue.rows=1", "tissue.cols=2", "accuracy=inf", "mesh.order=2", "load.levels=1",
         "load.displacement=[0.1, 0.0]")  # fmt: skip
#: Commands that tests of their pages run, in tests/docs/test_pages.py, and words that are no whole command.
ELSEWHERE = re.compile(r"five\.toml|micrograph\.toml|out/first|picture cells\.png|COMMAND|members N$")


def small(command: str) -> list[str]:
    """Return the words of a command of `ngcell` that does as it says to a tissue of two cells, or foresees a sweep."""
    words = [PLACES.get(word, word) for word in shlex.split(command)[1:]]
    if words[0] in {"check", "solve", "export-febio"} and "--resume" not in words:
        entries = (*SMALL, "mesh.order=1") if "shear-empty-3d" in words else SMALL
        words += [part for entry in entries for part in ("--set", entry)]
    if "--members" in words:
        words[words.index("--members") + 1] = "2"
    if words[0] == "solve" and "--resume" not in words:
        words += ["--force"]
    return [*words, "--dry-run"] if words[0] == "sweep" else words


def test_the_commands_that_are_shown_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In one folder, results first: of the README and of all pages, at small size."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    (case,) = re.findall(r"^```toml\n(.*?)^```", (ROOT / "README.md").read_text(), flags=re.DOTALL | re.MULTILINE)
    Path("mine.toml").write_text(case)
    shown = [command for command in COMMANDS if command.startswith("ngcell ") and not ELSEWHERE.search(command)]
    alone = ("--help", "cases", "schema")
    whole = [command for command in shown if len(command.split()) > 2 or command.endswith(alone)]
    ordered = sorted(whole, key=lambda command: (" solve " not in command, "--resume" in command))
    ran = [command for command in ordered if CliRunner().invoke(ngcell, small(command)).exit_code == 0]
    assert ran == ordered and len(ran) > 20
    assert Path("tissue.feb").exists() and Path("out/shear-empty/report.html").exists()
