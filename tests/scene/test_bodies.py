"""Scenes of own bodies: what they may say, and how they refuse the rest."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import pytest

from ngcell.errors import CaseError
from ngcell.scene import MooneyRivlin
from ngcell.scene.bodies import Body, BodyForce, BodyScene, BodySupport, Pressure, Traction

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
    loads = [Pressure("bore", 1), Traction("rim", (0, -0.5))]
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
        (lambda: Pressure("bo re", 1.0), "boundary of a pressure is 'bo re'; allowed: letters"),
        (lambda: Pressure("bore", (1, 2)), r"pressure on bore: value is \(1, 2\); allowed: a finite number"),
        (lambda: Pressure("bore", float("inf")), "pressure on bore: value is inf; allowed: a finite number"),
        (lambda: Traction("", (1, 2)), "boundary of a traction is ''; allowed: letters"),
        (lambda: Traction("rim", 1.0), "traction on rim: vector is 1.0; allowed: two finite numbers"),
        (lambda: Traction("rim", (1, "2")), r"traction on rim: vector is \(1, '2'\); allowed: two finite"),
        (lambda: BodyScene([BODY], loads=Pressure("rim", 1)), "loads is .*; allowed: a list of Pressure or"),
        (lambda: BodyScene([BODY], loads=[BODY]), "loads is .*; allowed: a list of Pressure or Traction or BodyForce"),
        (lambda: BodyForce("block", (1, None)), r"force on block: vector is \(1, None\); allowed: two finite"),
        (lambda: BodyScene([BODY], loads=[BodyForce("rim", (0, 1))]), "force on rim: there is no such body; allowed"),
        (lambda: BodyScene([BODY, BODY]), "body name 'block' is used twice"),
        (lambda: BodyScene([BODY], size=0.0), "size is 0.0; allowed: a finite length > 0"),
        (lambda: BodyScene([BODY], order=5), "order is 5; allowed: a whole number from 1 to 4"),
        (lambda: BodyScene([BODY], steps=0), "steps is 0; allowed"),
        (lambda: BodyScene([BODY], levels=(0.5, 0.5)), r"levels is \(0.5, 0.5\); allowed: a whole number"),
        (lambda: BodyScene([BODY], contact="penalty"), "contact is 'penalty'; allowed: a Penalty"),
    ],
)
def test_wrong_scenes_say_what_is_allowed(make, message):
    with pytest.raises(CaseError, match="^" + message):
        make()
