"""The matrix with a lasting pattern, against dense linear algebra."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from ngcell import threads
from ngcell.solve import linear
from ngcell.solve.linear import PatternError, SymmetricMatrix


def random_system(size: int, seed: int) -> tuple[SymmetricMatrix, np.ndarray, np.ndarray, np.ndarray]:
    """A sparse positive definite matrix: as `SymmetricMatrix`, its values, in full, and its free rows."""
    random = np.random.default_rng(seed)
    full = sparse.random(size, size, density=0.2, random_state=random).toarray()
    full = full @ full.T + np.eye(size)
    rows, columns = np.nonzero(np.tril(full))
    free = random.uniform(size=size) < 0.7
    repeated = np.concatenate([np.arange(len(rows)), random.integers(len(rows), size=size)])
    matrix = SymmetricMatrix(size, free, rows[repeated], columns[repeated])
    values = np.zeros(matrix.entry_count)
    values[matrix.locate(rows, columns)] = full[rows, columns]
    return matrix, values, full, free


@pytest.mark.parametrize("seed", range(3))
def test_solving_gives_the_dense_solution_in_free_rows_and_zero_elsewhere(seed):
    matrix, values, full, free = random_system(40, seed)
    right = np.random.default_rng(seed).standard_normal(40)
    for factor in (1.0, 3.0):  # the second time the symbolic factor is used again
        matrix.factorise(factor * values)
        expected = np.zeros(40)
        expected[free] = np.linalg.solve(factor * full[np.ix_(free, free)], right[free])
        np.testing.assert_allclose(matrix.solve(right), expected, atol=1e-10)


def test_multiplying_uses_the_whole_symmetric_matrix_free_or_not():
    matrix, values, full, _ = random_system(40, 5)
    vector = np.random.default_rng(1).standard_normal(40)
    np.testing.assert_allclose(matrix.multiply(values, vector), full @ vector, atol=1e-11)


@pytest.mark.parametrize(("row", "column"), [(0, 1), (2, 1), (3, 0)])
def test_an_entry_outside_the_pattern_is_an_error(row, column):
    matrix = SymmetricMatrix(4, np.ones(4, bool), np.array([0, 1, 2, 3]), np.array([0, 1, 2, 3]))
    with pytest.raises(PatternError):
        matrix.locate(np.array([row]), np.array([column]))


def test_entries_are_found_some_at_a_time(monkeypatch):
    matrix, *_ = random_system(40, 2)
    row, column = matrix.entries
    monkeypatch.setattr(linear, "_AT_ONCE", 7)
    assert np.array_equal(matrix.locate(row, column), np.arange(matrix.entry_count))
    with pytest.raises(PatternError):
        matrix.locate(np.append(row, 0), np.append(column, 39))


@pytest.mark.parametrize(("fewest", "is_shared"), [(40, True), (41, False)])
def test_factors_of_many_rows_are_shared_among_threads(monkeypatch, fewest, is_shared):
    asked: list[int] = []
    set_threads = threads.ngsolve.SetNumThreads
    monkeypatch.setattr(threads.ngsolve, "SetNumThreads", lambda count: (asked.append(count), set_threads(count)))
    monkeypatch.setattr(threads, "_FEWEST_ROWS", fewest)
    matrix, values, full, free = random_system(40, 4)
    right = np.random.default_rng(0).standard_normal(40)
    expected = np.zeros(40)
    expected[free] = np.linalg.solve(full[np.ix_(free, free)], right[free])
    with threads.threads(2):
        for _ in range(2):
            matrix.factorise(values)
            np.testing.assert_allclose(matrix.solve(right), expected, atol=1e-10)
    assert (2 in asked) is is_shared and asked[-1] == 1


@pytest.mark.parametrize("seed", range(3))
def test_a_matrix_with_more_room_has_the_entries_of_both(seed):
    matrix, values, full, free = random_system(30, seed)
    random = np.random.default_rng(seed)
    column, row = np.sort(random.integers(30, size=(2, 40)), axis=0)
    grown, place = matrix.grown(row, column)
    rows, columns = (np.concatenate(part) for part in zip(matrix.entries, (row, column), strict=True))
    anew = SymmetricMatrix(30, free, rows, columns)
    for found, expected in zip(grown.entries, anew.entries, strict=True):
        assert np.array_equal(found, expected)
    assert np.array_equal(place, anew.locate(*matrix.entries))
    for one, position in ((anew, anew.locate(row, column)), (grown, grown.locate(row, column))):
        spread = np.zeros(one.entry_count)
        spread[place] = values
        spread[position] += np.where(row == column, 1.0, 0.0)
        one.factorise(spread)
    right = random.standard_normal(30)
    assert np.array_equal(grown.solve(right), anew.solve(right))
    np.testing.assert_allclose(grown.multiply(spread, right), anew.multiply(spread, right))
    assert grown.grown(row, column)[0].entry_count == grown.entry_count
