"""With which multipliers, and how stiff, the mortar method takes over from a penalty."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.methods.penalty import PenaltyContact
from tests.contact.stacks import REACH, Stack, blocks
from tests.tissues import NOTHING


def pressed(stack: Stack, overlap: float) -> tuple[PenaltyContact, np.ndarray]:
    """A penalty between blocks that overlap."""
    penalty = PenaltyContact(stack.walls, stack.contact.stiffness, REACH)
    return penalty, stack.positions(stack.upper_moved((0.0, -overlap)))


@pytest.mark.parametrize("order", [2, 3])
def test_points_within_their_allowance_begin_without_a_multiplier(order):
    """Their gaps are open: multipliers of theirs would have to go before those of walls that press are right."""
    stack = blocks((0.3, 0.17), order=order)
    contact, size = stack.contact, stack.contact.space.size
    overlap = 0.5 * contact._options.allowed * float(stack.walls.sizes.min())
    penalty, positions = pressed(stack, overlap)
    contact.follow(penalty, positions)
    found = contact.pair(positions)
    assert not contact.multipliers[size:].any()
    functions = found.pressure[found.rows < size]
    np.testing.assert_allclose(functions[functions > 0], overlap * contact.stiffness.min(), rtol=0.2)


@pytest.mark.parametrize("order", [2, 3])
def test_points_that_are_deeper_begin_with_one(order):
    stack = blocks((0.3, 0.17), order=order)
    penalty, positions = pressed(stack, 10 * stack.contact._options.allowed * float(stack.walls.sizes.max()))
    stack.contact.follow(penalty, positions)
    assert stack.contact.multipliers[stack.contact.space.size :].any()


@pytest.mark.parametrize(("raised", "begun"), [(1.0, 1.0), (100.0, 1000.0), (1e6, 1e7)])
def test_terms_begin_as_much_stiffer_as_a_penalty_that_is_meant_would_be(raised, begun):
    """Confined walls are stiffer than the layers that stiffness is derived from, and a penalty that hands over may
    store ten times as much as one that is meant. They never become softer."""
    stack = blocks((0.3, 0.17))
    penalty, positions = pressed(stack, 1e-3)
    penalty.recall({"factor": np.full(2, raised), "is_refined": np.zeros(2, dtype=bool)})
    derived = stack.contact.pair(positions).stiffness
    stack.contact.follow(penalty, positions)
    found = stack.contact.pair(positions)
    np.testing.assert_allclose(found.stiffness, begun * derived)
    stack.contact.update_multipliers(found, positions, NOTHING)
    stack.contact.increase_penalty()
    assert (stack.contact.pair(positions).stiffness >= found.stiffness).all()
