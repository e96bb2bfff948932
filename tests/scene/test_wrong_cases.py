"""A wrong case is one line that names file, line, key, value and what is allowed; the command answers 3."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner

from ngcell.cli import ngcell
from ngcell.errors import CaseError
from ngcell.scene import read_case

LOAD = 'kind = "plates"\ndisplacement = [0.1, 0.0]'
EXPECTED = '[[expected]]\nlevel = 1.0\nquantity = "energy"\nvalue = 1.0\ntolerance = 0.01\norigin = "a second way"\n'

FIBRES = '[material.fibres]\nkind = "quadratic"\nstiffness = 1.0\nangles = [0.0]'


def expected(old: str, new: str) -> tuple[str, str]:
    """Append an expected number with one of its lines replaced."""
    assert old in EXPECTED
    return "levels = 2\n", "levels = 2\n" + EXPECTED.replace(old, new)


def frame(lines: str) -> tuple[str, str]:
    return LOAD, f'kind = "frame"\n{lines}'


# name: (replacement of the text, line, key, what the line must say)
WRONG: dict[str, tuple[tuple[str, str], int, str, str]] = {
    "unknown key": (("side =", "sidee ="), 6, "tissue.sidee = 1.0", "did you mean side?"),
    "misspelt required key": (("wall =", "wal ="), 7, "tissue.wal = 0.1", "did you mean wall?"),
    "unknown table": (("[material]", "[materials]"), 9, "materials", "did you mean material?"),
    "unknown top key": (("title", "heading"), 1, 'heading = "two cells"', "allowed: title, source, tissue"),
    "missing key": (("rows = 1\n", ""), 3, "tissue.rows", "is missing; allowed: a whole number >= 1"),
    "zero rows": (("rows = 1", "rows = 0"), 4, "tissue.rows = 0", "allowed: a whole number >= 1"),
    "broken rows": (("rows = 1", "rows = 1.5"), 4, "tissue.rows = 1.5", "allowed: a whole number >= 1"),
    "truth for a count": (("rows = 1", "rows = true"), 4, "tissue.rows = true", "allowed: a whole number"),
    "text for a count": (("cols = 2", 'cols = "2"'), 5, 'tissue.cols = "2"', "allowed: a whole number >= 1"),
    "too many cells": (("cols = 2", "cols = 10001"), 5, "tissue.cols = 10001", "rows * cols <= 10000"),
    "a row too many": (
        ("rows = 1\ncols = 2\nside = 1.0", 'kind = "brick"\nrows = 1000000\ncols = 1000000\naspect = 2.0'),
        6,
        "tissue.cols = 1000000",
        "rows * cols <= 10000",
    ),
    "far too many digits": (("side = 1.0", "side = 1" + 400 * "0"), 6, "tissue.side", "more than 308 digits; allowed"),
    "digits in a list": (
        ("displacement = [0.1, 0.0]", "displacement = [0.1, 1" + 400 * "0" + "]"),
        17,
        "load.displacement.1",
        "more than 308 digits; allowed: fewer",
    ),
    "negative side": (("side = 1.0", "side = -1.0"), 6, "tissue.side = -1.0", "allowed: a finite number > 0"),
    "text for a number": (("side = 1.0", 'side = "one"'), 6, 'tissue.side = "one"', "a finite number > 0"),
    "infinite side": (("side = 1.0", "side = inf"), 6, "tissue.side = Infinity", "a finite number > 0"),
    "wall closes the lumen": (("wall = 0.1", "wall = 0.9"), 7, "tissue.wall = 0.9", "0 < wall < 0.866025"),
    "flat prisms": (("wall = 0.1", "wall = 0.1\nheight = 0.0"), 8, "tissue.height = 0.0", "a finite number > 0"),
    "end walls that meet": (
        ("wall = 0.1", "wall = 0.1\nheight = 1.0\nend_wall = 0.5"),
        9,
        "tissue.end_wall = 0.5",
        "0 < end_wall < 0.5, half of the height",
    ),
    "end walls without a height": (
        ("wall = 0.1", "wall = 0.1\nend_wall = 0.5"),
        8,
        "tissue.end_wall = 0.5",
        "height / 2, with a height",
    ),
    "pressed ends without a pressure": (
        ("levels = 2\n", 'levels = 2\nends = "pressed"\n'),
        19,
        'load.ends = "pressed"',
        "says not how much; allowed: with an end_pressure",
    ),
    "a pressure on free ends": (
        ("levels = 2\n", "levels = 2\nend_pressure = 0.1\n"),
        19,
        "load.end_pressure = 0.1",
        'allowed: with ends = "pressed"',
    ),
    "pressed ends without prisms": (
        ("levels = 2\n", 'levels = 2\nends = "pressed"\nend_pressure = 0.1\n'),
        19,
        'load.ends = "pressed"',
        "is for prisms; allowed: only beside tissue.height",
    ),
    "a pressure in hollow layers": (
        ("wall = 0.1", 'wall = 0.1\nheight = 1.0\nlayers = 2\n\n[lumen]\nkind = "pressure"\npressure = 0.1'),
        12,
        'lumen.kind = "pressure"',
        "escapes between layers of hollow prisms; allowed: closed ones, with a tissue.end_wall",
    ),
    "fluids in hollow prisms": (
        ("wall = 0.1", 'wall = 0.1\nheight = 1.0\n\n[lumen]\nkind = "fluid"'),
        11,
        'lumen.kind = "fluid"',
        "flows out of hollow prisms; allowed: closed ones, with a tissue.end_wall",
    ),
    "a pressure in prisms whose ends are free": (
        ("wall = 0.1", 'wall = 0.1\nheight = 1.0\n\n[lumen]\nkind = "pressure"\npressure = 0.1'),
        20,
        "load.ends",
        'leaves rims free beside a lumen.pressure; allowed: "held", or a tissue.end_wall',
    ),
    "layers without a height": (
        ("wall = 0.1", "wall = 0.1\nlayers = 2"),
        8,
        "tissue.layers = 2",
        "are layers of prisms; allowed: 1, or more with a height",
    ),
    "too many layers": (
        ("wall = 0.1", "wall = 0.1\nheight = 1.0\nlayers = 6000"),
        9,
        "tissue.layers = 6000",
        "with 2 cells each these are 12000; allowed: rows * cols * layers <= 10000",
    ),
    "pressures of one layer of two": (
        (
            "wall = 0.1",
            "wall = 0.1\nheight = 1.0\nend_wall = 0.1\nlayers = 2\n\n"
            '[lumen]\nkind = "pressure"\npressure = [[0.1, 0.1]]',
        ),
        14,
        "lumen.pressure",
        "allowed: one pressure, or 2 rows of 2",
    ),
    "ends of planar cells twisted": (
        (LOAD, 'kind = "ends"\ntwist = 10.0'),
        16,
        'load.kind = "ends"',
        "is for prisms; allowed: only beside tissue.height",
    ),
    "ends without prisms": (
        ("levels = 2\n", 'levels = 2\nends = "held"\n'),
        19,
        'load.ends = "held"',
        "is for prisms; allowed: only beside tissue.height",
    ),
    "cells filled with nothing": (
        ("levels = 2\n", 'levels = 2\n\n[lumen]\nkind = "fluid"\nfill = 0.0\n'),
        22,
        "lumen.fill = 0.0",
        "a finite number > 0",
    ),
    "fibres with a direction of their own in a tissue": (
        ("levels = 2\n", f"levels = 2\n\n{FIBRES}\ndirection = [1.0, 0.0]\n"),
        24,
        "material.fibres.direction",
        "is that of the wall in a tissue",
    ),
    "fibres beyond the axis": (
        ("levels = 2\n", f"levels = 2\n\n{FIBRES}\n".replace("[0.0]", "[95.0]")),
        23,
        "material.fibres.angles[0] = 95.0",
        "a finite number from -90 to 90",
    ),
    "three families": (
        ("levels = 2\n", f"levels = 2\n\n{FIBRES}\n".replace("[0.0]", "[0.0, 1.0, 2.0]")),
        23,
        "material.fibres.angles",
        "allowed: one angle, or two",
    ),
    "unknown filling": (
        ("levels = 2\n", 'levels = 2\n\n[lumen]\nkind = "fluids"\n'),
        21,
        'lumen.kind = "fluids"',
        '"fluid", "inclusion", "pressure"',
    ),
    "wall of nothing": (("wall = 0.1", "wall = 0.0"), 7, "tissue.wall = 0.0", "a finite number > 0"),
    "wall not a number": (("wall = 0.1", "wall = nan"), 7, "tissue.wall = NaN", "a finite number > 0"),
    "date for a number": (("wall = 0.1", "wall = 2020-01-01"), 7, "tissue.wall", "a finite number > 0"),
    "corner beyond the apothem": (
        ("wall = 0.1", "wall = 0.2\ncorner_radius = 0.9"),
        8,
        "tissue.corner_radius = 0.9",
        "0 <= corner_radius < 0.866025",
    ),
    "corner through the wall": (
        ("wall = 0.1", "wall = 0.1\ncorner_radius = 0.8"),
        8,
        "tissue.corner_radius = 0.8",
        "0 <= corner_radius < 0.74641",
    ),
    "unknown orientation": (
        ("wall = 0.1", 'wall = 0.1\norientation = "round"'),
        8,
        'tissue.orientation = "round"',
        'one of "pointy", "flat"',
    ),
    "unknown material": (
        ("mooney-rivlin", "mooney"),
        10,
        'material.kind = "mooney"',
        'did you mean mooney-rivlin?; allowed: "mooney-rivlin"',
    ),
    "missing kind": (
        ('kind = "mooney-rivlin"\n', ""),
        9,
        "material.kind",
        'is missing; allowed: "mooney-rivlin"',
    ),
    "material without stiffness": (("c1 = 1.0", "c1 = 0"), 11, "material.c1 = 0", "a finite number > 0"),
    "negative second constant": (("c2 = 0.5", "c2 = -0.5"), 12, "material.c2 = -0.5", "a finite number >= 0"),
    "number beyond range": (
        ("bulk_modulus = 100.0", "bulk_modulus = 1e999"),
        13,
        "material.bulk_modulus = Infinity",
        "a finite number > 0",
    ),
    "unknown load": (("plates", "plate"), 16, 'load.kind = "plate"', "did you mean plates?"),
    "key of another load": (
        ("displacement = [0.1, 0.0]", "displacement = [0.1, 0.0]\nshear = 0.1"),
        18,
        "load.shear = 0.1",
        "allowed: kind, ends, end_pressure, levels, sides, displacement, stretch",
    ),
    "two motions": (
        ("displacement = [0.1, 0.0]", "displacement = [0.1, 0.0]\nstretch = 1.1"),
        15,
        "load",
        "both displacement and stretch are given; allowed: exactly one of displacement, stretch",
    ),
    "no motion": (
        ("displacement = [0.1, 0.0]\n", ""),
        15,
        "load",
        "nothing says how far to go; allowed: exactly one of displacement, stretch",
    ),
    "short vector": (("[0.1, 0.0]", "[0.1]"), 17, "load.displacement = [0.1]", "[a finite number, a finite"),
    "long vector": (("[0.1, 0.0]", "[0.1, 0, 0]"), 17, "load.displacement = [0.1, 0, 0]", "[a finite number"),
    "text in a vector": (("[0.1, 0.0]", '[0.1, "0"]'), 17, 'load.displacement[1] = "0"', "a finite number"),
    "no levels": (("levels = 2", "levels = 0"), 18, "load.levels = 0", "from 1 to 1000"),
    "empty list of levels": (("levels = 2", "levels = []"), 18, "load.levels = []", "each other than the one before"),
    "level twice": (("levels = 2", "levels = [0.5, 0.5]"), 18, "load.levels = [0.5, 0.5]", "each other than"),
    "level zero twice": (("levels = 2", "levels = [0, 0, 0.5]"), 18, "load.levels = [0, 0, 0.5]", "each other than"),
    "negative level": (("levels = 2", "levels = [0.5, -0.5]"), 18, "load.levels = [0.5, -0.5]", "in [0, 1]"),
    "level beyond the load": (("levels = 2", "levels = [0.5, 1.5]"), 18, "load.levels", "in [0, 1]"),
    "level not a number": (("levels = 2", "levels = [0.5, nan]"), 18, "load.levels = [0.5, NaN]", "[0, 1]"),
    "no deformation": (frame(""), 15, "load", "exactly one of deformation_gradient, stretch, shear"),
    "inside out": (
        frame("deformation_gradient = [[1, 0], [0, -1]]"),
        17,
        "load.deformation_gradient = [[1, 0], [0, -1]]",
        "determinant falls to -1 on the way; allowed: a determinant > 0",
    ),
    "inside out on the way": (
        frame("deformation_gradient = [[-1, 0], [0, -1]]"),
        17,
        "load.deformation_gradient = [[-1, 0], [0, -1]]",
        "determinant falls to 0 on the way",
    ),
    "crushed": (frame("stretch = [1, 0]"), 17, "load.stretch[1] = 0", "allowed: a finite number > 0"),
    "number for a table": (('title = "two cells"', "strategy = 3"), 1, "strategy = 3", "a table [strategy]"),
    "unknown strategy": (
        ("[load]", '[strategy]\nkind = "sdpp"\n[load]'),
        16,
        'strategy.kind = "sdpp"',
        'did you mean sddp?; allowed: one of "load-stepping", "sddp", "single-step"',
    ),
    "no steps": (
        ("[load]", "[strategy]\nsteps = 0\n[load]"),
        16,
        "strategy.steps = 0",
        "allowed: a whole number >= 1",
    ),
    "contact without stiffness": (
        ("[load]", "[contact]\nstiffness = 0\n[load]"),
        16,
        "contact.stiffness = 0",
        "allowed: a finite number > 0",
    ),
    "no accuracy": (
        ('title = "two cells"', "accuracy = 0"),
        1,
        "accuracy = 0",
        "allowed: a finite number > 0, or inf",
    ),
    "order too high": (
        ("[load]", "[mesh]\norder = 7\n[load]"),
        16,
        "mesh.order = 7",
        "allowed: a whole number from 1 to 6",
    ),
    "unmeasured quantity": (
        expected('"energy"', '"gap"'),
        21,
        'expected[0].quantity = "gap"',
        'one of "plate_displacement", "largest_gap"',
    ),
    "unreported level": (
        expected("level = 1.0", "level = 0.7"),
        20,
        "expected[0].level = 0.7",
        "is not reported; allowed: a level of the load (0.5, 1)",
    ),
    "expected out of nowhere": (
        expected('"a second way"', '""'),
        24,
        'expected[0].origin = ""',
        "allowed: text in quotes, not empty",
    ),
    "a plate through side walls": (
        ("levels = 2\n", 'levels = 2\nsides = "confined"\n'),
        17,
        "load.displacement[0] = 0.1",
        "moves the plate through the side walls; allowed: 0 along x, or free sides",
    ),
    "a disc without a radius": (
        (LOAD, 'kind = "indenter"\nshape = "disc"\ndepth = 0.1'),
        15,
        "load.radius",
        "is missing; allowed: radius",
    ),
    "a flat punch with an angle": (
        (LOAD, 'kind = "indenter"\nshape = "flat"\ndepth = 0.1\nwidth = 1.0\nangle = 60.0'),
        20,
        "load.angle = 60.0",
        "is no size of a flat; allowed: width",
    ),
    "an indenter that moves upwards": (
        (LOAD, 'kind = "indenter"\nshape = "flat"\ndepth = -0.1\nwidth = 1.0'),
        18,
        "load.depth = -0.1",
        "allowed: a finite number > 0",
    ),
    "no equals sign": (("rows = 1", "rows 1"), 4, "rows 1", "allowed: key = value"),
    "open string": (('"two cells"', '"two cells'), 1, "title", "not TOML"),
    "key given twice": (("cols = 2", "rows = 2"), 5, "rows = 2", "not TOML"),
}


@pytest.mark.parametrize(("replacement", "line", "key", "says"), WRONG.values(), ids=WRONG)
@pytest.mark.parametrize("verb", ["solve", "check"])
def test_wrong_case_is_one_useful_line(
    write_case: Callable[..., Path],
    verb: str,
    replacement: tuple[str, str],
    line: int,
    key: str,
    says: str,
) -> None:
    file = write_case(replacement)
    answer = CliRunner().invoke(ngcell, [verb, str(file)])
    assert answer.exit_code == 3
    assert answer.stdout == ""
    assert len(answer.stderr.splitlines()) == 1
    assert answer.stderr.startswith(f"{file}:{line}: ")
    assert key in answer.stderr
    assert says in answer.stderr


@pytest.mark.parametrize("lumen", ['kind = "fluid"', 'kind = "pressure"\npressure = 0.1\nramp = "first"'])
def test_pressed_ends_grow_with_all_else_that_presses(write_case: Callable[..., Path], lumen: str) -> None:
    closed = "wall = 0.1\nheight = 1.0\nend_wall = 0.1"
    pressed = f'levels = 2\nends = "pressed"\nend_pressure = 0.1\n\n[lumen]\n{lumen}\n'
    with pytest.raises(CaseError) as caught:
        read_case(write_case(("wall = 0.1", closed), ("levels = 2\n", pressed)))
    assert "load.end_pressure = 0.1: acts beside" in str(caught.value)
    assert 'allowed: with empty lumens, inclusions or a lumen.pressure of ramp = "with-load"' in str(caught.value)


def test_several_mistakes_are_a_line_each_misspelt_keys_first(write_case: Callable[..., Path]) -> None:
    file = write_case(("rows = 1", "rows = 0"), ("c1 = 1.0", "c_1 = 1.0"), ("levels = 2", "levels = 0"))
    with pytest.raises(CaseError) as caught:
        read_case(file)
    first, second, third = str(caught.value).splitlines()
    assert "material.c_1 = 1.0 is unknown; did you mean c1?" in first
    assert "tissue.rows = 0" in second
    assert "load.levels = 0" in third


def test_empty_file_names_the_tables_that_are_needed(tmp_path: Path) -> None:
    file = tmp_path / "empty.toml"
    file.touch()
    with pytest.raises(CaseError) as caught:
        read_case(file)
    lines = str(caught.value).splitlines()
    assert [line.split(" is missing")[0] for line in lines] == [
        f"{file}: {table}" for table in ("tissue", "material", "load")
    ]
    assert "allowed: a table [tissue] with kind, rows, cols" in lines[0]


def test_file_that_is_no_text(tmp_path: Path) -> None:
    file = tmp_path / "picture.toml"
    file.write_bytes(b"\x89PNG\r\n")
    with pytest.raises(CaseError, match=r"picture\.toml: byte 0 is not UTF-8; allowed: a TOML file in UTF-8"):
        read_case(file)


def test_missing_file_names_the_nearest_shipped_case() -> None:
    with pytest.raises(CaseError, match="did you mean shear-empty.*; allowed: the path of a TOML file, or"):
        read_case("shear-emtpy")


def test_long_values_and_line_breaks_stay_on_one_line(write_case: Callable[..., Path]) -> None:
    file = write_case(("rows = 1", 'rows = """a\n' + "b" * 300 + '"""'))
    with pytest.raises(CaseError) as caught:
        read_case(file)
    assert len(str(caught.value).splitlines()) == 1
    assert len(str(caught.value)) < len(str(file)) + 150


def test_keys_inside_multiline_text_are_not_taken_for_keys(write_case: Callable[..., Path]) -> None:
    source = 'source = """\n[tissue]\nwall = 1\n"""\n\n[tissue]'
    file = write_case(("[tissue]", source), ("wall = 0.1", "wall = 2"))
    with pytest.raises(CaseError, match=r"bent\.toml:12: tissue\.wall = 2"):
        read_case(file)
