"""What contact costs in accuracy, on rings that no number of the solver was chosen for."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import product
from math import inf
from typing import Any

import pytest

import ngcell
from tools.references import contact_error, radial
from tools.references.contact_error import LIMIT, RINGS
from tools.solutions import solved
from tools.studies.work_precision import rings


@pytest.fixture(scope="module", autouse=True)
def exact_once() -> Iterator[None]:
    """The one-dimensional solution of each ring is found once: it takes longer than what it is compared with."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("press_fit", "closing", "pulled_apart"):
            patch.setattr(radial, name, cache(getattr(radial, name)))
        yield


@cache
def found(name: str, contact: str, order: int | None) -> dict[str, Any]:
    return contact_error.found(RINGS[name], contact, order)


#: All rings by the penalty on meshes of their own; one ring, with NGSolve's contact, too, on a given mesh as well.
SOLVED = [
    (name, contact, order)
    for name, contact, order in product(RINGS, LIMIT, (None, 3))
    if name == "parting" or (order is None and contact == "penalty")
]


@pytest.mark.parametrize(("name", "contact", "order"), SOLVED)
def test_contact_costs_a_quarter_of_the_accuracy_at_most(name, contact, order):
    errors = found(name, contact, order)
    assert errors["certified"]
    told = [errors[what] for what in ("radii", "gap", "pressure") if errors[what] != ""]
    assert len(told) == 2 and max(told) <= LIMIT[contact]


@pytest.mark.parametrize("name", [name for name, rings in RINGS.items() if rings.pulled is None])
def test_the_cost_of_a_penalty_is_part_of_the_error_that_is_told(name):
    errors = found(name, "penalty", None)
    assert errors["pressure"] <= errors["estimated"] <= 0.01


@pytest.mark.parametrize("times", [1.0, 10.0])
def test_the_cost_of_a_penalty_is_told_where_a_pressure_drives_rings_together(times):
    def last(contact, order, accuracy):
        return solved(rings.scene("above", contact, order, 0.25, accuracy)).last.record

    rigid, soft = last(ngcell.Mortar(), 5, inf), last(ngcell.Penalty(stiffness=times), 4, 0.1)
    for name in ("energy", "contact_force"):
        off = abs(getattr(soft, name) - getattr(rigid, name))
        assert 0.3 < off / getattr(soft, f"{name}_error") < 1
