"""Tools are called in one way: a group for each package, which tells of each command in a line."""

from __future__ import annotations

from pathlib import Path

import pytest
from click import Context
from click.testing import CliRunner

from tools import extreme, references, studies
from tools.studies import constants, patching

TOOLS = Path(extreme.__file__).parents[1]
GROUPS = {group.__name__: group.commands for group in (references, studies, extreme)}
EACH = [(package, name) for package, group in GROUPS.items() for name in group.list_commands(Context(group))]


@pytest.mark.parametrize(("package", "name"), EACH)
def test_each_command_helps_and_tells_how_it_is_called(package, name):
    answer = CliRunner().invoke(GROUPS[package], [name, "--help"])
    assert answer.exit_code == 0, answer.output
    assert f"python -m {package} {name}" in answer.output


@pytest.mark.parametrize("package", GROUPS)
def test_each_package_lists_its_commands_with_a_line_each(package):
    answer = CliRunner().invoke(GROUPS[package], ["--help"])
    assert answer.exit_code == 0, answer.output
    commands = answer.output.partition("Commands:\n")[2].splitlines()
    assert [line.split()[0] for line in commands] == GROUPS[package].list_commands(Context(GROUPS[package]))


def test_modules_are_no_scripts():
    assert [file for file in TOOLS.rglob("*.py") if "__name__ ==" in file.read_text(encoding="utf-8")] == []


@pytest.mark.parametrize("number", constants.CHANGES)
def test_numbers_of_the_solver_are_changed_where_they_are_and_put_back(number):
    before = patching.usual(number)
    with patching.changed(number, 2 * before):
        assert patching.usual(number) == 2 * before
    assert patching.usual(number) == before
