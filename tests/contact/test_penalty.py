"""The penalty energy: one energy with its forces and stiffness, on both sides of the kink."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.options import ContactOptions
from ngcell.contact.pairing.facing import find_facing
from ngcell.mechanics.stored import StoredEnergy
from ngcell.mechanics.term import Role
from ngcell.scene import Penalty
from tests.tissues import LAW, SmallTissue, contact_set, small_tissue, whole_tangent


def moved(tissue: SmallTissue, depth: float, amplitude: float = 0.02) -> np.ndarray:
    """Bent walls, the right cell pressed in by `depth` and along by 0.2."""
    return tissue.smooth(amplitude, 3) + tissue.body_translation(1, np.array([-depth, 0.2]))


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("depth", [-0.08, 0.01, 0.06])
def test_forces_and_tangent_are_derivatives_of_one_energy(order, depth):
    """Bulk and penalty terms together: at the first depth all walls are open, at the others not."""
    tissue = small_tissue(1, 2, order=order)
    problem, at = tissue.released, moved(tissue, depth)
    state = problem.at(at)
    gap, slopes, _ = contact_set(problem, state).penalty_terms(tissue.positions(at))
    assert len(gap) and (gap > 0).all() == (depth < 0)
    way = tissue.smooth(1.0, 8)
    step = min(1e-5, 0.5 * np.min(np.abs(gap) / np.abs(slopes @ way)))  # no wall closes or opens on the way
    after, before = problem.at(at + step * way), problem.at(at - step * way)
    force = problem.gradient(state)
    assert (after.energy - before.energy) / (2 * step) == pytest.approx(force @ way, rel=1e-7)
    bent = whole_tangent(problem, problem.linearise(state)) @ way
    change = (problem.gradient(after) - problem.gradient(before)) / (2 * step)
    np.testing.assert_allclose(change, bent, atol=1e-6 * np.abs(bent).max())


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("depth", [0.01, 0.06])
def test_contact_pairs_may_be_frozen_without_changing_the_forces(order, depth):
    tissue = small_tissue(1, 2, order=order)
    state, step = tissue.released.at(moved(tissue, depth)), 1e-5
    force, contact = tissue.released.force(state.at, Role.INTERACTION), contact_set(tissue.released, state)
    for seed in (8, 9):
        way = tissue.smooth(1.0, seed)
        after, before = (tissue.positions(state.displacement + size * way) for size in (step, -step))
        rise = contact.energy(after) - contact.energy(before)
        assert rise / (2 * step) == pytest.approx(force @ way, rel=1e-6)


def test_forces_vanish_when_the_walls_part_and_set_in_without_a_jump():
    tissue = small_tissue(1, 2)
    problem = tissue.released
    forces = []
    for depth in (-1e-3, -1e-9, 1e-9, 1e-6, 1e-3):
        state = problem.at(tissue.body_translation(1, np.array([-depth, 0.0])))
        forces.append(np.abs(problem.force(state.at, Role.INTERACTION)).sum())
    assert forces[0] == forces[1] == 0
    np.testing.assert_allclose(np.array(forces[2:]) / forces[-1], [1e-6, 1e-3, 1], rtol=0.05)


def test_forces_between_bodies_are_equal_and_opposite_and_drive_apart():
    tissue = small_tissue(1, 2, order=3)
    state = tissue.released.at(moved(tissue, 0.03))
    force = tissue.released.force(state.at, Role.INTERACTION).reshape(2, -1)
    x, y = tissue.positions(state.displacement)
    on_right = tissue.space.body_of_unknown == 1
    normal_force = (force * tissue.space.one)[:, on_right].sum(1)
    assert normal_force[0] < 0  # the gradient falls towards the right: the right cell is driven that way
    np.testing.assert_allclose(force @ tissue.space.one, 0, atol=1e-12)
    assert x @ force[1] - y @ force[0] == pytest.approx(0, abs=1e-11)


def test_pressures_integrate_to_the_force():
    tissue = small_tissue(1, 2, edges=4)
    positions = tissue.positions(tissue.body_translation(1, np.array([-0.002, 0.0])))
    contact = tissue.contact.pair(positions)
    kinematics = contact.kinematics
    pressure = 2 * contact.contact_forces(positions) / kinematics.pairs.weight
    on_left = tissue.walls.body[kinematics.pairs.primary] == 0
    total = (pressure * kinematics.pairs.weight)[on_left].sum()
    stiffness = LAW.plane_strain_modulus / tissue.walls.depth[0]
    assert pressure.max() == pytest.approx(stiffness * 0.002, rel=1e-9)
    assert total == pytest.approx(stiffness * 0.002, rel=0.01)  # a wall of length 1, its tips slightly less
    assert (pressure >= 0).all()


@pytest.mark.parametrize("order", [2, 3])
def test_exchanging_the_bodies_changes_nothing(order):
    tissue = small_tissue(1, 2, order=order)
    middle = tissue.lattice.centres.mean(0)
    x, y = ngsolve.x - middle[0], ngsolve.y - middle[1]
    soft_and_hard = np.where(tissue.walls.body == 0, 1.0, 7.0)

    def bend(sign: float) -> ngsolve.CF:
        """One body's displacement; seen from the other end of the tissue for sign -1."""
        a, b = sign * x, sign * y
        return sign * ngsolve.CF((0.04 - 0.05 * b * b + 0.02 * a * b, 0.1 + 0.1 * a - 0.05 * a * a))

    def normal_force(sign: float) -> ngsolve.CF:
        a, b = sign * x, sign * y
        return sign * ngsolve.CF((-0.03 * b + 0.02 * a * a, 0.05 * a * b))

    def energy(first: ngsolve.CF, second: ngsolve.CF, stiffness: np.ndarray) -> float:
        field = ngsolve.GridFunction(tissue.space.vector)
        field.Set(tissue.bodies.mesh.MaterialCF({"cell0": first, "cell1": second}))
        positions = tissue.positions(field.vec.FV().NumPy())
        contact = PenaltyContact(tissue.walls, stiffness, 0.2).pair(positions)
        return contact.energy(positions)

    one = energy(bend(1), normal_force(1), soft_and_hard)
    other = energy(normal_force(-1), bend(-1), 8.0 - soft_and_hard)
    assert one > 1e-5
    assert other == pytest.approx(one, rel=1e-9)


def test_a_pair_is_as_stiff_as_its_softer_body_and_proportional_to_the_multiple():
    tissue = small_tissue(1, 2)
    moduli = np.array([1.0, 50.0])
    positions = tissue.positions(tissue.body_translation(1, np.array([-0.01, 0.0])))

    def energy(of_body: np.ndarray, multiple: float) -> float:
        stiffness = penalty_stiffness(tissue.walls, of_body, multiple)
        return PenaltyContact(tissue.walls, stiffness, 0.1).pair(positions).energy(positions)

    assert energy(moduli, 1.0) == pytest.approx(energy(np.ones(2), 1.0), rel=1e-12)
    assert energy(moduli, 3.0) == pytest.approx(3 * energy(moduli, 1.0), rel=1e-12)


@pytest.mark.parametrize("radius", [0.0, 0.1])
@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_rigid_rotation_of_the_tissue_leaves_zero_stress_and_zero_gap(order, radius):
    tissue = small_tissue(3, 3, order=order, radius=radius)
    displacement = tissue.rigid_motion(1.0, (5.0, -2.0))
    at, positions = tissue.released.at(displacement), tissue.positions(displacement)
    facing = find_facing(tissue.walls, 1e-3)
    gaps = facing.gaps(tissue.walls, tissue.walls.nodes(positions))
    before = facing.gaps(tissue.walls, tissue.walls.rest)
    size = 12.0
    assert np.abs(gaps - before).max() < 1e-12
    assert np.abs(before).max() < 1e-12 or radius > 0
    assert contact_set(tissue.released, at).energy(positions) < 1e-26 * LAW.bulk_modulus * size**2
    # Energies are differences of numbers of order one: round-off leaves 1e-16 of the modulus, not its square.
    assert abs(tissue.bulk.form.energy(displacement)) < 1e-14 * LAW.shear_modulus * tissue.volume
    assert np.abs(tissue.released.gradient(at)).max() < 1e-11 * LAW.bulk_modulus
    deformation = ngsolve.Id(2) + ngsolve.Grad(tissue.space.function(displacement))
    places = tissue.lattice.centres + 0.9 * tissue.lattice.corners[0]
    points = [tissue.bodies.mesh(*place) for place in places]
    numbers = np.zeros((len(points), 3, 3)) + np.eye(3)
    numbers[:, :2, :2] = [np.reshape(deformation(point), (2, 2)) for point in points]
    assert np.abs(LAW.cauchy_stress(numbers)).max() < 1e-12 * LAW.bulk_modulus


def test_penalty_terms_that_took_over_from_softer_ones_stiffen_where_overlaps_are_too_deep():
    tissue = small_tissue(1, 2)
    meant = tissue.contact
    softer = PenaltyContact(meant.walls, meant.stiffness / 10, meant.reach)
    thickness = float(meant.walls.thickness.min())
    derived, stored = meant.stiffness.copy(), StoredEnergy(lambda: (np.zeros(2), 1e9))

    def improved(depth: float) -> float:
        positions = tissue.positions(tissue.body_translation(1, np.array([-depth, 0.0])))
        return meant.update_multipliers(meant.pair(positions), positions, stored)[0]

    assert improved(0.03 * thickness) == 0  # nothing was softer than these
    at_rest = tissue.positions(tissue.body_translation(1, np.zeros(2)))
    meant.follow(softer, at_rest)
    assert improved(0.01 * thickness) == 0
    np.testing.assert_array_equal(meant.stiffness, derived)
    assert improved(0.03 * thickness) == pytest.approx(0.03 * thickness)
    np.testing.assert_allclose(meant.stiffness, 10 * derived)
    meant.follow(softer, at_rest)
    np.testing.assert_array_equal(meant.stiffness, derived)


def test_a_penalty_that_leads_to_multipliers_stiffens_where_it_stores_what_walls_gain_and_may_overlap():
    tissue = small_tissue(1, 2)
    walls, options = tissue.walls, ContactOptions().before_multipliers
    leads = PenaltyContact(walls, tissue.contact.stiffness, tissue.contact.reach, options=options)
    at = tissue.body_translation(1, np.array([-0.03 * float(walls.thickness.min()), 0.0]))
    positions = tissue.positions(at)
    contact = leads.pair(positions)

    def is_too_soft(share: float) -> bool:
        """Whether it is where penalty terms store this share of the energy."""
        mine = contact.energy(positions)
        stored = StoredEnergy(lambda: (np.full(2, mine * (1 / share - 1) / 2), 0.0))
        return leads.update_multipliers(contact, positions, stored)[0] > 0

    leads.follow(leads, positions)
    assert not is_too_soft(0.05)
    assert leads.raised == 1
    assert is_too_soft(0.2)
    assert leads.raised == 10


@pytest.mark.parametrize(("elsewhere", "raised"), [(10.0, 10.0), (1e4, 1.0)])
def test_bodies_that_hardly_store_anything_beside_others_are_not_made_stiffer(elsewhere: float, raised: float):
    """Two cells of three store nothing but their overlap, as loose ones do, and the third so many times as much."""
    tissue = small_tissue(1, 3)
    walls = tissue.walls
    mine = PenaltyContact(walls, tissue.contact.stiffness, tissue.contact.reach)
    depth = 1e-3 * float(walls.thickness.min())
    positions = tissue.positions(tissue.body_translation(0, np.array([depth, 0.0])))
    mine.restart()
    contact = mine.pair(positions)
    stored = StoredEnergy(lambda: (np.array([0.0, 0.0, elsewhere * contact.energy(positions)]), 0.0))
    mine.update_multipliers(contact, positions, stored)
    assert mine.raised == raised


@pytest.mark.parametrize("stiffness", [0.01, 0.1, 1.0])
def test_penalty_terms_of_any_stiffness_take_over_from_ones_that_follow_the_path(stiffness):
    """Else those that a case asks for would not stiffen where they are too soft for a continuation's."""
    walls = small_tissue(1, 2, order=1).walls
    moduli = np.ones(int(walls.body.max()) + 1)
    assert len(Penalty(stiffness=stiffness).stages(walls, moduli, reach=0.1)) > 1


def test_what_a_path_has_adapted_is_remembered_and_taken_up_again():
    tissue = small_tissue(1, 2)
    mine, other = (PenaltyContact(tissue.walls, tissue.contact.stiffness, 0.1) for _ in range(2))
    thickness, stored = float(mine.walls.thickness.min()), StoredEnergy(lambda: (np.zeros(2), 1e9))
    positions = tissue.positions(tissue.body_translation(1, np.array([-0.03 * thickness, 0.0])))
    assert mine.memory() == {}  # penalty terms that do not adapt have nothing to remember
    mine.restart(early=True)
    assert mine.update_multipliers(mine.pair(positions), positions, stored)[0] > 0
    other.recall(mine.memory())
    assert other.raised == mine.raised == 10
    assert other.pair(positions).energy(positions) == mine.pair(positions).energy(positions)
    assert other.update_multipliers(other.pair(positions), positions, stored)[0] > 0  # and goes on to adapt
    assert mine.raised == 10
