"""What a finite penalty takes of the energy where loads act."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import ngcell
from ngcell.build import mesh_level
from ngcell.mechanics.term import Role
from ngcell.results.error import Numbers
from ngcell.results.softness import beside_rigid_contact

NUMBERS = Numbers(1.0, 1.0, np.ones(2), 1.0, 1.0, 1.0, (1e-9, 1e-9, 1e-2), besides=0.01)
#: Forces times overlaps.
OVERLAPS = 1e-3


def problem(load: float) -> Any:
    """A weight that a wall bears by a penalty: the wall moves along the first unknown."""
    return SimpleNamespace(
        overlap_work=lambda _: OVERLAPS,
        force=lambda _, role: np.array([-load if role is Role.LOAD else 0.0, 0.0]),
        gradient_of_constraints=lambda state: np.array([state.contact, 0.0]),
        gradient=lambda state: np.array([0.0, 0.0]),
        free=np.ones(2, dtype=bool),
    )


def state(place: float, contact: float, energy: float = 1.0) -> Any:
    return SimpleNamespace(displacement=np.array([place, 0.0]), at=None, energy=energy, contact=contact)


@pytest.mark.parametrize("load", [0.0, -3.0, 2.0])
@pytest.mark.parametrize("there", [1.0, 100.0])
def test_the_energy_errs_by_what_loads_do_on_the_way_to_rigid_contact(load: float, there: float):
    """And not by what walls store that the straight way leads through."""
    told = beside_rigid_contact(NUMBERS, problem(load), state(0.0, 1.0), state(0.01, 0.0, there))
    changed = abs(load * 0.01 + OVERLAPS / 2)
    assert told.besides == pytest.approx(NUMBERS.besides + max(changed - OVERLAPS, 0))


def test_a_way_too_far_tells_nothing_of_forces():
    told = beside_rigid_contact(NUMBERS, problem(0.0), state(0.0, 1.0), state(9.0, 0.0, float("nan")))
    assert told.stiffer == 0 and told.besides >= NUMBERS.besides


def test_what_is_stored_changes_by_the_work_of_loads_on_the_way_to_rigid_contact(monkeypatch: pytest.MonkeyPatch):
    """By balance, in a tissue under pressure: to the first digits, where the way is short."""
    slopes = []

    def seen(numbers: Numbers, problem: Any, state: Any, rigid: Any) -> Numbers:
        way, short = rigid.displacement - state.displacement, 1e-3
        there = problem.at(state.displacement + short * way)
        stored = [one.energy - problem.unstored(one.at) for one in (state, there)]
        slopes.append(((stored[1] - stored[0]) / short, -float(problem.force(state.at, Role.LOAD) @ way)))
        return beside_rigid_contact(numbers, problem, state, rigid)

    monkeypatch.setattr(mesh_level, "beside_rigid_contact", seen)
    sets = ("tissue.rows=2", "tissue.cols=2", "load.levels=1", "accuracy=0.1")
    assert [*ngcell.simulate(ngcell.read_case("shear-pressurised", sets))][-1].record.certified
    found, worked = np.array(slopes).T
    assert (np.abs(worked) > 0).all()
    np.testing.assert_allclose(found, worked, rtol=0.01)
