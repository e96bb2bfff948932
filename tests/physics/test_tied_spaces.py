"""A tied tissue with spaces between its cells, compressed until these close."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from ngcell import Case, simulate
from ngcell.build.reported import Step
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.strategies import sddp
from ngcell.solve.strategies.strategy import Task
from tests.prisms import MATERIAL

CASE = {
    "tissue": {"rows": 2, "cols": 2, "wall": 0.129, "orientation": "flat", "corner_radius": 0.566},
    "material": MATERIAL,
    "load": {"kind": "frame", "stretch": [0.911, 0.955], "levels": 1},
    "mesh": {"order": 3},
    "accuracy": inf,
}


@pytest.fixture(scope="module")
def pressed() -> list[Step]:
    return simulate(Case.model_validate(CASE))


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


def test_walls_around_spaces_that_close_as_a_tissue_is_stretched_come_to_rest_on_each_other() -> None:
    """Points beside a cusp have their closest points at ends of edges. Taken for feet of normals, no equilibrium was
    found in 70 s."""
    tissue = {"rows": 2, "cols": 2, "wall": 0.1, "corner_radius": 0.1}
    case = Case.model_validate(CASE | {"tissue": tissue, "load": {"kind": "plates", "stretch": 1.2, "levels": 1}})
    tied, released = simulate(case)
    assert tied.record.certified and released.record.certified
    assert tied.record.iterations < 50 and value(tied, "penetration_over_wall") > 0


def test_where_the_tied_tissue_is_found_without_contact_only_it_is_not_certified_and_walls_are_released(
    pressed: list[Step], monkeypatch: pytest.MonkeyPatch
) -> None:
    def not_found(task: Task, start: np.ndarray, proximal: ProximalTerm, load: float) -> Minimum:
        return Minimum(task.tied[-1].problem.at(start), Ending.NO_DESCENT, 0.0, proximal)

    monkeypatch.setattr(sddp, "_tied_minimum", not_found)
    tied, released = simulate(Case.model_validate(CASE))
    assert not tied.record.certified and value(tied, "penetration_over_wall") > 0.3
    assert released.record.certified
    assert released.record.energy == pytest.approx(pressed[1].record.energy, rel=1e-6)
