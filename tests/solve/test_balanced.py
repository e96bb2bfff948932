"""Forces that a decrement does not tell are balanced; those of last digits stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ngcell.results.certificate import LIMITS
from ngcell.solve.balanced import in_balance, out_of_balance
from ngcell.solve.continuation_options import ContinuationOptions
from ngcell.solve.proximal import ProximalTerm
from tests.tissues import SmallTissue, small_tissue

SCALE = 1.0


def found(tissue: SmallTissue, tolerance: float):
    minimiser = tissue.minimiser(tissue.released)
    start = tissue.motion.imposed(tissue.motion.lifting(1.0), 1.0)
    return minimiser, minimiser.minimise(start, ProximalTerm(1e-2, start), tolerance)


def test_forces_are_balanced_farther_than_a_decrement_tells():
    minimiser, minimum = found(small_tissue(2, 2, prescribed_displacement=(0.05, 0.0)), 1e-7)
    options = ContinuationOptions()
    left = out_of_balance(minimiser, minimum)
    assert left > options.unbalanced
    better = in_balance(minimiser, minimum, SCALE, options)
    assert out_of_balance(minimiser, better) <= options.unbalanced
    assert better.proximal is minimum.proximal
    assert in_balance(minimiser, better, SCALE, options) is better


def test_what_last_digits_leave_stays():
    minimiser, minimum = found(small_tissue(2, 2, prescribed_displacement=(0.05, 0.0)), 0.0)
    left = out_of_balance(minimiser, minimum)
    same = in_balance(minimiser, minimum, SCALE, replace(ContinuationOptions(), unbalanced=1e-3 * left))
    assert same.is_found and out_of_balance(minimiser, same) <= left
    np.testing.assert_allclose(same.state.displacement, minimum.state.displacement, atol=1e-10)


@pytest.mark.parametrize("accuracy", [0.1, 0.003])
def test_half_of_what_a_certificate_allows(accuracy):
    assert ContinuationOptions().within(accuracy).unbalanced == LIMITS["residual"] / 2
