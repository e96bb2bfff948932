"""Bonds: the law, one energy with its forces and stiffness on both sides of each kink, and what history does to it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from ngcell.contact.cohesion.bonds import Bonds, bond_walls
from ngcell.contact.cohesion.exponential import Cohesion
from ngcell.contact.methods.terms import CohesionTerm, ContactTerm
from ngcell.problem.problem import Problem
from tests.contact.derivatives import assert_derivatives, smooth_step
from tests.contact.stacks import blocks
from tests.tissues import SmallTissue, rotation, small_tissue

STRENGTH, ENERGY = 0.3, 0.02
LAW = Cohesion(strength=STRENGTH, energy=ENERGY)


def bonded(tissue: SmallTissue) -> tuple[Problem, Bonds]:
    bonds = bond_walls(tissue.walls, LAW)
    terms = [tissue.bulk, ContactTerm(tissue.contact), CohesionTerm(bonds)]
    return Problem(tissue.space, terms, tissue.motion.fixed), bonds


def moved(tissue: SmallTissue, depth: float, correction: float, amplitude: float = 0.02) -> np.ndarray:
    """Bent walls, the right cell pressed in by `depth` and along by `slide`."""
    return tissue.smooth(amplitude, 3) + tissue.body_translation(1, np.array([-depth, correction]))


def test_the_law_has_its_strength_and_its_energy():
    openings = np.linspace(0, 20 * LAW.peak, 200_001)
    traction = LAW.traction(openings)
    assert traction.max() == pytest.approx(STRENGTH, rel=1e-9)
    assert openings[traction.argmax()] == pytest.approx(LAW.peak, rel=1e-3)
    for end in (0.5, 1.0, 3.0):
        work, _ = quad(lambda opening: float(LAW.traction(np.array(opening))), 0, end * LAW.peak)
        assert float(LAW.work(np.array(end * LAW.peak))) == pytest.approx(work, rel=1e-9)
    assert float(LAW.work(np.array(40 * LAW.peak))) == pytest.approx(ENERGY, rel=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("depth", [-0.04, 0.01], ids=["open", "pressed"])
@pytest.mark.parametrize("correction", [0.0, 0.05])
@pytest.mark.parametrize("before", [0.0, 0.5, 2.0], ids=["loading", "mixed", "unloading"])
def test_forces_and_tangent_are_derivatives_of_one_energy(order, depth, correction, before):
    """Both sides of both kinks: walls apart and pressed, bonds that open further and that have been opened more."""
    tissue = small_tissue(1, 2, order=order)
    problem, bonds = bonded(tissue)
    at = moved(tissue, depth, correction)
    bonds.largest = before * np.median(bonds.openings(tissue.positions(at))) * np.ones_like(bonds.largest)
    heights = bonds.kinematics.gaps(tissue.positions(at))
    assert (heights > 0).any() if depth < 0 else (heights < 0).any()
    way = tissue.smooth(1.0, 8)
    assert_derivatives(problem, at, way, smooth_step(problem, bonds, at, way), rel=2e-7)


def test_rest_has_no_force_and_the_stiffness_of_whole_bonds():
    tissue = small_tissue(1, 2)
    problem, bonds = bonded(tissue)
    rest = tissue.space.rest
    assert bonds.energy(rest) == pytest.approx(0, abs=1e-20)
    assert np.abs(bonds.gradient(rest)).max() < 1e-12
    translation = tissue.body_translation(1, np.array([0.0, 1.0]))  # along the wall, of length 1
    assert translation @ (bonds.tangent(rest) @ translation) == pytest.approx(LAW.stiffness_at_rest, rel=1e-9)


def test_a_rigid_motion_of_all_costs_nothing_and_turns_the_forces():
    tissue = small_tissue(1, 2, order=3)
    _, bonds = bonded(tissue)
    at, turn = tissue.positions(moved(tissue, -0.02, 0.03)), rotation(0.7)
    turned = turn @ at + np.array([[0.3], [-0.2]]) * tissue.space.one
    assert bonds.energy(turned) == pytest.approx(bonds.energy(at), rel=1e-12)
    force, force_turned = (bonds.gradient(place).reshape(2, -1) for place in (at, turned))
    np.testing.assert_allclose(force_turned, turn @ force, atol=1e-12)
    np.testing.assert_allclose(force @ tissue.space.one, 0, atol=1e-13)
    assert at[0] @ force[1] - at[1] @ force[0] == pytest.approx(0, abs=1e-12)


def test_pressed_walls_feel_no_bond():
    tissue = small_tissue(1, 2)
    _, bonds = bonded(tissue)
    positions = tissue.positions(tissue.body_translation(1, np.array([-0.01, 0.0])))
    assert bonds.energy(positions) == pytest.approx(0, abs=1e-15)
    assert np.abs(bonds.gradient(positions)).max() < 1e-12


def test_parting_costs_the_separation_energy_and_nothing_comes_back():
    tissue = small_tissue(1, 2)
    _, bonds = bonded(tissue)
    positions = [
        tissue.positions(tissue.body_translation(1, np.array([x, 0.0]))) for x in LAW.peak * np.array([2.0, 40.0])
    ]
    bonds.advance(positions[0])
    stored, spent = bonds.stored(positions[0]), bonds.spent(positions[0])
    assert stored + spent == pytest.approx(float(LAW.work(np.array(2 * LAW.peak))), rel=1e-9)
    assert bonds.stored(tissue.space.rest) == pytest.approx(0, abs=1e-20)
    assert bonds.spent(tissue.space.rest) == pytest.approx(spent, rel=1e-12)
    bonds.advance(positions[1])
    assert bonds.energy(positions[1]) == pytest.approx(ENERGY, rel=1e-12)
    assert np.abs(bonds.gradient(positions[0])).max() < 1e-12 * STRENGTH
    bonds.reset()
    assert bonds.spent(tissue.space.rest) < 1e-20


def test_unloading_follows_the_secant():
    tissue = small_tissue(1, 2)
    _, bonds = bonded(tissue)

    def pull(opening: float) -> float:
        force = bonds.gradient(tissue.positions(tissue.body_translation(1, np.array([opening, 0.0]))))
        return float(force @ tissue.body_translation(1, np.array([1.0, 0.0])))

    top = pull(1.5 * LAW.peak)
    bonds.advance(tissue.positions(tissue.body_translation(1, np.array([1.5 * LAW.peak, 0.0]))))
    assert top == pytest.approx(float(LAW.traction(np.array(1.5 * LAW.peak))), rel=1e-9)
    assert pull(0.5 * LAW.peak) == pytest.approx(top / 3, rel=1e-9)
    assert pull(1.5 * LAW.peak) == pytest.approx(top, rel=1e-12)
    assert pull(2.5 * LAW.peak) == pytest.approx(float(LAW.traction(np.array(2.5 * LAW.peak))), rel=1e-9)


def test_bonds_join_what_coincides_and_meshes_need_not_match():
    pile = blocks((0.3, 0.4), width=0.6)
    bonds = bond_walls(pile.walls, LAW)
    assert bonds.weight.sum() == pytest.approx(0.6, rel=1e-12)  # the upper block is narrower
    assert (bonds.bodies == [0, 1]).all()
    a, _ = bonds.kinematics.vectors(pile.space.rest)
    np.testing.assert_allclose(a, 0, atol=1e-12)
    lifted = pile.positions(pile.upper_moved((0.0, LAW.peak)))
    np.testing.assert_allclose(bonds.openings(lifted), LAW.peak, rtol=1e-9)
    np.testing.assert_allclose(bonds.kinematics.gaps(lifted), LAW.peak, rtol=1e-9)


def test_cells_of_a_tissue_are_bonded_along_their_common_walls():
    tissue = small_tissue(2, 2)
    bonds = bond_walls(tissue.walls, LAW)
    assert len(np.unique(bonds.bodies, axis=0)) == 5
    assert bonds.weight.sum() == pytest.approx(5.0, rel=1e-9)  # walls of length 1
