"""Tools are called in one way: a group for each package, which tells of each command in a line."""

from __future__ import annotations

import json
import sys
from operator import attrgetter
from pathlib import Path
from time import process_time

import pytest
from click import Context
from click.testing import CliRunner

import ngcell
from ngcell.scene import resolved_toml
from tools import docs, extreme, references, studies, tables
from tools.studies import constants, numbers
from tools.studies.iterations import ITERATIONS, iterated
from tools.studies.timed import Stopwatch, Timed

NARROWEST = "solver.continuation.narrowest"
TOOLS = Path(extreme.__file__).parents[1]
GROUPS = {group.__name__: group.commands for group in (references, studies, extreme, docs)}
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


def test_a_command_whose_library_is_not_installed_says_so_and_the_others_are_listed(monkeypatch):
    monkeypatch.setitem(sys.modules, "psutil", None)
    monkeypatch.delitem(sys.modules, "tools.studies.sweeps", raising=False)
    listed = CliRunner().invoke(studies.commands, ["--help"])
    assert listed.exit_code == 0 and "irregular" in listed.output, listed.output
    answer = CliRunner().invoke(studies.commands, ["sweeps"])
    assert answer.exit_code == 1 and "sweeps needs psutil" in answer.output and "[test]" in answer.output


def test_modules_are_no_scripts():
    assert [file for file in TOOLS.rglob("*.py") if "__name__ ==" in file.read_text(encoding="utf-8")] == []


def test_a_table_is_kept_where_its_successor_cannot_be_written(tmp_path):
    path = tmp_path / "table.csv"
    tables.write(path, ["one"], [{"one": 1}])
    with pytest.raises(ValueError, match="fieldnames"):
        tables.write(path, ["one"], [{"one": 2}, {"two": 2}])
    assert tables.read(path) == [{"one": "1"}]


def test_a_row_of_constants_is_kept_at_once_and_takes_the_place_of_an_older_one(tmp_path):
    path = tmp_path / "constants.csv"
    for energy in (0.5, 0.25):
        constants.keep({"number": NARROWEST, "here": "0.25", "empty: energy": energy, "code": "abc"}, path)
    constants.keep({"number": NARROWEST, "here": "0.125", "empty: energy": "failed", "code": "abc"}, path)
    rows = tables.read(path)
    assert [(row["here"], row["empty: energy"]) for row in rows] == [("0.25", "0.25"), ("0.125", "failed")]
    assert all(f"| {text} |" in constants.table(rows) for text in ("0.25", "0.125", "failed"))


@pytest.mark.parametrize("number", [number for group in constants.GROUPS for number in group.changes])
def test_a_number_of_the_solver_is_changed_in_the_record_that_is_handed_down_and_no_other(number):
    before, options = numbers.usual(number), numbers.changed(number, 2 * numbers.usual(number))
    found = {name: attrgetter(name)(options) for name in numbers.names()}
    assert {name: value for name, value in found.items() if value != numbers.usual(name)} == {number: 2 * before}
    assert numbers.usual(number) == before


def test_a_scene_is_run_with_the_numbers_that_are_handed_down():
    """A path whose weights fall in steps half as wide has more minimisations, and ends where the usual one ends, up to
    the branch on which cells come free."""
    usual, fine = (constants.run("empty", options) for options in (None, numbers.changed(NARROWEST, 0.25)))
    assert fine["iterations"] > usual["iterations"] and fine["certified"] == usual["certified"] == 1
    assert fine["energy"] == pytest.approx(usual["energy"], rel=0.03)


def test_a_point_of_the_map_is_solved_to_its_tolerance_and_the_condition_of_its_tangent_told(tmp_path):
    found = {}
    for tolerance in ("1", "1e6"):
        folder = tmp_path / tolerance
        settings = ["tissue.rows=2", "tissue.cols=2", "mesh.order=1", "load.levels=1"]
        case = tmp_path / "case.toml"
        case.write_text(resolved_toml(ngcell.read_case("shear-empty", [*settings, "accuracy=inf"])))
        answer = CliRunner().invoke(GROUPS[extreme.__name__], ["one", str(case), str(folder), "--tolerance", tolerance])
        assert answer.exit_code in (0, 4), answer.output
        found[tolerance] = json.loads((folder / "summary.json").read_text())
        assert 1e3 < float(answer.output.split()[-1]) < 1e20
        assert not list(folder.glob("*.png"))
    assert found["1"]["certified"]
    assert found["1e6"]["iterations"] < found["1"]["iterations"]


def test_seconds_of_contact_are_part_of_a_run_that_they_do_not_change():
    case = ngcell.read_case("shear-empty-3x3", ["load.levels=1", "mesh.order=1", "accuracy=inf"])
    contact, started = Stopwatch(), process_time()
    *_, timed = ngcell.simulate(case.model_copy(update={"contact": Timed(case.contact, contact)}))
    assert 0 < contact.seconds < process_time() - started
    *_, plain = ngcell.simulate(case)
    assert timed.record.energy == plain.record.energy
    assert timed.record.iterations == plain.record.iterations


def test_iterations_are_timed_one_by_one_and_their_factorisation_beside_them():
    found = iterated(
        ngcell.read_case("shear-empty", ["tissue.rows=2", "tissue.cols=2", "mesh.order=1", "accuracy=inf"])
    )
    assert found["cells"] == 4 and found["iterations"] == ITERATIONS
    assert found["seconds of an iteration"] > found["of it without the direct solver"] > 0
    assert found["factorisation and solve alone"] > 0
