"""Scenes of own bodies: what they may say, and how they refuse the rest."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import pytest

from ngcell import Case, Polygons, Study
from ngcell.errors import CaseError
from ngcell.scene import Body, BodyForce, BodyScene, BodySupport, MooneyRivlin, Pressure, Traction

RUBBER = MooneyRivlin(c1=1.0, c2=0.0, bulk_modulus=100.0)
BODY = Body(object(), RUBBER, "block")


def test_levels_and_steps():
    assert BodyScene([BODY], levels=4).level_factors == (0.25, 0.5, 0.75, 1.0)
    chosen = BodyScene((BODY,), levels=(0.2, 1), steps=7)
    assert chosen.level_factors == (0.2, 1.0)
    assert (chosen.smallest_step_count, BodyScene([BODY]).smallest_step_count) == (7, 10)


def test_moved_boundaries_are_those_that_a_support_moves():
    scene = BodyScene([BODY], [BodySupport("floor"), BodySupport("top", translation=(0, 0.1)), BodySupport("top")])
    assert scene.moved_boundaries == ("top",)
    with pytest.raises(FrozenInstanceError):
        scene.order = 3


def test_loads_are_kept_in_order_and_there_are_none_by_default():
    assert BodyScene([BODY]).loads == ()
    loads = [Pressure(boundary="bore", value=1), Traction(boundary="rim", vector=(0, -0.5))]
    assert BodyScene([BODY], loads=loads).loads == tuple(loads)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Body(object(), RUBBER, "my block"), "body name is 'my block'; allowed: letters"),
        (lambda: Body(object(), "rubber", "block"), "body block: material is 'rubber'; allowed: a MooneyRivlin"),
        (lambda: BodySupport("top|floor"), r"boundary of a support is 'top\|floor'; allowed: letters"),
        (lambda: BodySupport("top", gradient=(1, 2)), "support top: gradient is 1; allowed: two rows"),
        (lambda: BodySupport("top", gradient=((1, 2), (3, "4"))), r"support top: gradient is \(3, '4'\)"),
        (
            lambda: BodySupport("top", translation=(0, float("nan"))),
            "support top: translation is .*; allowed: two finite",
        ),
        (lambda: BodySupport("top", translation=(0, 1, 2, 3)), r"support top: translation is \(0, 1, 2, 3\)"),
        (lambda: BodySupport("top", gradient=((1, 2), (1, 2, 3))), "support top: gradient is .*three of three"),
        (lambda: BodySupport("top", components=(False, False)), "support top: components is .*at least one"),
        (lambda: BodySupport("top", components=(1, 0)), "support top: components is"),
        (lambda: BodyScene([]), "bodies is empty"),
        (lambda: BodyScene(BODY), "bodies is .*; allowed: a list of Body"),
        (lambda: BodyScene([BODY], [BODY]), "supports is .*; allowed: a list of BodySupport"),
        (
            lambda: BodyScene([BODY], loads=Pressure(boundary="rim", value=1)),
            "loads is .*; allowed: a list, each entry a Pressure or a Traction",
        ),
        (lambda: BodyScene([BODY], loads=[BODY]), r"loads\[0\] is .*; allowed: a Pressure or a Traction or a Body"),
        (
            lambda: BodyScene([BODY], loads=[BodyForce(body="rim", vector=(0, 1))]),
            "load in rim: there is no such body; allowed: block",
        ),
        (lambda: BodyScene([BODY, BODY]), "body name 'block' is used twice"),
        (lambda: BodyScene([BODY], size=0.0), "size is 0.0; allowed: a finite length > 0"),
        (lambda: BodyScene([BODY], order=7), "order is 7; allowed: a whole number from 1 to 6"),
        (lambda: BodyScene([BODY], accuracy=0.0), "accuracy is 0.0; allowed: a number > 0, or infinity"),
        (lambda: BodyScene([BODY], steps=0), "steps is 0; allowed"),
        (lambda: BodyScene([BODY], levels=(0.5, 0.5)), r"levels is \(0.5, 0.5\); allowed: a whole number"),
        (lambda: BodyScene([BODY], contact="penalty"), "contact is 'penalty'; allowed: a Penalty"),
    ],
)
def test_wrong_scenes_say_what_is_allowed(make, message):
    with pytest.raises(CaseError, match="^" + message):
        make()


@pytest.mark.parametrize(
    ("kind", "given", "message"),
    [
        (Pressure, {"boundary": "bo re", "value": 1.0}, "Pressure: boundary is 'bo re'; allowed: letters, digits"),
        (Pressure, {"boundary": "b", "value": (1, 2)}, r"Pressure: value is \(1, 2\); allowed: a valid number"),
        (Pressure, {"boundary": "b", "value": float("inf")}, "Pressure: value is inf; allowed: a finite number"),
        (Traction, {"boundary": "", "vector": (1, 2)}, "Traction: boundary is ''; allowed: letters, digits"),
        (Traction, {"boundary": "b", "vector": 1.0}, "Traction: vector is 1.0; allowed: two finite numbers, or three"),
        (Traction, {"boundary": "b", "vector": (1, "2")}, r"Traction: vector is \(1, '2'\); allowed: two finite"),
        (BodyForce, {"body": "b", "vector": (1, None)}, r"BodyForce: vector is \(1, None\); allowed: two finite"),
        (BodyForce, {"body": "b", "vector": (1, 2, 3, 4)}, r"BodyForce: vector is \(1, 2, 3, 4\); allowed: two finite"),
    ],
)
def test_wrong_loads_say_what_is_allowed(kind, given, message):
    with pytest.raises(CaseError, match=f"^{message}[^\n]*$"):
        kind(**given)


@pytest.mark.parametrize(
    ("make", "lines"),
    [
        (lambda: Polygons(cells=5, wall=0.1), [
            "Polygons: file is missing; ",
            "Polygons: cells is unknown; allowed: wall",
        ]),
        (lambda: MooneyRivlin(c1=-1, c2=0, bulk_modulos=9), [
            "MooneyRivlin: c1 is -1; allowed: greater than 0",
            "MooneyRivlin: bulk_modulus is missing; allowed: c1 (needed), c2 (needed), bulk_modulus (needed)",
            "MooneyRivlin: bulk_modulos is unknown; did you mean bulk_modulus?",
        ]),
        (lambda: Case.model_validate({"tissue": {"rows": 1, "cols": 2, "wall": -0.1}, "colour": 3}), [
            "Case: tissue.wall is -0.1; allowed: greater than 0",
            "Case: material is missing; ",
            "Case: load is missing; ",
            "Case: colour is unknown; allowed: tissue (needed)",
        ]),
        (lambda: Study(case="a", axes={"tissue.wall": {"kind": "gird"}}), [
            "Study: axes.tissue.wall is {'kind': 'gird'}; allowed: grid, range",
        ]),
    ],
)  # fmt: skip
def test_a_wrong_keyword_of_a_script_is_one_line_each(make, lines):
    with pytest.raises(CaseError) as caught:
        make()
    told = str(caught.value).splitlines()
    assert len(told) == len(lines) and all(line.startswith(begin) for line, begin in zip(told, lines, strict=True))
