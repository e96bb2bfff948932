"""Estimated errors: exact where numbers converge as they are taken to, and never told where they are not known."""

from __future__ import annotations

from math import inf, isnan

import numpy as np
import pytest

from ngcell.results.error import MOST_REMAINS, Errors, Numbers, estimate


def numbers(energy: float, force: float = 1.0, gap: float = 1.0, besides: float = 0.0) -> Numbers:
    return Numbers(energy, np.array([force, 0.0]), 1.0, gap, gap, (1e-9, 1e-9, 1e-9), besides)


def test_one_mesh_tells_nothing():
    errors = estimate([numbers(1.0)], 0.5)
    assert isnan(errors.energy) and errors.check(0.1).value == inf and not errors.check(0.1).passed


@pytest.mark.parametrize("share", [0.1, 0.3, 0.6])
def test_a_geometric_sequence_is_told_exactly(share: float):
    found = [numbers(2.0 + share**step) for step in range(3)]
    assert estimate(found, 0.01).energy == pytest.approx(share**2, rel=1e-12)
    assert estimate(found, 0.01, of_last=False).energy == pytest.approx(share, rel=1e-12)


def test_a_singularity_lets_remain_what_no_measured_share_may_belittle():
    # The coarsest mesh is far off for another reason: the second refinement changes a hundredth of the first.
    found = [numbers(11.0), numbers(1.0 + 0.1), numbers(1.0)]
    assert estimate(found, 0.5).energy == pytest.approx(0.1, rel=1e-12)
    assert estimate(found, 0.001).energy < 0.01


def test_what_does_not_converge_is_told_to_be_far_off():
    found = [numbers(1.0), numbers(1.1), numbers(1.3)]
    assert estimate(found, 0.1).energy == pytest.approx(0.2 * MOST_REMAINS / (1 - MOST_REMAINS), rel=1e-12)


def test_the_largest_relative_error_is_judged():
    found = [numbers(1.0, 1.0, 2.0), numbers(1.01, 1.1, 2.0)]
    errors = estimate(found, 0.5)
    assert errors.relative == pytest.approx(0.1 / 1.1, rel=1e-12)
    assert errors.check(0.1).passed and not errors.check(0.09).passed


def test_soft_contact_and_what_floats_add_to_the_error_of_the_energy():
    found = [numbers(1.0, besides=0.1), numbers(1.0, besides=0.02)]
    assert estimate(found, 0.5).energy == pytest.approx(0.02, rel=1e-12)


def test_errors_without_estimate_fail_the_check():
    assert not Errors().check(inf).value < inf
