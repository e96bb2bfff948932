"""Points in notches of the mortar method: both edges hold them, each with a multiplier, and no kink is left."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.methods.mortar import MortarContact
from ngcell.contact.methods.mortar_set import MortarSet
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.terms import ContactTerm
from ngcell.problem.problem import Problem
from tests.contact.derivatives import assert_derivatives
from tests.tissues import LAW, LONGEST_STEP, NOTHING, small_tissue

ORDERS = [1, 2, 3]
#: How deep the notch is and the tip presses in, and how far the tip goes to either side.
NOTCH, DEPTH, ASIDE = 0.02, 0.003, 0.004


class Pressed:
    """Two cells: a notch in the middle of the left one's wall, and a tip of the right one that presses into it."""

    def __init__(self, order: int, notch: float = NOTCH) -> None:
        self.tissue = small_tissue(1, 2, order=order, edges=2)
        self.notch = notch
        modulus = np.full(2, LAW.plane_strain_modulus)
        walls = self.tissue.walls
        self.contact = MortarContact(walls, penalty_stiffness(walls, modulus, 10.0), reach=2 * LONGEST_STEP)
        terms = [self.tissue.bulk, ContactTerm(self.contact)]
        self.problem = Problem(self.tissue.space, terms, self.tissue.motion.fixed)

    def displacement(self, aside: float, depth: float = DEPTH) -> np.ndarray:
        """The middles of both walls move to the left, that of the right cell further; all of that cell goes aside."""
        space = self.tissue.space
        left, right = (self._middle(body) for body in (0, 1))
        field = np.zeros((2, space.size))
        field[0, left], field[0, right] = -self.notch, -self.notch - 2 * NOTCH - depth
        field[0] += 2 * NOTCH * (space.body_of_unknown == 1) * space.one
        return field.ravel() + self.tissue.body_translation(1, np.array([0.0, aside]))

    def _middle(self, body: int) -> int:
        space, (x, y) = self.tissue.space, self.tissue.space.rest
        wall = x[(space.body_of_unknown == 0) & (space.one == 1)].max()
        middle = self.tissue.lattice.centres[0, 1]
        there = (space.body_of_unknown == body) & (space.one == 1) & (np.hypot(x - wall, y - middle) < 1e-9)
        (number,) = np.flatnonzero(there)
        return int(number)

    def positions(self, displacement: np.ndarray) -> np.ndarray:
        return self.problem.configuration(displacement).positions

    def go(self, *asides: float) -> list[bool]:
        """Where the tip goes to, one place after the other; whether points were taken up there."""
        found = []
        for aside in asides:
            positions = self.positions(self.displacement(aside))
            found.append(self.contact.note_kinks(self.contact.pair(positions), positions))
        return found

    def tip(self, contact: MortarSet) -> np.ndarray:
        """The rows of the tip, whichever edge holds it."""
        pairs, walls = contact.kinematics.pairs, self.tissue.walls
        middle = self.tissue.space.rest[:, self._middle(1)]
        place = walls.places(pairs.primary, pairs.primary_xi, walls.rest)
        mine = (np.linalg.norm(place - middle, axis=1) < 1e-9) & (walls.body[pairs.primary] == 1)
        is_point = contact.rows >= self.contact.space.size
        return np.flatnonzero(is_point & (contact.average @ mine.astype(float) > 0.5))

    def force_on_tip(self, aside: float) -> np.ndarray:
        """Forces on all unknowns by the conditions of the tip."""
        positions = self.positions(self.displacement(aside))
        contact = self.contact.pair(positions)
        rows = self.tip(contact)
        _, jacobian, _ = contact.penalty_terms(positions)
        return jacobian[rows].T @ (contact.weight * contact.pressures(positions))[rows]


@pytest.mark.parametrize("order", ORDERS)
def test_a_point_that_goes_to_and_fro_over_a_notch_is_held_by_both_edges(order):
    pressed = Pressed(order)
    assert pressed.go(ASIDE, ASIDE / 2, -ASIDE, ASIDE) == [False, False, False, True]
    contact = pressed.contact.pair(pressed.positions(pressed.displacement(ASIDE)))
    rows = pressed.tip(contact)
    pairs = contact.kinematics.pairs
    assert len(rows) == 2
    edges = pairs.secondary[[contact.average[[row]].tocsr().indices[0] for row in rows]]
    assert len(set(edges)) == 2 and (pressed.tissue.walls.body[edges] == 0).all()


@pytest.mark.parametrize("order", ORDERS)
def test_no_point_is_held_at_a_joint_that_is_not_concave(order):
    pressed = Pressed(order, notch=-NOTCH)
    assert pressed.go(ASIDE, -ASIDE, ASIDE) == [False, False, False]


def held(order: int) -> Pressed:
    """A tip that both edges hold, with multipliers of all conditions."""
    pressed = Pressed(order)
    pressed.go(ASIDE, -ASIDE, ASIDE)
    random, multipliers = np.random.default_rng(2), pressed.contact.multipliers
    multipliers[:] = 0.01 * pressed.contact.stiffness[0] * random.uniform(0.5, 1, len(multipliers))
    return pressed


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("aside", [ASIDE, 0.3 * ASIDE, -ASIDE])
def test_forces_and_tangent_are_derivatives_of_one_energy(order, aside):
    """Of points alone: what the ends of segments add to the tangent is exact only where gaps vanish there."""
    pressed = held(order)
    pressed.contact.multipliers[: pressed.contact.space.size] = 0
    at = pressed.displacement(aside, depth=-0.002)
    assert len(pressed.tip(pressed.contact.pair(pressed.positions(at)))) == 2
    way = pressed.tissue.smooth(1.0, 8)
    assert_derivatives(pressed.problem, at, way, step=1e-6, rel=1e-6)


@pytest.mark.parametrize("order", ORDERS)
def test_the_force_on_a_held_point_does_not_jump_over_the_joint(order):
    """Over half the way it changes by half as much."""
    free, both = Pressed(order), held(order)
    free.contact.multipliers[:] = both.contact.multipliers
    changes = np.array(
        [
            [np.abs(np.subtract(*map(pressed.force_on_tip, (aside, -aside)))).max() for aside in (4e-4, 2e-4)]
            for pressed in (free, both)
        ]
    )
    shares = changes[:, 1] / changes[:, 0]
    assert shares[0] > 0.8 and shares[1] < 0.6


def test_far_from_the_notch_a_point_is_held_by_what_is_nearest_and_released():
    """As when it slides on: its pressure stays with it."""
    pressed = held(2)
    at = pressed.positions(pressed.displacement(0.55))
    contact = pressed.contact.pair(at)
    assert len(pressed.tip(contact)) < 2
    pressed.contact.update_multipliers(contact, at, NOTHING)
    assert len(pressed.tip(pressed.contact.pair(pressed.positions(pressed.displacement(ASIDE))))) == 1


def test_a_point_that_one_edge_holds_alone_is_released_with_its_pressure():
    pressed = Pressed(2)
    pressed.go(ASIDE, -ASIDE, ASIDE)
    at = pressed.positions(pressed.displacement(0.1, depth=0.001))
    contact = pressed.contact.pair(at)
    rows = pressed.tip(contact)
    applied = contact.pressures(at)[rows]
    assert sorted(applied > 0) == [False, True]
    pressed.contact.update_multipliers(contact, at, NOTHING)
    after = pressed.contact.pair(at)
    (row,) = pressed.tip(after)
    assert after.pressure[row] == pytest.approx(applied.max(), rel=1e-12)
