"""What a finite penalty takes of the energy where loads act."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

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
