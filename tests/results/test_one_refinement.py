"""One refinement alone: a number that stays by accident is not told to be known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ngcell.results.gaps_of_pairs import GapsOfPairs
from ngcell.results.one_refinement import at_least


def gaps(*means: float, held: tuple[bool, ...] = (True, True, False)) -> GapsOfPairs:
    length = np.array([1.0, 2.0, 3.0])
    pairs = np.array([[0, 1], [1, 2], [2, 3]])
    return of_facets(pairs, held, length, np.repeat(length * np.array(means) / 2, 2))


def of_facets(pairs: np.ndarray, held: tuple[bool, ...], length: np.ndarray, integrals: np.ndarray) -> GapsOfPairs:
    """Gaps of walls of two facets each."""
    facet = np.column_stack([np.repeat(np.arange(len(pairs)), 2), np.arange(2 * len(pairs))])
    integral = integrals.reshape(-1, 2).sum(1)
    return GapsOfPairs(pairs, np.array(held), length, integral, integral / length, facet, integrals)


TOLD = {"potential": 0.02, "energy": 0.01, "plate_force": 0.001, "contact_force": 5.0, "mean_gap": 0.0}


def test_energies_and_forces_err_by_no_less_than_the_potential():
    new = at_least(TOLD, 2.0, {"plate_force": np.array([3.0, 4.0]), "contact_force": 10.0}, (None, None))
    assert new == TOLD | {"energy": 0.02, "plate_force": pytest.approx(0.05), "contact_force": 5.0}


def test_gaps_that_move_to_and_fro_are_not_known_by_their_mean():
    before, after = gaps(0.4, 0.3, 0.9), gaps(0.2, 0.4, 0.1)
    assert after.mean_and_largest(after.is_held)[0] == pytest.approx(before.mean_and_largest(after.is_held)[0])
    assert at_least(TOLD, 1.0, {}, (before, after))["mean_gap"] == pytest.approx((0.2 + 2 * 0.1) / 3)


def test_gaps_that_move_to_and_fro_along_a_wall_are_not_known_by_its_mean():
    """As those beside a contact zone that a coarse mesh widens on one side."""
    pair, length = np.array([[0, 1]]), np.array([2.0])
    before, after = (of_facets(pair, (True,), length, np.array(each)) for each in ([0.1, 0.3], [0.2, 0.2]))
    assert after.integral == pytest.approx(before.integral)
    assert after.moved_from(before) == pytest.approx(0.1)
    finer = replace(after, facet=after.facet + 1)  # other facets face each other
    assert finer.moved_from(before) == pytest.approx(0.0, abs=1e-15)


def test_nothing_is_told_of_gaps_of_other_pairs_or_of_none_held():
    after = gaps(0.2, 0.4, 0.1)
    other = replace(after, bodies=after.bodies + 1)
    assert after.moved_from(other) == 0
    assert gaps(1.0, 1.0, 1.0, held=(False,) * 3).moved_from(after) == 0
