"""Matrices from which unknowns within elements are eliminated, and with room for closed walls only, against dense ones.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from ngcell.solve.cliques import find_cliques
from ngcell.solve.condensed import CondensedMatrix
from ngcell.solve.growing import GrowingMatrix
from ngcell.solve.inner import minimise_one_sided
from ngcell.solve.linear import SymmetricMatrix
from ngcell.solve.one_sided import OneSidedModel
from ngcell.solve.options import InnerOptions
from ngcell.solve.stiffness import Stiffness, lower_entries

NOBODY = np.zeros(0, dtype=np.int64)


class Chain:
    """Elements of six unknowns in a row: the first and last two are shared with the neighbours, two are of its own.

    Penalty terms couple unknowns that are shared; some of these are held.
    """

    def __init__(self, seed: int, elements: int = 7) -> None:
        self.random = random = np.random.default_rng(seed)
        self.size = 4 * elements + 2
        self.own = np.concatenate([4 * np.arange(elements) + 2, 4 * np.arange(elements) + 3])
        self.shared = np.setdiff1d(np.arange(self.size), self.own)
        self.full = np.zeros((self.size, self.size))
        for first in 4 * np.arange(elements):
            root = random.standard_normal((6, 6))
            self.full[first : first + 6, first : first + 6] += root @ root.T + 0.1 * np.eye(6)
        self.free = np.ones(self.size, dtype=bool)
        self.free[[0, 1, 4]] = False
        self.rows, self.columns = np.nonzero(np.tril(self.full))
        self.jacobian = self.terms(12, self.shared)
        self.penalty, self.gap = 1e3 * random.uniform(0.5, 2, 12), random.uniform(-0.3, 0.3, 12)
        self.moving = sparse.csr_array((self.size, self.size))

    def terms(self, count: int, touched: np.ndarray) -> sparse.csr_array:
        """Derivatives of gaps by four unknowns each."""
        jacobian = np.zeros((count, self.size))
        for row in jacobian:
            row[self.random.choice(touched, 4, replace=False)] = self.random.standard_normal(4)
        return sparse.csr_array(jacobian)

    def condensed(self, touched: np.ndarray = NOBODY, near: float = 0.1) -> tuple[CondensedMatrix, Stiffness]:
        matrix = CondensedMatrix(self.size, self.free, self.rows, self.columns, touched, near)
        values = np.zeros(matrix.entry_count)
        values[matrix.locate(self.rows, self.columns)] = self.full[self.rows, self.columns]
        return matrix, Stiffness(values, self.moving)

    def solution(self, right: np.ndarray, jacobian: sparse.csr_array, penalty: np.ndarray) -> np.ndarray:
        full = self.full + self.moving.toarray() + jacobian.toarray().T @ np.diag(penalty) @ jacobian.toarray()
        solution = np.zeros(self.size)
        solution[self.free] = np.linalg.solve(full[np.ix_(self.free, self.free)], right[self.free])
        return solution

    @property
    def model(self) -> OneSidedModel:
        gradient = np.where(self.free, self.random.standard_normal(self.size), 0.0)
        stiffness = self.condensed()[1]
        return OneSidedModel(gradient, stiffness, self.gap, self.jacobian, self.penalty, self.free)


def eliminated(matrix: CondensedMatrix) -> np.ndarray:
    return np.sort(np.concatenate([cliques.inside.ravel() for cliques in matrix._elimination.cliques]))


def test_what_is_eliminated_is_what_no_other_element_knows():
    chain = Chain(0)
    matrix, _ = chain.condensed(touched=chain.shared)
    np.testing.assert_array_equal(eliminated(matrix), np.sort(chain.own))
    # The last end of the row is known by one element only; the first one is held.
    np.testing.assert_array_equal(
        eliminated(chain.condensed()[0]), np.union1d(chain.own, [chain.size - 2, chain.size - 1])
    )


def test_cliques_tell_where_their_entries_stand():
    chain = Chain(1)
    matrix = SymmetricMatrix(chain.size, chain.free, chain.rows, chain.columns)
    lower = matrix.lower_pattern
    values = np.zeros(matrix.entry_count)
    values[matrix.locate(chain.rows, chain.columns)] = chain.full[chain.rows, chain.columns]
    found = find_cliques(lower, np.ones(chain.size, dtype=bool))
    assert sum(len(cliques.inside) for cliques in found) == 7
    for cliques in found:
        for inside, around, among, between in zip(
            cliques.inside, cliques.around, cliques.among, cliques.between, strict=True
        ):
            np.testing.assert_array_equal(values[among], chain.full[np.ix_(inside, inside)])
            np.testing.assert_array_equal(values[between], chain.full[np.ix_(inside, around)])
            outside = np.setdiff1d(np.arange(chain.size), np.concatenate([inside, around]))
            assert not chain.full[np.ix_(inside, outside)].any()
            assert (chain.full[np.ix_(around, around)] != 0).all()


def test_what_may_not_be_eliminated_is_around_its_clique():
    """One unknown inside each element is kept: the other one still is eliminated."""
    chain = Chain(2)
    matrix, _ = chain.condensed(touched=np.union1d(chain.shared, chain.own[:7]))
    np.testing.assert_array_equal(eliminated(matrix), chain.own[7:])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("is_curved", [False, True])
def test_solving_gives_the_dense_solution_in_free_rows_and_zero_elsewhere(seed, is_curved):
    chain = Chain(seed)
    if is_curved:
        bent = chain.terms(3, chain.shared)
        chain.moving = 0.01 * (bent.T @ bent).tocsr()
    matrix, stiffness = chain.condensed(touched=chain.shared)
    right = chain.random.standard_normal(chain.size)
    for closed in ([0, 1, 2], [0, 1], [0, 5, 7, 11], []):  # the third has no room in the pattern of the first
        jacobian, penalty = chain.jacobian[closed], chain.penalty[closed]
        matrix.factorise(stiffness, jacobian, penalty)
        np.testing.assert_allclose(matrix.solve(right), chain.solution(right, jacobian, penalty), atol=1e-9)
    full = chain.full + chain.moving.toarray()
    np.testing.assert_allclose(matrix.multiply(stiffness, right), full @ right, atol=1e-11)


@pytest.mark.parametrize("seed", range(3))
def test_elements_that_hardly_change_their_volume_lose_no_more_digits_than_in_one_piece(seed):
    """One mode of each element is 1e9 times as stiff as the rest: products with inverses would lose all digits."""
    chain = Chain(seed)
    for first in 4 * np.arange(7):
        stiff = chain.random.standard_normal((6, 1))
        chain.full[first : first + 6, first : first + 6] += 1e9 * stiff @ stiff.T
    matrix, stiffness = chain.condensed(touched=chain.shared)
    whole = GrowingMatrix(chain.size, chain.free, chain.rows, chain.columns)
    right = chain.random.standard_normal(chain.size)
    expected = chain.solution(right, chain.jacobian[:0], chain.penalty[:0])
    energy, away = right @ expected, []
    for one in (matrix, whole):
        one.factorise(stiffness, chain.jacobian[:0], chain.penalty[:0])
        found = one.solve(right) - expected
        away.append(abs(found @ chain.full @ found) / energy)
    assert away[0] <= max(10 * away[1], 1e-12)


@pytest.mark.parametrize("is_curved", [False, True])
def test_unknowns_that_contact_touches_after_all_are_kept_from_then_on(is_curved):
    chain = Chain(4)
    matrix, stiffness = chain.condensed()
    within = chain.terms(2, chain.own)
    if is_curved:
        chain.moving = 0.01 * (within.T @ within).tocsr()
        stiffness = replace(stiffness, moving=chain.moving)
    jacobian = chain.jacobian[:2] if is_curved else within
    right = chain.random.standard_normal(chain.size)
    matrix.factorise(stiffness, jacobian, chain.penalty[:2])
    np.testing.assert_allclose(matrix.solve(right), chain.solution(right, jacobian, chain.penalty[:2]), atol=1e-9)
    touched = np.unique(within.indices)
    assert not np.isin(touched, eliminated(matrix)).any()
    matrix.forget()
    np.testing.assert_array_equal(eliminated(matrix), eliminated(chain.condensed()[0]))


@pytest.mark.parametrize("seed", range(4))
def test_a_model_has_the_same_minimum_with_and_without_the_unknowns_within_elements(seed):
    chain = Chain(seed)
    matrix, _ = chain.condensed()
    whole = GrowingMatrix(chain.size, chain.free, chain.rows, chain.columns)
    model, options = chain.model, InnerOptions(most_rounds=50, worthwhile_gain=0.0)
    found = minimise_one_sided(model, matrix, options)
    step, change = found.step, found.change
    beside = minimise_one_sided(model, whole, options)
    same, same_change = beside.step, beside.change
    np.testing.assert_allclose(step, same, atol=1e-9)
    assert change == pytest.approx(same_change, rel=1e-9)
    assert change == pytest.approx(
        model.change(step, whole.multiply(model.stiffness, step), model.jacobian @ step), rel=1e-9
    )


def test_stopped_early_the_change_is_that_of_the_step():
    chain = Chain(5)
    matrix, _ = chain.condensed()
    model = chain.model
    found = minimise_one_sided(model, matrix, InnerOptions(most_rounds=1))
    step, change = found.step, found.change
    expected = model.change(step, matrix.multiply(model.stiffness, step), model.jacobian @ step)
    assert change == pytest.approx(expected, rel=1e-9)


def test_an_element_without_stiffness_leads_to_no_step_that_lowers_the_model():
    chain = Chain(6)
    matrix, stiffness = chain.condensed()
    none = replace(chain.model, stiffness=replace(stiffness, values=0 * stiffness.values))
    assert not minimise_one_sided(none, matrix, InnerOptions()).change <= 0


def test_there_is_room_for_walls_that_are_next_to_closing(monkeypatch):
    chain = Chain(7)
    matrix, stiffness = chain.condensed(near=0.1)
    made = []
    make = GrowingMatrix._with_room
    monkeypatch.setattr(GrowingMatrix, "_with_room", lambda *given: made.append(1) or make(*given))
    model = replace(chain.model, gap=np.array([-0.1, 0.05, *np.full(10, 1.0)]))
    matrix.reduced(model)
    for closed in ([0], [0, 1], [1], [0]):
        matrix.factorise(stiffness, chain.jacobian[closed], chain.penalty[closed])
    assert len(made) == 1
    matrix.factorise(stiffness, chain.jacobian[[0, 2]], chain.penalty[[0, 2]])
    assert len(made) == 2
    matrix.forget()
    matrix.factorise(stiffness, chain.jacobian[[0]], chain.penalty[[0]])
    assert len(made) == 3


def test_penalty_terms_are_added_to_what_moves_and_nothing_is_changed():
    random = np.random.default_rng(2)
    jacobian, penalty = sparse.csr_array(random.standard_normal((3, 6))), random.uniform(size=3)
    kept, moving = jacobian.copy(), sparse.csr_array(np.eye(6))
    full = jacobian.toarray().T @ np.diag(penalty) @ jacobian.toarray()
    np.testing.assert_allclose(Stiffness(np.ones(1)).with_penalty(jacobian, penalty).toarray(), full, atol=1e-13)
    np.testing.assert_allclose(
        Stiffness(np.ones(1), moving).with_penalty(jacobian, penalty).toarray(), full + np.eye(6), atol=1e-13
    )
    np.testing.assert_array_equal(jacobian.toarray(), kept.toarray())


def test_of_a_symmetric_matrix_each_pair_counts_once():
    row, column, data = lower_entries(sparse.csr_array(np.array([[1.0, 2.0], [2.0, 0.0]])))
    assert list(zip(row, column, data, strict=True)) == [(0, 0, 1.0), (1, 0, 2.0)]
