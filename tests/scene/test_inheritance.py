"""Cases that extend others: what is taken over, what takes its place, and how mistakes are told."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner

from ngcell.cli import ngcell
from ngcell.errors import CaseError
from ngcell.scene import MooneyRivlin, case_title, read_case, resolved_toml, shipped_cases
from tests.scene.conftest import GOOD


@pytest.fixture
def family(tmp_path: Path):
    """Write files by name; the first is returned."""

    def write(**texts: str) -> Path:
        files = [tmp_path / f"{name}.toml" for name in texts]
        for file, text in zip(files, texts.values(), strict=True):
            file.write_text(text)
        return files[0]

    return write


def told(file: Path) -> str:
    with pytest.raises(CaseError) as caught:
        read_case(file)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_the_file_wins_and_the_rest_is_taken_over(family):
    heir = family(heir='extends = "good.toml"\n[tissue]\nwall = 0.2\n[mesh]\norder = 2', good=GOOD)
    case, inherited = read_case(heir), read_case(heir.with_name("good.toml"))
    assert (case.tissue.wall, case.mesh.order) == (0.2, 2)
    assert case.tissue.model_copy(update={"wall": 0.1}) == inherited.tissue
    assert (case.material, case.load) == (inherited.material, inherited.load)


def test_an_inherited_title_tells_which_file_has_changed_the_scene(family):
    heir = family(heir='extends = "good.toml"\n[tissue]\nwall = 0.2', good=GOOD)
    assert read_case(heir).title == f"{read_case(heir.with_name('good.toml')).title}, changed by heir.toml"
    sourced = family(known='extends = "shear-empty"\n[tissue]\nwall = 0.2')
    assert read_case(sourced).source.startswith("Changed by known.toml; of shear-empty: Sheared tissue")
    named = family(named='extends = "good.toml"\ntitle = "Thick walls"\n[tissue]\nwall = 0.2')
    assert read_case(named).title == "Thick walls"


def test_a_table_of_another_kind_takes_the_place_of_the_inherited_one(family):
    heir = family(heir='extends = "good.toml"\n[load]\nkind = "frame"\nshear = 0.1', good=GOOD)
    assert read_case(heir).load.levels == 10
    # Its default is the kind of a table that names none.
    drawn = family(drawn='extends = "good.toml"\n[tissue]\nkind = "voronoi"\ncells = 4\nextent = [2, 2]\nwall = 0.1')
    assert read_case(drawn).tissue.cells == 4
    same = family(same='extends = "good.toml"\n[load]\nkind = "plates"\nlevels = 3')
    assert read_case(same).load.displacement == (0.1, 0.0)


def test_a_shipped_name_and_a_chain_of_files(family):
    file = family(
        grandchild='extends = "child.toml"\ntitle = "last"\nlumen.pressure = 0.3',
        child='extends = "shear-pressurised"\ntissue.rows = 2',
    )
    case = read_case(file)
    assert (case.title, case.tissue.rows, case.tissue.cols, case.lumen.pressure) == ("last", 2, 7, 0.3)
    assert case_title(file) == "last"


def test_bodies_merge_by_name_and_supports_by_boundary(family):
    file = family(heir='extends = "press-fit"\nbodies = [{ name = "hub", material = { c1 = 2.0 } }]')
    case, inherited = read_case(file), read_case("press-fit")
    assert case.bodies[0] == inherited.bodies[0]
    assert case.bodies[1].material == MooneyRivlin(c1=2.0, c2=0.5, bulk_modulus=1000.0)
    assert case.supports == inherited.supports


def test_expected_numbers_belong_to_one_scene(family):
    assert read_case("press-fit").expected
    assert read_case(family(heir='extends = "press-fit"')).expected == ()


def test_an_override_that_makes_another_scene_drops_the_expected_numbers():
    assert read_case("shear-empty-3x3").expected
    assert read_case("shear-empty-3x3", ["mesh.order=2"]).expected
    assert read_case("shear-empty-3x3", ["accuracy=inf"]).expected
    assert read_case("shear-empty-3x3", ["tissue.wall=0.2"]).expected == ()
    mine = '[{level=1.0,quantity="energy",value=1.0,tolerance=0.1,origin="guess"}]'
    assert len(read_case("shear-empty-3x3", ["tissue.wall=0.2", f"expected={mine}"]).expected) == 1


@pytest.mark.parametrize("name", sorted(shipped_cases()))
def test_a_resolved_case_says_everything_itself(name):
    text = resolved_toml(read_case(name))
    assert "extends" not in tomllib.loads(text)


def test_a_mistake_is_told_where_its_key_stands(family):
    heir = family(heir='extends = "good.toml"\n\n[tissue]\nwall = 2.0', good=GOOD)
    assert told(heir).startswith(f"{heir}:4: tissue.wall = 2.0: a wall this thick closes the lumen")
    inherited = family(heir='extends = "wrong.toml"\n', wrong=GOOD.replace("rows = 1", "rows = 0"))
    assert told(inherited).startswith(f"{inherited.with_name('wrong.toml')}:4: tissue.rows = 0 is not possible")
    body = family(heir='extends = "press-fit"\n[[bodies]]\nname = "hub"\ninner = -1.0\n')
    assert told(body).startswith(f"{body}:4: bodies[1].inner = -1.0 is not possible")
    unknown = family(heir='extends = "good.toml"\n[material]\nc3 = 1.0\n')
    assert told(unknown).startswith(f"{unknown}:3: material.c3 = 1.0 is unknown; allowed: kind, c1, c2")


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('extends = "shear-emtpy"', r"no such case; did you mean shear-empty\?; allowed: the path of a case file"),
        ("extends = 3", "extends = 3: no such case; allowed: the path of a case file from this one, or one of"),
        ('extends = "heir.toml"', "leads back to .*heir.toml; allowed: a case that does not extend this one"),
        ('extends = "other.toml"', "other.toml:1: extends = .heir.toml. leads back to .*heir.toml"),
        ('extends = "broken.toml"', "broken.toml:1: not TOML"),
    ],
)
def test_what_cannot_be_extended(family, line, says):
    heir = family(heir=line, other='extends = "heir.toml"', broken="rows 1")
    with pytest.raises(CaseError, match=says):
        read_case(heir)


def test_cases_are_listed_by_their_titles():
    answer = CliRunner().invoke(ngcell, ["cases"])
    assert answer.exit_code == 0
    assert "press-fit-tight          Press-fit: a ring sits in a bore that is a fifth too narrow" in answer.stdout
    assert len(answer.stdout.splitlines()) == len(shipped_cases())


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('# write """ around long text\nextends = "shear-empty-3x3"\naccuracy = -1\n', 3),
        ("title = 'it holds \"\"\" and # so'\nextends = 'shear-empty-3x3'\naccuracy = -1 # '\'\'\n", 3),
        ('title = """\naccuracy = 3 \\"""\n"""\nextends = "shear-empty-3x3"\naccuracy = -1\n', 5),
        ("extends = 'shear-empty-3x3'\ntitle = '''a\n#'''\naccuracy = -1\n", 4),
    ],
)
def test_quotes_in_comments_and_texts_move_no_line(text, line, tmp_path):
    tomllib.loads(text)
    file = tmp_path / "case.toml"
    file.write_text(text)
    with pytest.raises(CaseError, match=rf":{line}: accuracy = -1"):
        read_case(file)


@pytest.mark.parametrize("text", ['extends.case = "shear-empty-3x3"\n', '"\\u0065xtends" = "no such case"\n'])
def test_extends_in_other_spellings_is_told(text, tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(text)
    with pytest.raises(CaseError, match=r"case\.toml.*extends = .*: no such case"):
        read_case(file)


def test_numbers_of_thousands_of_digits_are_told(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(f"extends = 'shear-empty-3x3'\naccuracy = {'9' * 5000}\n")
    with pytest.raises(CaseError, match="more digits than can be read"):
        read_case(file)
    for override in (f"tissue.rows={'9' * 5000}", f"expected.{'9' * 5000}.level=1"):
        with pytest.raises(CaseError):
            read_case("shear-empty-3x3", [override])
