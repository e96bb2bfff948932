"""Bodies that nothing can touch: every edge is named as untouched, so there are no walls."""

from __future__ import annotations

from math import inf
from pathlib import Path

import pytest
from netgen.occ import Box, Pnt, Rectangle

from ngcell import Body, BodyScene, BodySupport, Mortar, NgsolveContact, Penalty, Sddp, record, simulate
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.report import write_report
from ngcell.run import inspect

RUBBER = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=20.0)


def scene(*, solid: bool = False, walls: bool = False, **changes) -> BodyScene:
    shape = Box(Pnt(0, 0, 0), Pnt(1, 1, 1)) if solid else Rectangle(1, 1).Face()
    sides = shape.faces if solid else shape.edges
    for side, name in zip(sides, "abcdef", strict=False):
        side.name = name
    body = Body(shape, RUBBER, "block", untouched=() if walls else tuple("abcdef"[: len(sides)]))
    moved, by = ("b", (0.05, 0.0, 0.0)) if solid else ("c", (0.0, 0.05))
    supports = [BodySupport("a"), BodySupport(moved, translation=by)]
    return BodyScene([body], supports, **{"levels": 1, "accuracy": inf, "order": 2 - solid, **changes})


@pytest.mark.parametrize(
    ("contact", "solid"), [(Penalty(), False), (Mortar(), False), (NgsolveContact(), False), (Penalty(), True)]
)
def test_a_body_without_walls_stores_what_one_stores_that_nothing_touches(contact, solid):
    (expected,) = simulate(scene(solid=solid, walls=True))
    (step,) = simulate(scene(solid=solid, contact=contact))
    assert step.record.certified
    assert step.record.energy == pytest.approx(expected.record.energy, rel=1e-9)


def test_it_is_tied_recorded_inspected_and_reported(tmp_path: Path):
    assert all(step.record.certified for step in simulate(scene(strategy=Sddp())))
    list(record(scene(), tmp_path / "run"))
    assert write_report([tmp_path / "run"]).remarks == ()
    assert inspect(scene())["penalty_stiffness"] is None
