"""A tie is a map of unknowns: what is solved for stands for what is tied to it, in values, forces and matrices."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy import sparse

from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.problem.problem import Problem
from ngcell.problem.unknowns import OwnUnknowns, TiedUnknowns
from ngcell.scene import Pressure
from ngcell.solve.minimum import Ending
from ngcell.solve.proximal import ProximalTerm
from tests.mechanics.test_fluid import fluids
from tests.problem.test_sum import Floor, Link, smooth_step
from tests.tissues import SmallTissue, small_tissue, whole_tangent

ORDERS = [1, 2, 3]


@cache
def tissue_of(order: int) -> SmallTissue:
    """Four cells; three meet at a corner, and odd bubbles change their sign from one wall to the other."""
    return small_tissue(2, 2, order=order, edges=1)


def tied(order: int) -> TiedUnknowns:
    tissue = tissue_of(order)
    return TiedUnknowns(tissue.tie, tissue.space, tissue.motion.fixed.ravel())


def spread(order: int) -> np.ndarray:
    """The map as a matrix, column by column."""
    unknowns = tied(order)
    return np.stack([unknowns.expand(column) for column in np.eye(tissue_of(order).space.unknowns)], axis=1)


@pytest.mark.parametrize("order", ORDERS)
def test_expanding_is_a_projection_that_keeps_masters(order):
    unknowns, values = tied(order), np.random.default_rng(1).standard_normal(tissue_of(order).space.unknowns)
    full = unknowns.expand(values)
    np.testing.assert_array_equal(unknowns.expand(full), full)
    np.testing.assert_array_equal(full[unknowns.free], values[unknowns.free])
    assert (full != values).any()
    assert not unknowns.lets_bodies_part


@pytest.mark.parametrize("order", ORDERS)
def test_forces_are_gathered_by_the_transpose_of_the_map(order):
    force = np.random.default_rng(2).standard_normal(tissue_of(order).space.unknowns)
    np.testing.assert_allclose(tied(order).gather(force), spread(order).T @ force, atol=1e-13)


@pytest.mark.parametrize("order", ORDERS)
def test_matrices_are_folded_by_the_map_from_both_sides(order):
    size = tissue_of(order).space.unknowns
    full = sparse.random_array((size, size), density=0.1, rng=np.random.default_rng(3)).toarray()
    full = full + full.T
    expected = spread(order).T @ full @ spread(order)
    np.testing.assert_allclose(tied(order).fold_matrix(sparse.csr_array(full)).toarray(), expected, atol=1e-12)
    row, column = np.nonzero(np.tril(full))
    folded_row, folded_column, factors = tied(order).fold(row, column)
    assert (folded_row >= folded_column).all()
    lower = np.zeros_like(full)
    np.add.at(lower, (folded_row, folded_column), factors * full[row, column])
    np.testing.assert_allclose(lower, np.tril(expected), atol=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_what_is_held_is_not_free_nor_is_what_follows_it(order):
    tissue, unknowns = tissue_of(order), tied(order)
    fixed, matrix = tissue.motion.fixed.ravel(), spread(order)
    assert fixed.any()
    assert not unknowns.free[fixed].any()
    masters = np.flatnonzero(unknowns.free)
    assert not (matrix[fixed][:, masters] != 0).any()  # no free unknown moves a held one
    followers = np.flatnonzero((matrix != 0).argmax(1) != np.arange(len(fixed)))
    assert len(followers) and not unknowns.free[followers].any()
    everything = set(np.flatnonzero((matrix[:, masters] != 0).any(1)))
    held = set(np.flatnonzero((matrix[:, (matrix[fixed] != 0).any(0)] != 0).any(1)))
    assert everything | held == set(range(len(fixed))) and not everything & held


@pytest.mark.parametrize("order", ORDERS)
def test_each_held_group_is_borne_once_by_one_of_its_held_members(order):
    tissue, unknowns = tissue_of(order), tied(order)
    fixed, force = tissue.motion.fixed.ravel(), np.random.default_rng(4).standard_normal(tissue.space.unknowns)
    reaction = unknowns.reactions(force)
    assert not reaction[~fixed].any()
    gathered = unknowns.gather(force)
    masters = np.unique(np.abs(spread(order)[fixed]).argmax(1))
    np.testing.assert_allclose(unknowns.gather(reaction)[masters], gathered[masters], atol=1e-13)
    assert np.count_nonzero(reaction) == len(masters)


def test_unknowns_that_stand_for_themselves_are_left_as_they_are():
    fixed, values = np.array([True, False, False]), np.array([1.0, -2.0, 3.0])
    own = OwnUnknowns(fixed)
    assert own.lets_bodies_part
    np.testing.assert_array_equal(own.free, ~fixed)
    np.testing.assert_array_equal(own.expand(values), values)
    np.testing.assert_array_equal(own.gather(values), values)
    np.testing.assert_array_equal(own.reactions(values), [1.0, 0.0, 0.0])
    row, column, factors = own.fold(np.array([0, 2]), np.array([1, 2]))
    assert (row.tolist(), column.tolist(), factors) == ([1, 2], [0, 2], None)


#: Terms of a script that act on the tied solid as well.
OWN = {
    "nothing": lambda tissue: [],
    "open constraints": lambda tissue: [Floor(tissue.space, -5.0)],
    "closed constraints": lambda tissue: [Floor(tissue.space, 0.3)],
    "curvature": lambda tissue: [Link(tissue.space, followers(tissue)[[0, -1]])],
}


def followers(tissue: SmallTissue) -> np.ndarray:
    """Vertices that follow others."""
    return np.flatnonzero((tissue.tie.master != np.arange(tissue.space.size)) & (tissue.space.one > 0))


def problems(order: int, *more: object) -> tuple[Problem, Problem]:
    """Bodies under pressure and with fluids: as they are, and tied."""
    tissue = tissue_of(order)
    loads = AppliedLoads(tissue.space, [Pressure(boundary="lumen", value=0.2)], tissue.motion)
    loads.apply(1.0)
    fluid = fluids(tissue, fill=1.1)
    fluid.pressure = np.array([0.3, -0.2, 0.1, 0.05])
    terms, nowhere = [tissue.bulk, loads, fluid, *more], np.zeros((2, tissue.space.size), dtype=bool)
    return Problem(tissue.space, terms, nowhere), Problem(tissue.space, terms, nowhere, tie=tissue.tie)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", OWN)
def test_a_tied_problem_is_the_released_one_seen_through_the_map(order, name):
    tissue = tissue_of(order)
    apart, together = problems(order, *OWN[name](tissue))
    values, matrix = tissue.smooth(0.05, 1), spread(order)
    full = matrix @ values
    free, whole, state = together.free, apart.at(full), together.at(values)
    assert state.energy == pytest.approx(whole.energy, rel=1e-13)
    np.testing.assert_array_equal(state.at.displacement, full)
    force = matrix.T @ apart.gradient(whole)
    assert (whole.at.positions[1, tissue.space.one > 0] < 0.3).any()
    np.testing.assert_allclose(together.gradient(state)[free], force[free], atol=1e-12 * np.abs(force).max())
    expected = (matrix.T @ whole_tangent(apart, apart.linearise(whole)).toarray() @ matrix)[np.ix_(free, free)]
    found = whole_tangent(together, together.linearise(state)).toarray()[np.ix_(free, free)]
    np.testing.assert_allclose(found, expected, atol=1e-11 * np.abs(expected).max())
    model = together.linearise(state)
    whole_force = model.gradient + model.constraints.gradient
    np.testing.assert_allclose(whole_force[free], force[free], atol=1e-12 * np.abs(force).max())


@pytest.mark.parametrize("name", OWN)
def test_a_tied_solid_settles_under_own_terms(name):
    """Newton's method ends in balance, and the matrix has room for whatever terms couple."""
    tissue = tissue_of(1)
    _, together = problems(1, *OWN[name](tissue))
    start = together.free * tissue.smooth(0.01, 1)
    minimum = tissue.minimiser(together).minimise(start, ProximalTerm(1e-3, start))
    assert minimum.ending is Ending.CONVERGED
    left = together.gradient(minimum.state) + minimum.proximal.gradient(minimum.state.displacement, together.metric)
    assert np.abs(left[together.free]).max() < 1e-8


@pytest.mark.parametrize("order", ORDERS)
def test_forces_of_a_tied_problem_are_derivatives_along_what_is_solved_for(order):
    tissue = tissue_of(order)
    _, together = problems(order)
    at, way = tissue.smooth(0.05, 1), tissue.smooth(1.0, 2) * together.free
    step = smooth_step(together, at, way)
    rise = together.at(at + step * way).energy - together.at(at - step * way).energy
    assert rise / (2 * step) == pytest.approx(together.gradient(together.at(at)) @ way, rel=1e-6)
