"""With which multipliers, and how stiff, the mortar method takes over from a penalty."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.methods.penalty import PenaltyContact
from tests.contact.stacks import REACH, Stack, blocks


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


def test_terms_begin_as_much_stiffer_as_the_penalty_had_to_become():
    """Confined walls are stiffer than the layers that stiffness is derived from."""
    stack = blocks((0.3, 0.17))
    penalty, positions = pressed(stack, 1e-3)
    penalty.recall({"factor": np.array([100.0, 100.0]), "is_refined": np.zeros(2, dtype=bool)})
    derived = stack.contact.pair(positions).stiffness
    stack.contact.follow(penalty, positions)
    np.testing.assert_allclose(stack.contact.pair(positions).stiffness, 100 * derived)
