"""The mortar method: weighted gaps, the energy of its penalty terms, their forces and tangent, and what it updates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest
from scipy import optimize, sparse

from ngcell.contact.methods.mortar import MortarContact
from ngcell.contact.methods.mortar_set import MortarSet
from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.pressures_alike import nodal_forces, pressures_alike
from ngcell.contact.methods.terms import ContactTerm
from ngcell.mechanics.term import Role
from ngcell.problem.problem import Problem
from ngcell.problem.state import State
from tests.contact.stacks import Stack, blocks, rings
from tests.tissues import (
    LAW,
    LONGEST_STEP,
    NOTHING,
    SmallTissue,
    contact_set,
    contact_term,
    small_tissue,
    whole_tangent,
)

ORDERS = [1, 2, 3, 4]
#: Multipliers of pressed walls, in units of penalty stiffness times length.
PRESSURE = 0.02


@dataclass(frozen=True, eq=False)
class Cells:
    """Two cells side by side with a mortar between them, and multipliers of its own for each function."""

    tissue: SmallTissue
    multipliers: float

    @cached_property
    def contact(self) -> MortarContact:
        walls = self.tissue.walls
        modulus = np.full(self.tissue.bodies.body_count, LAW.plane_strain_modulus)
        contact = MortarContact(walls, penalty_stiffness(walls, modulus, 10.0), reach=2 * LONGEST_STEP)
        size, random = contact.space.size, np.random.default_rng(1)
        contact.multipliers[:size] = self.multipliers * contact.stiffness[0] * random.uniform(0.5, 1, size)
        return contact

    @cached_property
    def problem(self) -> Problem:
        terms = [self.tissue.bulk, ContactTerm(self.contact)]
        return Problem(self.tissue.space, terms, self.tissue.motion.fixed)

    def state(self, depth: float, aside: float, bend: float = 0.02) -> State:
        """Bent walls, the right cell pressed in by `depth` and along by `aside`."""
        translation = self.tissue.body_translation(1, np.array([-depth, aside]))
        return self.problem.at(self.tissue.smooth(bend, 3) + translation)

    def along_walls(self, state: State) -> np.ndarray:
        """Which of the weighted gaps belong to functions; the others belong to point constraints."""
        return contact_set(self.problem, state).rows < self.contact.space.size


def cells(order: int, multipliers: float = 0.0) -> Cells:
    return Cells(small_tissue(1, 2, order=order, edges=2), multipliers)


#: Depth, slide along the wall and multipliers of states, and how many of the gaps are pressed.
STATES = {
    "open": (-0.04, 0.2, 0.0, "none"),
    "open, with multipliers that have released": (-0.07, 0.2, PRESSURE / 2, "none"),
    "open, still pressed": (-0.01, 0.2, 3 * PRESSURE, "all"),
    "closed": (0.01, 0.2, 0.0, "all"),
    "closed, with multipliers": (0.01, 0.2, PRESSURE, "all"),
    "deep": (0.05, 0.2, PRESSURE, "all"),
    "slid off": (0.01, 0.8, PRESSURE, "some"),
    "nearly past": (0.012, 1.02, PRESSURE, "some"),
}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", STATES)
def test_forces_are_the_slopes_of_the_energy(order, name):
    """Segments and contact pairs are found anew in each state, so the cuts' share in the slope is tested, too."""
    depth, aside, multipliers, pressed = STATES[name]
    pair = cells(order, multipliers)
    state = pair.state(depth, aside)
    gap, _, _ = contact_set(pair.problem, state).penalty_terms(pair.tissue.positions(state.displacement))
    closed = gap < 0
    assert {"none": not closed.any(), "some": closed.any(), "all": closed[pair.along_walls(state)].all()}[pressed]
    way = pair.tissue.smooth(1.0, 8)
    slope = pair.problem.force(state.at, Role.INTERACTION) @ way
    misses = []
    for step in (4e-4, 2e-4, 1e-4):
        after, before = (moved(pair.problem, state, size * way) for size in (step, -step))
        misses.append(abs((after - before) / (2 * step) - slope))
    if pressed == "none":
        assert slope == 0 and max(misses) == 0
    else:
        assert misses[-1] < 1e-5 * abs(slope)
        np.testing.assert_allclose(np.log2(misses[0] / misses[-1]) / 2, 2, atol=0.1)


@pytest.mark.parametrize("seed", [29, 35, 36])
def test_forces_are_slopes_where_the_rule_does_not_integrate_gaps_exactly(seed):
    """As the ends of segments move, so do the points of the rule. The integral's own slope is off by 7e-8 to 5e-6."""
    pair, random = cells(4, PRESSURE), np.random.default_rng(seed)
    smooth = pair.state(0.02, 0.3, 0.1).displacement
    state = pair.problem.at(smooth + 0.03 * random.standard_normal(smooth.shape))
    way, step = pair.tissue.smooth(1.0, 100 + seed), 1e-6
    slope = pair.problem.force(state.at, Role.INTERACTION) @ way
    after, before = (moved(pair.problem, state, size * way) for size in (step, -step))
    assert (after - before) / (2 * step) == pytest.approx(slope, rel=3e-8)


def moved(problem: Problem, state: State, step: np.ndarray) -> float:
    """Contact energy after a step, with contact pairs found anew."""
    positions = problem.configuration(state.displacement + step).positions
    return contact_term(problem).method.pair(positions).energy(positions)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", ["open", "open, still pressed", "closed", "closed, with multipliers", "slid off"])
def test_the_tangent_is_the_slope_of_the_forces_up_to_squares_of_gaps_at_cuts(order, name):
    depth, aside, multipliers, _ = STATES[name]
    misses = []
    for shallow in (1.0, 0.5):
        pair = cells(order, multipliers * shallow)
        misses.append(tangent_miss(pair, pair.state(depth * shallow, aside, 0.02 * shallow)))
    # Less than one per cent: (0.03 / 0.3) ^ 2, the gap over the length of a segment.
    assert misses[0] < 1e-2
    assert misses[1] < 0.45 * misses[0] or misses[0] < 1e-8


def tangent_miss(pair: Cells, state: State) -> float:
    """How far the tangent times a direction is off the change of the forces, as a share of it."""
    way, step = pair.tissue.smooth(1.0, 8), 1e-5
    problem = pair.problem
    bent = whole_tangent(problem, problem.linearise(state)) @ way
    after, before = (problem.gradient(problem.at(state.displacement + size * way)) for size in (step, -step))
    return float(np.abs((after - before) / (2 * step) - bent).max() / np.abs(bent).max())


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", ["closed", "closed, with multipliers", "slid off"])
def test_the_convex_part_of_the_curvature_has_no_direction_in_which_it_falls(order, name):
    """What is left out bends the energy downwards, and nothing else."""
    depth, aside, multipliers, _ = STATES[name]
    pair = cells(order, multipliers)
    state = pair.state(depth, aside, 0.02)
    whole, convex = pair.problem.linearise(state).curvature, pair.problem.convex_curvature(state)
    assert whole is not None and convex is not None
    scale = abs(whole).max()
    lowest, highest = (np.linalg.eigvalsh(matrix.toarray()) for matrix in (convex, whole - convex))
    assert lowest.min() > -1e-12 * scale and highest.max() < 1e-12 * scale
    assert lowest.max() > 1e-3 * scale and highest.min() < -1e-3 * scale


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_model_holds_on_both_sides_of_the_kink(order, side):
    """At the kink all penalty terms are just at rest: pressed after a step to one side, not after one to the other."""
    pair = cells(order)
    state = pair.state(-0.01, 0.2, bend=0.0)
    contact, positions = contact_set(pair.problem, state), pair.tissue.positions(state.displacement)
    pair.contact.multipliers[contact.rows] = contact.stiffness * contact.weighted_gaps(positions)
    state = pair.problem.at(state.displacement)
    gap, jacobian, penalty = contact_set(pair.problem, state).penalty_terms(positions)
    assert np.abs(gap).max() < 1e-15 and np.abs(pair.problem.force(state.at, Role.INTERACTION)).max() < 1e-12
    way = side * pair.tissue.body_translation(1, np.array([1.0, 0.0]))
    foreseen = 0.5 * (penalty * np.minimum(jacobian @ way, 0) ** 2).sum()
    assert (foreseen > 0) == (side < 0)
    for step in (1e-3, 1e-4, 1e-5):
        change = moved(pair.problem, state, step * way) - moved(pair.problem, state, 0 * way)
        assert change / step**2 == pytest.approx(foreseen, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", STATES)
def test_a_rigid_motion_changes_no_gap_and_turns_the_forces(order, name):
    depth, aside, multipliers, _ = STATES[name]
    pair = cells(order, multipliers)
    before = pair.state(depth, aside)
    positions = pair.tissue.positions(before.displacement)
    turn = np.array([[np.cos(2.5), -np.sin(2.5)], [np.sin(2.5), np.cos(2.5)]])
    turned = turn @ positions + np.array([[7.0], [-3.0]]) * pair.tissue.space.one
    after = pair.problem.at((turned - pair.tissue.space.rest).ravel())
    seen, turned_set = (contact_set(pair.problem, state) for state in (before, after))
    np.testing.assert_array_equal(turned_set.rows, seen.rows)
    gaps = seen.weighted_gaps(positions)
    np.testing.assert_allclose(turned_set.weighted_gaps(turned), gaps, atol=1e-12)
    force, other = (pair.problem.force(state.at, Role.INTERACTION).reshape(2, -1) for state in (before, after))
    np.testing.assert_allclose(other, turn @ force, atol=1e-9 * max(1.0, np.abs(force).max()))


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", ["open, still pressed", "closed, with multipliers", "deep", "slid off"])
def test_forces_and_moments_on_the_two_bodies_cancel(order, name):
    depth, aside, multipliers, _ = STATES[name]
    pair = cells(order, multipliers)
    state = pair.state(depth, aside)
    assert_balanced(pair.problem, state)
    on_right = pair.tissue.space.body_of_unknown == 1
    force = pair.problem.force(state.at, Role.INTERACTION).reshape(2, -1) * pair.tissue.space.one
    assert force[0, on_right].sum() < 0  # the gradient falls towards the right: the right cell is driven that way


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("make", [blocks, rings])
def test_forces_and_moments_cancel_on_walls_whose_meshes_do_not_match(order, make):
    stack: Stack = make((0.3, 0.17), order=order)
    contact = stack.contact
    random = np.random.default_rng(4)
    contact.multipliers[:] = contact.stiffness[0] * PRESSURE * random.uniform(0, 1, len(contact.multipliers))
    state = stack.problem.at(stack.bent(0.02, 3) + stack.upper_moved((0.05, -0.01)))
    assert_balanced(stack.problem, state)


def assert_balanced(problem: Problem, state: State) -> None:
    force = problem.force(state.at, Role.INTERACTION).reshape(2, -1)
    x, y = state.positions
    size = np.abs(force).sum()
    assert size > 0
    np.testing.assert_allclose(force @ problem.space.one, 0, atol=1e-13 * size)
    assert x @ force[1] - y @ force[0] == pytest.approx(0, abs=1e-12 * size)


def pressed_pair(order: int) -> tuple[Cells, State, MortarSet, np.ndarray]:
    pair = cells(order, PRESSURE)
    state = pair.state(0.01, 0.2)
    return pair, state, contact_set(pair.problem, state), pair.tissue.positions(state.displacement)


@pytest.mark.parametrize("order", ORDERS)
def test_updated_pressures_are_what_the_penalty_terms_press_with(order):
    """With them, and walls that just touch, the same forces act; what was updated is told as a gap."""
    pair, state, contact, positions = pressed_pair(order)
    force, applied = pair.problem.force(state.at, Role.INTERACTION), contact.pressures(positions)
    far = np.setdiff1d(np.arange(len(pair.contact.multipliers)), contact.rows)
    pair.contact.multipliers[far] = 0
    gap, energy = pair.contact.update_multipliers(contact, positions, NOTHING)
    np.testing.assert_allclose(pair.contact.multipliers[contact.rows], applied, rtol=1e-14)
    changed = (applied - contact.pressure) / contact.stiffness
    assert gap == pytest.approx(np.abs(changed).max(), rel=1e-12)
    assert energy == pytest.approx((contact.stiffness * contact.weight * changed**2).sum() / 2, rel=1e-12)
    # Penalty terms add as much again, with the overlaps that are still there.
    harder = pair.problem.force(pair.problem.at(state.displacement).at, Role.INTERACTION)
    assert np.abs(harder).sum() > np.abs(force).sum()


def test_only_penalty_terms_that_miss_most_are_stiffened():
    pair, _, contact, positions = pressed_pair(2)
    pair.contact.update_multipliers(contact, positions, NOTHING)
    missed = np.abs(contact.pressures(positions) - contact.pressure) / contact.stiffness
    pair.contact.increase_penalty()
    stiffened = pair.contact.pair(positions).stiffness / contact.stiffness
    np.testing.assert_allclose(stiffened, np.where(missed > missed.max() / 10, 10.0, 1.0), rtol=1e-12)
    assert set(np.round(stiffened)) == {1, 10}


def test_multipliers_that_are_foreseen_are_those_of_the_gaps_that_they_lower():
    pair, state, contact, _ = pressed_pair(2)
    before, line = pair.contact.multipliers.copy(), pair.problem.linearise(state)
    assert line.lowered is not None
    pair.problem.take_multipliers(line.keys, 2 * line.lowered)
    others = np.setdiff1d(np.arange(len(before)), contact.rows)
    np.testing.assert_allclose(pair.contact.multipliers[contact.rows], 2 * before[contact.rows], rtol=1e-12)
    np.testing.assert_array_equal(pair.contact.multipliers[others], before[others])
    again = pair.problem.linearise(pair.problem.at(state.displacement))
    np.testing.assert_allclose(again.gap, line.gap - line.lowered, atol=1e-15)


@pytest.mark.parametrize("stiff", [10, 1000])
@pytest.mark.parametrize("order", ORDERS)
def test_multipliers_begin_with_the_forces_of_a_penalty(order, stiff):
    """Among them those at corners, which no function of the pressure represents."""
    pair = cells(order)
    at = pair.state(0.003, 0.8).displacement
    positions = pair.tissue.positions(at)
    penalty = PenaltyContact(pair.tissue.walls, stiff * pair.contact.stiffness, reach=2 * LONGEST_STEP)
    forces = nodal_forces(penalty.pair(positions), positions)
    pair.contact.follow(penalty, positions)
    contact = pair.contact.pair(positions)
    _, jacobian, _ = contact.penalty_terms(positions)
    assert (contact.pressure >= 0).all() and (contact.pressure[contact.rows >= pair.contact.space.size] > 0).any()
    begun = jacobian.T @ (contact.weight * contact.pressure)
    assert np.linalg.norm(begun - forces) < 0.05 * np.linalg.norm(forces)


def test_pressures_alike_are_least_squares_without_tension():
    random = np.random.default_rng(3)
    pulled, forces = random.standard_normal((30, 12)), random.standard_normal(30)
    found = pressures_alike(sparse.csc_array(pulled), forces)
    expected, _ = optimize.nnls(pulled, forces)
    assert (expected == 0).any() and (expected > 0).any()
    np.testing.assert_allclose(found, expected, atol=1e-3 * expected.max())


@pytest.mark.parametrize("order", ORDERS)
def test_contact_forces_of_the_points_are_the_forces_without_the_cuts(order):
    pair, state, contact, positions = pressed_pair(order)
    gap, slopes = contact.kinematics.slopes(positions)
    applied = contact.kinematics.jacobian(slopes, positions.shape[1]).T @ -contact.contact_forces(positions)
    weight = contact.weight * contact.pressures(positions)
    ends = contact.cuts.jacobian(gap, slopes, positions).T @ -weight
    np.testing.assert_allclose(applied + ends, pair.problem.force(state.at, Role.INTERACTION), atol=1e-12)


def pressures_of_a_flat_overlap(order: int) -> tuple[Stack, np.ndarray, np.ndarray, float]:
    """Pressures at all quadrature points, which of these lie between the blocks, and those of the penalty terms."""
    stack = blocks((0.3, 0.17), order=order)
    contact, positions = stack.contact, stack.positions(stack.upper_moved((0.0, -1e-3)))
    points = stack.walls.quadrature
    place = stack.walls.places(points.facet, points.xi, stack.walls.rest)
    stiffness = contact.stiffness[stack.walls.body == int(np.argmin(contact._rank))][0]
    return stack, contact.pressures(positions, points), np.abs(place[:, 1] - 0.5) < 1e-12, 1e-3 * stiffness


@pytest.mark.parametrize("order", ORDERS)
def test_the_pressure_of_a_pair_is_the_same_on_both_its_walls(order):
    """A uniform gap is one of the space, so a uniform pressure comes out of it."""
    stack, pressure, between, applied = pressures_of_a_flat_overlap(order)
    points = stack.walls.quadrature
    inside = between & (np.abs(stack.walls.places(points.facet, points.xi, stack.walls.rest)[:, 0]) < 0.49)
    assert set(stack.walls.body[points.facet[inside]]) == {0, 1}
    np.testing.assert_allclose(pressure[inside], applied, rtol=1e-9)
    assert (pressure >= 0).all()


def test_sides_that_stand_flush_bear_no_pressure():
    _, pressure, between, _ = pressures_of_a_flat_overlap(2)
    assert pressure[~between].max() == 0


def test_a_sliver_determines_no_multiplier():
    """A wall that slides on covers less and less of what its last functions act on."""
    pair = cells(3)
    options = pair.contact._options
    for aside, slivers in ((0.2, 0), (0.9, 1), (0.97, 1)):
        state = pair.state(0.01, aside)
        found = contact_set(pair.problem, state)
        functions = pair.along_walls(state)
        covered = found.average.sum(1) >= options.covered
        assert (~covered[functions]).sum() == slivers and covered[~functions].all()
        np.testing.assert_array_equal(np.isnan(found.lowered), ~covered)
        assert (found.pressures(state.at.positions)[~covered] > 0).all()  # they are pressed, as penalty terms
        pair.problem.update_multipliers(state)
        multipliers = pair.contact.multipliers[found.rows]
        assert (multipliers[~covered] == 0).all() and (multipliers[functions & covered] > 0).all()
