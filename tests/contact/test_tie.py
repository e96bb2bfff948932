"""The tied solid: one body without a gap, at every order, bubbles of odd order included."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.problem.problem import Problem
from ngcell.problem.tie import coincident_facets
from ngcell.solve.minimum import Ending
from ngcell.solve.proximal import ProximalTerm
from tests.tissues import SmallTissue, small_tissue, whole_tangent

ORDERS = [1, 2, 3, 4]


def largest_jump(tissue: SmallTissue, displacement: np.ndarray) -> float:
    """Largest distance between coincident points of two bodies."""
    one, two = coincident_facets(tissue.walls).T
    nodes = tissue.walls.nodes(displacement.reshape(2, -1))
    return float(np.abs(nodes[one] - nodes[two][:, ::-1]).max())


def floating(tissue: SmallTissue) -> Problem:
    return Problem(tissue.space, [tissue.bulk], np.zeros((2, tissue.space.size), dtype=bool), tie=tissue.tie)


@pytest.mark.parametrize("order", ORDERS)
def test_every_facing_edge_is_tied(order):
    tissue = small_tissue(2, 3, order=order, edges=3)
    pairs = 2 * 2 + 1 * (2 * 3 - 1)
    assert len(coincident_facets(tissue.walls)) == 3 * pairs


@pytest.mark.parametrize("order", ORDERS)
def test_tied_fields_have_no_jump_whatever_the_unknowns(order):
    tissue = small_tissue(2, 2, order=order)
    free = np.random.default_rng(1).standard_normal(tissue.space.unknowns)
    assert largest_jump(tissue, free) > 0.1
    assert largest_jump(tissue, tissue.tied.expand(free)) < 1e-12


@pytest.mark.parametrize("order", ORDERS)
def test_affine_fields_pass_the_tie_unchanged(order):
    tissue = small_tissue(2, 3, order=order)
    gradient = np.array([[0.2, -0.3], [0.5, 0.1]])
    field = tissue.space.affine(gradient, np.array([1.0, 2.0])).ravel()
    np.testing.assert_allclose(tissue.tied.expand(field), field, atol=1e-13)


@pytest.mark.parametrize("order", ORDERS)
def test_the_tied_solid_has_three_rigid_motions_and_no_other_mechanism(order):
    tissue = small_tissue(2, 2, order=order, edges=1)
    problem = floating(tissue)
    state = problem.at(np.zeros(tissue.space.unknowns))
    matrix = whole_tangent(problem, problem.linearise(state)).toarray()[np.ix_(problem.free, problem.free)]
    values = np.linalg.eigvalsh(matrix)
    assert np.abs(values[:3]).max() < 1e-12 * values[-1]
    assert values[3] > 1e-7 * values[-1]
    turned = np.concatenate([-tissue.space.rest[1], tissue.space.rest[0]])[problem.free]
    assert np.linalg.norm(matrix @ turned) < 1e-11 * values[-1] * np.linalg.norm(turned)


@pytest.mark.parametrize("order", ORDERS)
def test_expanding_and_gathering_are_adjoint(order):
    tissue = small_tissue(2, 2, order=order)
    random = np.random.default_rng(2)
    force, motion = random.standard_normal((2, tissue.space.unknowns))
    problem = tissue.tied
    assert force @ problem.expand(motion) == pytest.approx(problem.unknowns.gather(force) @ motion, rel=1e-12)


@pytest.mark.parametrize("order", [1, 3])
def test_forces_and_tangent_of_the_tied_solid_are_derivatives_of_its_energy(order):
    tissue = small_tissue(2, 2, order=order, edges=1)
    problem, step = floating(tissue), 1e-5
    at, way = tissue.smooth(0.05, 1), tissue.smooth(1.0, 2)
    at, way = (problem.expand(field) * problem.free for field in (at, way))
    after, before, state = (problem.at(at + size * way) for size in (step, -step, 0))
    force = problem.gradient(state)
    assert (after.energy - before.energy) / (2 * step) == pytest.approx(force @ way, rel=1e-6)
    bent = whole_tangent(problem, problem.linearise(state)) @ way
    change = (problem.gradient(after) - problem.gradient(before)) / (2 * step)
    np.testing.assert_allclose(change, bent, atol=1e-6 * np.abs(bent).max())


@pytest.mark.parametrize("order", ORDERS)
def test_the_solved_tied_solid_has_no_jump_and_is_in_balance_between_the_plates(order):
    tissue = small_tissue(2, 2, order=order, edges=1, prescribed_displacement=(0.3, 0.0))
    problem = tissue.tied
    start = tissue.motion.lifting(1.0)
    minimum = tissue.minimiser(problem).minimise(start, ProximalTerm(0.0, start))
    assert minimum.ending is Ending.CONVERGED
    displacement = problem.expand(minimum.state.displacement)
    assert largest_jump(tissue, displacement) < 1e-12
    force = problem.gradient(minimum.state)
    assert np.abs(force[problem.free]).max() < 1e-8
    assert tissue.motion.resultant(tissue.bulk.form.gradient(displacement), "high")[0] > 0
    held = problem.unknowns.reactions(tissue.bulk.form.gradient(displacement)).reshape(2, -1)
    np.testing.assert_allclose(held @ tissue.space.one, 0, atol=1e-9)


def test_nothing_is_tied_in_a_single_cell_and_rounded_corners_stay_free():
    alone = small_tissue(1, 1)
    np.testing.assert_array_equal(alone.tie.master, np.arange(alone.space.size))
    sharp, rounded = small_tissue(1, 2, order=1), small_tissue(1, 2, order=1, radius=0.2)
    for tissue in (sharp, rounded):
        assert np.count_nonzero(tissue.tie.master != np.arange(tissue.space.size)) == 3
