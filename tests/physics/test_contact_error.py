"""What contact costs in accuracy, on rings that no number of the solver was chosen for."""

from __future__ import annotations

from itertools import product

import pytest

from tools.references.contact_error import LIMIT, RINGS, found


@pytest.mark.parametrize(("name", "contact", "order"), list(product(RINGS, LIMIT, (None, 3))))
def test_contact_costs_a_quarter_of_the_accuracy_at_most(name, contact, order):
    errors = found(RINGS[name], contact, order)
    assert errors["certified"]
    told = [errors[what] for what in ("radii", "gap", "pressure") if errors[what] != ""]
    assert len(told) == 2 and max(told) <= LIMIT[contact]


@pytest.mark.parametrize("name", [name for name, rings in RINGS.items() if rings.pulled is None])
def test_the_cost_of_a_penalty_is_part_of_the_error_that_is_told(name):
    errors = found(RINGS[name], "penalty")
    assert errors["pressure"] <= errors["estimated"] <= 0.01
