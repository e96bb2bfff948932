"""Concave joints that a point is pressed over: what models have of them is the energy in the sector behind a joint."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.penalty_set import PenaltySet
from ngcell.mechanics.term import OneSided
from tests.contact.test_notches import ASIDE, DEPTH, NOTCH, ORDERS, Pressed
from tests.tissues import LONGEST_STEP

#: Half of the width of the sector, by which the tip overlaps the notch: its edges rise by `NOTCH` over half of a side.
HALF_SECTOR = DEPTH * NOTCH / 0.5


class Tip:
    """The tip that presses into a notch, by the penalty method."""

    def __init__(self, order: int, notch: float = NOTCH) -> None:
        self.pressed = Pressed(order, notch)
        walls = self.pressed.tissue.walls
        self.contact = PenaltyContact(walls, np.ones(walls.facet_count), reach=2 * LONGEST_STEP)

    def at(self, aside: float) -> tuple[PenaltySet, np.ndarray]:
        positions = self.pressed.positions(self.pressed.displacement(aside))
        return self.contact.pair(positions), positions

    def over(self, before: float, after: float) -> OneSided | None:
        """What a step of the tip from one place to another goes over."""
        (start, at), (end, there) = self.at(before), self.at(after)
        return start.joints_ahead(at, end, there)


@pytest.mark.parametrize("order", ORDERS)
def test_the_distance_to_a_joint_has_its_derivative(order):
    tip = Tip(order)
    found, moved = tip.over(ASIDE, -ASIDE), tip.over(0.9 * ASIDE, -ASIDE)
    assert found is not None and moved is not None
    np.testing.assert_array_equal(found.keys, moved.keys)
    assert (found.gap > moved.gap).all() and (moved.gap > 0).all()
    change = (tip.pressed.displacement(0.9 * ASIDE) - tip.pressed.displacement(ASIDE)).ravel()
    np.testing.assert_allclose(found.jacobian @ change, moved.gap - found.gap, rtol=0.02)
    np.testing.assert_allclose(found.gap, ASIDE, rtol=0.1)


def test_a_model_with_it_has_the_energy_in_the_sector_behind_the_joint():
    tip = Tip(order=1)
    before, inside, beyond = 1.5 * HALF_SECTOR, 0.25 * HALF_SECTOR, -1.5 * HALF_SECTOR
    over = tip.over(before, beyond)
    assert over is not None
    (start, at), (end, there) = tip.at(before), tip.at(inside)
    way = (there - at).ravel()
    assert end.kinematics.pairs.at_end[end.gaps(there) < -0.5 * DEPTH].any()
    gap, jacobian, penalty = start.penalty_terms(at)

    def stored(gaps: np.ndarray, stiffness: np.ndarray) -> float:
        return 0.5 * float(stiffness @ np.minimum(gaps, 0) ** 2)

    without = stored(gap + jacobian @ way, penalty)
    added = stored(over.gap + over.jacobian @ way, over.penalty)
    lacking = end.energy(there) - without
    assert lacking > 0
    assert added == pytest.approx(lacking, rel=0.1), (added, lacking)


def test_nothing_is_told_of_a_step_out_of_reach():
    tip = Tip(order=1)
    (start, at), far = tip.at(ASIDE), tip.pressed.tissue.body_translation(1, np.array([1.0, 0.0]))
    there = tip.pressed.positions(far)
    apart = tip.contact.pair(there)
    assert not len(apart.keys)
    assert start.joints_ahead(at, apart, there) is None


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(
    ("notch", "before", "after"),
    [(NOTCH, ASIDE, 0.5 * ASIDE), (-NOTCH, ASIDE, -ASIDE)],
    ids=["no joint between", "a convex joint"],
)
def test_nothing_is_told_of_steps_that_go_over_no_concave_joint(order, notch, before, after):
    assert Tip(order, notch).over(before, after) is None
