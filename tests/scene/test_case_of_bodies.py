"""Cases of user-defined bodies: what they say, what they refuse, and that each mistake is one useful line."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal

import pytest
from click.testing import CliRunner
from pydantic import BaseModel, ConfigDict

from ngcell.cli import ngcell
from ngcell.errors import CaseError
from ngcell.scene import (
    Block,
    BodyCase,
    BodySupport,
    Disc,
    Mortar,
    Penalty,
    Pressure,
    Ring,
    Traction,
    read_case,
    register,
    resolved_toml,
    schema,
)
from ngcell.scene.registry import group

MATERIAL = 'material = { kind = "mooney-rivlin", c1 = 0.5, c2 = 0.5, bulk_modulus = 100.0 }'
GOOD = f"""\
title = "a ring in a bore"
levels = [0.5, 1.0]

[[bodies]]
name = "ring"
kind = "ring"
inner = 0.5
outer = 1.0
part = "upper-right"
{MATERIAL}

[[bodies]]
name = "slab"
kind = "block"
low = [1.0, 0.0]
high = [2.0, 1.0]
walls = ["left"]
[bodies.material]
kind = "mooney-rivlin"
c1 = 1.0
c2 = 0.0
bulk_modulus = 100.0

[[supports]]
boundary = "ring_x0"
components = "x"

[[supports]]
boundary = "slab_right"
translation = [-0.1, 0.0]

[[loads]]
kind = "pressure"
boundary = "ring_inner"
value = 0.1

[contact]
kind = "mortar"

[mesh]
order = 2
refine = [{{ at = [1.0, 0.0], within = 0.2, size = 0.05 }}]

[[expected]]
quantity = "gap"
between = ["ring_outer", "slab_left"]
value = 0.0
tolerance = 1e-3
origin = "they touch"

[[expected]]
quantity = "force_x"
boundary = "slab_right"
level = 0.5
value = -1.0
tolerance = 0.1
origin = "a guess"
"""

# name: (replacement of the text, line, key, what the line must say)
WRONG: dict[str, tuple[tuple[str, str], int, str, str]] = {
    "unknown key": (("inner = 0.5", "innner = 0.5"), 7, "bodies[0].innner = 0.5", "did you mean inner?"),
    "unknown top key": (("[contact]", "[contacts]"), 37, "contacts", "did you mean contact?"),
    "tissue beside bodies": (("[contact]", "[tissue]\nrows = 1\n[contact]"), 37, "tissue", "allowed: title, source"),
    "misspelt bodies": (("bodies", "bodys"), 4, "bodys", "did you mean bodies?"),
    "unknown shape": (('"ring"\ninner', '"rign"\ninner'), 6, 'bodies[0].kind = "rign"', "did you mean ring?"),
    "no shape": (('kind = "block"\n', ""), 12, "bodies[1].kind", 'is missing; allowed: one of "block", "disc", "ring"'),
    "no name": (('name = "slab"\n', ""), 12, "bodies[1].name", "is missing; allowed: text in quotes"),
    "name twice": (('name = "slab"', 'name = "ring"'), 13, 'bodies[1].name = "ring"', "is used twice"),
    "odd name": (('name = "slab"', 'name = "the slab"'), 13, 'bodies[1].name = "the slab"', "letters, digits"),
    "text for a radius": (("outer = 1.0", 'outer = "1"'), 8, 'bodies[0].outer = "1"', "a finite number > 0"),
    "hollow beyond the rim": (("outer = 1.0", "outer = 0.4"), 8, "bodies[0].outer = 0.4", "a radius > inner = 0.5"),
    "block inside out": (("high = [2.0, 1.0]", "high = [0.5, 1.0]"), 16, "bodies[1].high", "of low = [1.0, 0.0]"),
    "short corner": (("low = [1.0, 0.0]", "low = [1.0]"), 15, "bodies[1].low = [1.0]", "[a finite number, a finite"),
    "unknown part": (('"upper-right"', '"top"'), 9, 'bodies[0].part = "top"', 'one of "whole", "right"'),
    "wall that is no side": (('["left"]', '["inner"]'), 17, "bodies[1].walls", "allowed: bottom, top, left, right"),
    "fibres without direction": (
        ("c1 = 1.0", 'fibres = { kind = "quadratic", stiffness = 1.0, angles = [0.0] }\nc1 = 1.0'),
        20,
        "bodies[1].material.fibres.direction",
        "is missing; allowed: a vector in the plane",
    ),
    "material without stiffness": (("c1 = 1.0", "c1 = 0"), 20, "bodies[1].material.c1 = 0", "a finite number > 0"),
    "unknown material": (
        ('[bodies.material]\nkind = "mooney-rivlin"', '[bodies.material]\nkind = "mooney"'),
        19,
        'bodies[1].material.kind = "mooney"',
        "did you mean mooney-rivlin?",
    ),
    "support of nothing": (('"ring_x0"', '"ring_x"'), 25, 'supports[0].boundary = "ring_x"', "did you mean ring_x0?"),
    "support of no component": (
        ('components = "x"', 'components = "z"'),
        26,
        'supports[0].components = "z"',
        'one of "xy", "x", "y"',
    ),
    "load of nothing": (('"ring_inner"', '"bore"'), 34, 'loads[0].boundary = "bore"', "allowed: ring_inner, ring"),
    "load in nothing": (
        ('"pressure"\nboundary = "ring_inner"\nvalue = 0.1', '"body-force"\nbody = "rng"\nvector = [0, 1]'),
        34,
        'loads[0].body = "rng"',
        "is no body; did you mean ring?; allowed: ring, slab",
    ),
    "force of three components": (
        ('"pressure"\nboundary = "ring_inner"\nvalue = 0.1', '"body-force"\nbody = "ring"\nvector = [0, 1, 0]'),
        32,
        "loads[0]: force on ring: vector has 3 entries",
        "allowed: 2",
    ),
    "force without direction": (
        ('"pressure"\nboundary = "ring_inner"\nvalue = 0.1', '"body-force"\nbody = "ring"\nvector = [0, "1"]'),
        35,
        "loads[0].vector",
        "allowed: two finite numbers",
    ),
    "unknown load": (('"pressure"', '"presure"'), 33, 'loads[0].kind = "presure"', "did you mean pressure?"),
    "pressure not a number": (("value = 0.1", "value = nan"), 35, "loads[0].value = NaN", "a finite number"),
    "key of another load": (("value = 0.1", "value = 0.1\nvector = [1, 0]"), 36, "loads[0].vector", "is unknown"),
    "unknown contact": (('"mortar"', '"motar"'), 38, 'contact.kind = "motar"', "did you mean mortar?"),
    "layers of a tissue": (("order = 2", "order = 2\nlayers = 2"), 42, "mesh.layers = 2", "allowed: order, size"),
    "order too high": (("order = 2", "order = 7"), 41, "mesh.order = 7", "a whole number from 1 to 6"),
    "refined to dust": (("size = 0.05", "size = 1e-9"), 42, "mesh.refine[0].size = 1e-09", "within / 1000"),
    "level twice": (("[0.5, 1.0]", "[1.0, 1.0]"), 2, "levels = [1.0, 1.0]", "each other than the one before"),
    "no steps": (("levels =", "steps = 0\nlevels ="), 2, "steps = 0", "a whole number >= 1"),
    "unmeasured quantity": (('"gap"', '"stress"'), 45, 'expected[0].quantity = "stress"', 'one of "mean_radius"'),
    "quantity between two on one": (
        ('between = ["ring_outer", "slab_left"]', 'boundary = "ring_outer"'),
        45,
        'expected[0].quantity = "gap"',
        "is measured between two boundaries",
    ),
    "between a cut": (('["ring_outer"', '["ring_x0"'), 46, 'expected[0].between[0] = "ring_x0"', "allowed: ring_inner"),
    "force where nothing holds": (
        ('"force_x"\nboundary = "slab_right"', '"force_x"\nboundary = "slab_left"'),
        53,
        'expected[1].boundary = "slab_left"',
        "allowed: ring_x0, slab_right",
    ),
    "radius of a straight side": (
        ('"force_x"', '"mean_radius"'),
        53,
        'expected[1].boundary = "slab_right"',
        "allowed: ring_inner, ring_outer",
    ),
    "unreported level": (("level = 0.5", "level = 0.7"), 54, "expected[1].level = 0.7", "one of the levels (0.5, 1)"),
    "no tolerance": (("tolerance = 1e-3", "tolerance = 0"), 48, "expected[0].tolerance = 0", "a finite number > 0"),
}


def write(folder: Path, old: str = "", new: str = "") -> Path:
    assert old in GOOD
    file = folder / "bent.toml"
    file.write_text(GOOD.replace(old, new, -1 if old == "bodies" else 1) if old else GOOD)
    return file


@pytest.mark.parametrize(("replacement", "line", "key", "says"), WRONG.values(), ids=WRONG)
def test_wrong_case_is_one_useful_line(
    tmp_path: Path, replacement: tuple[str, str], line: int, key: str, says: str
) -> None:
    file = write(tmp_path, *replacement)
    answer = CliRunner().invoke(ngcell, ["check", str(file)])
    assert answer.exit_code == 3
    assert answer.stdout == ""
    assert len(answer.stderr.splitlines()) == 1
    assert answer.stderr.startswith(f"{file}:{line}: ")
    assert key in answer.stderr
    assert says in answer.stderr


def test_case_says_bodies_supports_loads_and_numbers(tmp_path: Path) -> None:
    case = read_case(write(tmp_path))
    assert isinstance(case, BodyCase)
    ring, slab = case.bodies
    assert isinstance(ring, Ring) and isinstance(slab, Block)
    assert ring.boundaries == ("ring_inner", "ring_outer", "ring_x0", "ring_y0")
    assert ring.wall_boundaries == ("ring_inner", "ring_outer")
    assert slab.wall_boundaries == ("slab_left",)
    assert [support.resolved for support in case.supports] == [
        BodySupport("ring_x0", components=(True, False)),
        BodySupport("slab_right", translation=(-0.1, 0.0)),
    ]
    assert list(case.loads) == [Pressure(boundary="ring_inner", value=0.1)]
    assert case.contact == Mortar()
    assert case.level_factors == (0.5, 1.0)
    assert case.smallest_step_count == 2
    assert [entry.place for entry in case.expected] == ["ring_outer and slab_left", "slab_right"]


def test_resolved_case_reads_back_equal(tmp_path: Path) -> None:
    case = read_case(write(tmp_path))
    file = tmp_path / "resolved.toml"
    file.write_text(resolved_toml(case))
    assert read_case(file) == case


def test_overrides_reach_into_bodies(tmp_path: Path) -> None:
    overrides = ["bodies.0.outer=0.9", "bodies.1.material.c2=0.5", "contact.kind=penalty", "steps=4", "levels=3"]
    overrides += ['loads.0={ kind = "traction", boundary = "ring_inner", vector = [0, 1] }', "expected=[]"]
    case = read_case(write(tmp_path), overrides)
    assert case.bodies[0].outer == 0.9
    assert case.bodies[1].material.c2 == 0.5
    assert case.contact == Penalty()
    assert case.smallest_step_count == 4
    assert case.loads[0] == Traction(boundary="ring_inner", vector=(0.0, 1.0))


def test_wrong_override_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"bent\.toml: --set: bodies\[0\]\.part = \"top\" is not possible"):
        read_case(write(tmp_path), ["bodies.0.part=top"])


def test_case_without_walls_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"bodies\[0\]\.walls = \[\]: no side of any body may touch"):
        read_case(write(tmp_path), ["bodies.0.walls=[]", "bodies.1.walls=[]", "expected=[]"])


def test_case_without_bodies_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "none.toml"
    file.write_text("bodies = []\n")
    with pytest.raises(CaseError, match=r"none\.toml:1: bodies = \[\] is not possible; allowed: a list"):
        read_case(file)


@pytest.mark.parametrize("part", ["whole", "right", "lower", "upper-left"])
def test_a_cut_is_a_side_but_no_wall(part: str) -> None:
    case = read_case("press-fit")
    disc = Disc(name="disc", material=case.bodies[0].material, radius=1, part=part)
    cuts = ["x0"] * ("right" in part or "left" in part) + ["y0"] * ("upper" in part or "lower" in part)
    assert list(disc.sides) == ["outer", *cuts]
    assert disc.wall_boundaries == ("disc_outer",)


def test_schema_offers_both_kinds_of_case() -> None:
    offered = schema()
    assert {option["$ref"].rpartition("/")[2] for option in offered["anyOf"]} == {"Case", "BodyCase"}
    assert offered["$defs"]["BodyCase"]["required"] == ["bodies"]
    assert offered["$defs"]["BodyCase"]["additionalProperties"] is False


class Weight(BaseModel):
    """A load of a script: a force downwards in a whole body."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    boundary: ClassVar[None] = None
    pressure: ClassVar[float] = 0.0

    kind: Literal["weight"] = "weight"
    body: str
    density: float

    def check(self, dimension: int) -> None:
        assert dimension == 2


def test_a_case_may_name_a_load_that_a_script_registered(tmp_path: Path) -> None:
    register("body-load", Weight)
    try:
        load = 'kind = "weight"\nbody = "slab"\ndensity = 2.0'
        file = write(tmp_path, 'kind = "pressure"\nboundary = "ring_inner"\nvalue = 0.1', load)
        case = read_case(file)
        assert list(case.loads) == [Weight(body="slab", density=2.0)]
        file.write_text(resolved_toml(case))
        assert read_case(file) == case
    finally:
        del group("body-load").own["weight"]
