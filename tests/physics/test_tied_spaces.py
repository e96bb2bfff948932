"""A tied tissue with spaces between its cells, compressed until these close."""

from __future__ import annotations

from math import inf
from typing import Any

import pytest

from ngcell import Case, simulate
from ngcell.build.reported import Step
from tests.prisms import MATERIAL


TISSUE = {"rows": 2, "cols": 2, "wall": 0.129, "orientation": "flat", "corner_radius": 0.566}
LOAD = {"kind": "frame", "stretch": [0.911, 0.955], "levels": 1}
HEIGHT = 0.3


def case(mesh: dict[str, Any], *, tissue: dict[str, Any] | None = None, load: dict[str, Any] | None = None) -> Case:
    """The tissue between the sides of a frame that close in; entries that are given join its own."""
    parts = {"tissue": TISSUE | (tissue or {}), "load": LOAD | (load or {})}
    return Case.model_validate({**parts, "material": MATERIAL, "mesh": mesh, "accuracy": inf})


@pytest.fixture(scope="module")
def pressed() -> list[Step]:
    return simulate(case({"order": 3}))


def value(step: Step, name: str) -> float:
    (found,) = (check.value for check in step.measurement.certificate.checks if check.name == name)
    return found


def test_walls_around_spaces_do_not_pass_through_each_other(pressed: list[Step]) -> None:
    """Without contact they are 40 % of the wall deep in each other."""
    tied, released = pressed
    assert tied.record.phase == "tied" and tied.record.certified and released.record.certified
    assert 1e-3 < value(tied, "penetration_over_wall") < 0.02


def test_walls_that_are_released_store_less(pressed: list[Step]) -> None:
    """Without contact the tied tissue, in which walls pass through each other, stored 2 % less than they do."""
    tied, released = pressed
    assert released.record.energy < tied.record.energy
    assert value(released, "energy_above_tied") == 0


def test_prisms_are_tied_as_planar_cells_are() -> None:
    planar, *_ = simulate(case({"order": 1, "size": 2.0}))
    prisms, *_ = simulate(
        case({"order": 1, "size": 2.0, "slices": 1}, tissue={"height": HEIGHT}, load={"ends": "held"})
    )
    assert value(planar, "penetration_over_wall") > 1e-3
    for name in ("penetration_over_wall", "residual"):
        assert value(prisms, name) == pytest.approx(value(planar, name), rel=1e-6, abs=1e-9), name
    assert prisms.record.energy == pytest.approx(HEIGHT * planar.record.energy, rel=1e-9)
