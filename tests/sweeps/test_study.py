"""What a study says: the points of each kind of axis, the cases that they make, and what is refused in one line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import ngcell
from ngcell.cli import ngcell as command
from ngcell.errors import CaseError
from ngcell.scene.study import Study
from ngcell.scene.study_reader import WrittenStudy, read_study
from ngcell.sweeps.cases import Cases
from ngcell.sweeps.identity import content_key
from tests.sweeps.conftest import SMALL


def points(**axis: object) -> list[object]:
    (found,) = Study(case="shear-empty", axes={"tissue.wall": axis}).axes.values()
    return [point if len(point) > 1 else point[0] for point in found.points()]


def cases(axes: str) -> Cases:
    return Cases(WrittenStudy(Study(case="shear-empty-3x3", axes=axes)))


def test_a_range_has_both_ends_and_whole_numbers_where_it_is_of_whole_numbers():
    assert points(kind="range", start=0.1, stop=0.3, number=3) == pytest.approx([0.1, 0.2, 0.3])
    whole = points(kind="range", start=0, stop=6, number=4)
    assert whole == [0, 2, 4, 6] and all(isinstance(value, int) for value in whole)
    assert points(kind="range", start=0, stop=1, number=3) == [0.0, 0.5, 1.0]
    assert points(kind="range", start=3, stop=5, number=1) == [3]


def test_a_logarithmic_range_multiplies():
    assert points(kind="log-range", start=0.01, stop=1.0, number=3) == pytest.approx([0.01, 0.1, 1.0])


@pytest.mark.parametrize("scale", ["uniform", "log"])
def test_random_numbers_follow_from_their_seed_and_more_contain_fewer(scale):
    drawn = {"kind": "random", "low": 0.01, "high": 1.0, "scale": scale}
    many = points(**drawn, number=400, seed=3)
    assert many[:5] == points(**drawn, number=5, seed=3) != points(**drawn, number=5, seed=4)
    assert 0.01 <= min(many) and max(many) <= 1.0
    median = {"uniform": 0.505, "log": 0.1}[scale]
    assert np.median(many) == pytest.approx(median, rel=0.25)


def test_a_latin_hypercube_has_one_point_in_each_part_of_each_interval():
    over = {"tissue.wall": [0.0, 1.0], "material.c1": {"low": 1.0, "high": 100.0, "scale": "log"}}
    found = np.array(points(kind="latin-hypercube", over=over, number=10, seed=1))
    assert sorted(np.floor(10 * found[:, 0])) == list(range(10))
    assert sorted(np.floor(5 * np.log10(found[:, 1]))) == list(range(10))


def test_lists_that_are_zipped_are_taken_together():
    zipped = {"kind": "zip", "values": {"tissue.wall": [0.1, 0.2], "tissue.side": [1.0, 2.0]}}
    found = cases({"material.c1": [1.0, 2.0], "both": zipped})
    assert len(found) == 4
    assert [tuple(found.values(number).values()) for number in range(4)] == [
        (1.0, 0.1, 1.0), (1.0, 0.2, 2.0), (2.0, 0.1, 1.0), (2.0, 0.2, 2.0),
    ]  # fmt: skip


def test_cases_are_what_set_gives_on_the_command_line():
    found = cases({"tissue.wall": [0.05, 0.2], "mesh.order": {"kind": "range", "start": 1, "stop": 3, "number": 3}})
    last = ngcell.read_case("shear-empty-3x3", ["tissue.wall=0.2", "mesh.order=3"])
    untitled = {"title": found.case(5).title}  # a study has a title of its own
    assert found.case(5) == last.model_copy(update=untitled)
    assert content_key(found.case(5)) == content_key(last) != content_key(found.case(4))


def test_a_table_with_a_kind_takes_the_place_of_a_part_of_the_case():
    found = cases({"lumen": [{"kind": "pressure", "pressure": 0.1}, {"kind": "fluid"}]})
    assert [found.case(number).lumen.kind for number in range(2)] == ["pressure", "fluid"]


def test_a_key_is_set_alone_and_a_table_with_its_kind_as_a_whole(tmp_path):
    file = tmp_path / "study.toml"
    tissue = "tissue.kind = 'perturbed'\ntissue.spread = 0.02\n"
    axes = "[axes]\ntissue.seed = [1, 2]\n"
    file.write_text(f"case = 'shear-filled'\n[set]\n{tissue}lumen = {{ kind = 'fluid' }}\n{axes}")
    case = Cases(read_study(file)).case(1)
    assert (case.tissue.kind, case.tissue.spread, case.tissue.seed, case.tissue.rows) == ("perturbed", 0.02, 2, 5)
    assert case.lumen.kind == "fluid"
    axes = "[axes]\nmaterial.c1 = [1.0]\n"
    file.write_text(f"case = 'shear-empty'\nset.load.levels = 3\n[set.tissue]\nwall = 0.07\n{axes}")
    case = Cases(read_study(file)).case(0)
    assert (case.load.levels, case.tissue.wall, case.tissue.cols) == (3, 0.07, 7)


def test_files_that_a_study_names_are_beside_it(tmp_path, monkeypatch):
    (tmp_path / "own.toml").write_text('extends = "shear-empty-3x3"\ntissue.wall = 0.07\n')
    file = tmp_path / "study.toml"
    file.write_text('case = "own.toml"\naxes.material.c1 = [1.0]\n')
    monkeypatch.chdir("/")
    assert Cases(read_study(file)).case(0).tissue.wall == 0.07


def test_a_name_of_a_result_changes_with_the_file_that_the_case_names(tmp_path):
    shapes = tmp_path / "cells.geojson"
    squares = [[[[x, 0], [x + 1, 0], [x + 1, 1], [x, 1], [x, 0]]] for x in (0, 1)]
    parts = [{"type": "Polygon", "coordinates": square} for square in squares]
    text = json.dumps({"type": "GeometryCollection", "geometries": parts})
    shapes.write_text(text)
    sets = [f"tissue={{kind='polygons', file='{shapes}', wall=0.1}}"]
    case = ngcell.read_case("shear-empty-3x3", sets)
    before = content_key(case)
    shapes.write_text(f"{text}\n")
    assert content_key(case) != before


def test_the_schema_of_a_study_lists_its_keys_and_axes():
    answer = CliRunner().invoke(command, ["schema", "--study"])
    node = json.loads(answer.stdout)
    assert node["required"] == ["case", "axes"]
    kinds = node["properties"]["axes"]["additionalProperties"]["properties"]["kind"]["anyOf"][0]["enum"]
    assert {"grid", "range", "log-range", "random", "zip", "latin-hypercube"} == set(kinds)


@pytest.mark.parametrize("name", ["wall-and-pressure", "irregular"])
def test_shipped_studies_are_found_by_name_and_their_cases_are_cases(name):
    found = Cases(read_study(name))
    assert len({content_key(found.case(number)) for number in range(len(found))}) == len(found) >= 30


#: What is wrong: text of the study (after its head), and words of the one line.
WRONG = {
    "no such key": ("[axes]\ntissue.wal = [0.1]", (":11: tissue.wal = 0.1 is unknown; did you mean wall?",)),
    "a wrong value": ("[axes]\ntissue.wall = [0.1, -0.1]", (":11: tissue.wall = -0.1", "a finite number > 0")),
    "an empty grid": ("[axes]\ntissue.wall = []", (":11: axes.tissue.wall", "is empty", "at least one value")),
    "no axes": ("[axes]", (":10: axes", "at least one")),
    "axes forgotten": ("", ("axes is missing",)),
    "unequal lists": (
        "[axes]\nboth = { kind = 'zip', values = { tissue.wall = [0.1], tissue.side = [1.0, 2.0] } }",
        (":11: axes.both.values", "tissue.wall has 1, tissue.side has 2"),
    ),
    "one key twice": (
        "[axes]\ntissue.wall = [0.1]\nb = { kind = 'zip', values = { tissue.wall = [0.2] } }",
        (":12: axes.b: tissue.wall is in tissue.wall already",),
    ),
    "tables that say another axis' key": (
        "[axes]\n\"tissue.wall\" = [0.1, 0.2]\ntissue = [{ wall = 0.15 }]",
        (":12: axes.tissue: tissue.wall is in tissue.wall as well",),
    ),
    "lists that say another axis' key": (
        "[axes]\nmaterial.angles = [[1.0, 0.0], [2.0, 0.0]]\n\"material.angles.0\" = [0.5, 0.7]",
        (":11: axes.material.angles: material.angles.0 is in material.angles.0 as well",),
    ),
    "one key, spelt twice": (
        "[axes]\ntissue.wall = [0.1]\n\"tissue. wall\" = [0.2]",
        (":12: axes.tissue. wall: tissue. wall is in tissue.wall already",),
    ),
    "set as well": ("[axes]\nmesh.order = [1, 2]", (":11: axes.mesh.order: mesh.order is in set already",)),
    "no such kind": (
        "[axes]\ntissue.wall = { kind = 'rnage', start = 0.1, stop = 0.2, number = 3 }",
        (':11: axes.tissue.wall.kind = "rnage"', "did you mean range?"),
    ),
    "no kind": ("[axes]\ntissue.wall = { start = 0.1, stop = 0.2 }", (":11: axes.tissue.wall.kind is missing",)),
    "no points": (
        "[axes]\ntissue.wall = { kind = 'range', start = 0.1, stop = 0.2, number = 0 }",
        (":11: axes.tissue.wall.number = 0", "a whole number from 1 to 100000"),
    ),
    "an interval upside down": (
        "[axes]\ntissue.wall = { kind = 'random', low = 0.2, high = 0.1, number = 3 }",
        (":11: axes.tissue.wall.high = 0.1", "> low = 0.2"),
    ),
    "a logarithm of zero": (
        "[axes]\ntissue.wall = { kind = 'random', low = 0.0, high = 0.1, number = 3, scale = 'log' }",
        (":11: axes.tissue.wall", "0 < low"),
    ),
    "a wrong setting": ("material.c1 = -1.0\n[axes]\ntissue.wall = [0.1]", (":10: material.c1 = -1.0",)),
    "through a number": ("[axes]\ntissue.wall.thin = [0.1]", (":11: tissue.wall.thin", "nothing to set thin in")),
    "a combination that no case allows": (
        "[axes]\ntissue.wall = [0.1, 0.9]\nmaterial.c1 = [1.0, 2.0]", (":11: tissue.wall = 0.9", "0.866025"),
    ),
    "no interval": (
        '[axes.hyper]\nkind = "latin-hypercube"\nnumber = 4\n[axes.hyper.over]\n"tissue.wall" = 3\n',
        ("axes.hyper.over: tissue.wall = 3 is no interval", "[low, high]"),
    ),
}  # fmt: skip


def told(file: Path) -> str:
    """Return the one line that a study is refused with; nothing has been written."""
    answer = CliRunner().invoke(command, ["sweep", str(file), "--out", str(file.parent / "out")])
    assert answer.exit_code == 3, answer.output
    (line,) = answer.stderr.splitlines()
    assert not (file.parent / "out").exists()
    return line


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_study_is_one_line_before_anything_runs(name, tmp_path):
    text, words = WRONG[name]
    file = tmp_path / "study.toml"
    file.write_text(SMALL + text)
    line = told(file)
    assert all(word in line for word in words), line


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ('case = "shear-emty"\n', (":1: case: shear-emty", "did you mean shear-empty?")),
        ('case = 3\n', (":1: case = 3", "text in quotes")),
        ('cas = "shear-empty"\n', (":1: cas", "did you mean case?")),
        ('case = "shear-empty-3x3"\noutputs = ["enrgy"]\n', (":2: outputs: no run has the column 'enrgy'", "energy?")),
        ('case = "shear-empty-3x3"\noutputs = ["rotation"]\n', ("no run has the column 'rotation'",)),
        ('case = "shear-empty-3x3"\nminutes = 0\n', (":2: minutes = 0", "a finite number > 0")),
        ('case = "shear-empty-3x3\n', (":1: not TOML",)),
    ],
)
def test_a_wrong_head_is_one_line(head, words, tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(f"{head}[axes]\ntissue.wall = [0.1]\n")
    line = told(file)
    assert all(word in line for word in words), line


def test_a_study_that_is_not_there_is_one_line(tmp_path):
    assert "cannot be read" in told(tmp_path / "nothing.toml")


def test_an_observable_of_the_case_is_an_output(tmp_path):
    from ngcell.sweeps.outputs import outputs_of

    study = Study(
        case="shear-empty-3x3",
        set={"observables": [{"kind": "rotation"}]},
        axes={"tissue.wall": [0.1]},
        outputs=["rotation", "energy"],
    )
    written = WrittenStudy(study)
    assert outputs_of(written, Cases(written), ()) == ("rotation", "energy")


def test_a_point_that_was_drawn_and_makes_no_case_is_not_a_wrong_study():
    drawn = {"kind": "random", "low": 0.5, "high": 1.5, "number": 8}
    found = cases({"tissue.wall": drawn})
    refused = {}
    for number in range(8):
        try:
            found.case(number)
        except CaseError as error:
            refused[number] = str(error)
    assert 0 < len(refused) < 8
    found.check(refused)


def test_a_table_comes_before_what_is_set_in_it(tmp_path):
    file = tmp_path / "study.toml"
    tables = "tissue = [{ rows = 2, cols = 2 }, { rows = 1, cols = 2 }]"
    file.write_text(f'case = "shear-empty-3x3"\n[axes]\n"tissue.wall" = [0.1, 0.2]\n{tables}\n')
    cases = Cases(read_study(file))
    found = [(cases.case(number).tissue.wall, cases.case(number).tissue.rows) for number in range(len(cases))]
    assert found == [(0.1, 2), (0.1, 1), (0.2, 2), (0.2, 1)]


@pytest.mark.parametrize(
    "said",
    [
        "set.tissue = { kind = 'polygons', file = 'cells.wkt', wall = 0.1 }\naxes.accuracy = [0.1]",
        "axes.tissue = [{ kind = 'polygons', file = 'cells.wkt', wall = 0.1 }]",
        "set.tissue = { kind = 'polygons', wall = 0.1 }\n"
        "axes.both = { kind = 'zip', values = { tissue.file = ['cells.wkt'], accuracy = [0.1] } }",
    ],
)
def test_files_in_tables_of_a_study_are_beside_it(said, tmp_path, monkeypatch):
    (tmp_path / "cells.wkt").write_text("POLYGON ((0 0, 1 0, 1 1, 0 1, 0 0))\nPOLYGON ((1 0, 2 0, 2 1, 1 1, 1 0))\n")
    file = tmp_path / "study.toml"
    file.write_text(f'case = "shear-empty-3x3"\n{said}\n')
    monkeypatch.chdir(tmp_path.parent)
    assert Cases(read_study(file)).case(0).tissue.file == str(tmp_path / "cells.wkt")


@pytest.mark.parametrize(
    "axes",
    [
        "strategy.kind = ['sddp', 'single-step']\n",
        "both = { kind = 'zip', values = { strategy.kind = ['sddp', 'single-step'], tissue.wall = [0.1, 0.2] } }",
    ],
)
def test_kinds_vary_along_axes_as_other_keys_do(axes, tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(f'case = "shear-empty-3x3"\n[axes]\n{axes}\n')
    cases = Cases(read_study(file))
    assert [cases.case(number).strategy.kind for number in range(len(cases))] == ["sddp", "single-step"]
