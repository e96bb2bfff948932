"""Every command that a document shows, in a block or in a line, exists with its options; its case can be read."""

from __future__ import annotations

import re
import shlex
from importlib import import_module

import click
import pytest

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
