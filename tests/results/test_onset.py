"""Onsets of wall pairs, and what is reported of cells."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.results.growth import growth_onset
from ngcell.results.onset import PairOnsets


def test_each_pair_opens_where_its_mean_gap_reaches_the_mark():
    first = PairOnsets.starting(0.0, np.zeros(3), 0.1).after(0.2, np.array([0.0, 0.010, 0.004]), 0.1)
    second = first.after(0.6, np.array([0.002, 0.001, 0.008]), 0.1)
    np.testing.assert_allclose(first.onset, [np.nan, 0.1, np.nan])
    np.testing.assert_allclose(second.onset, [np.nan, 0.1, 0.3])
    again = PairOnsets.from_array(second.array())
    np.testing.assert_array_equal(again.array(), second.array())


def test_one_pair_has_the_onset_of_a_tissue_with_its_gap():
    displacement, gap = [0.1, 0.2, 0.4], [0.001, 0.003, 0.012]
    onsets = PairOnsets.starting(0.0, np.zeros(1), 0.1)
    for at, mean in zip(displacement, gap, strict=True):
        onsets = onsets.after(at, np.array([mean]), 0.1)
    assert onsets.onset[0] == pytest.approx(growth_onset(displacement, gap, 0.1), rel=1e-12)
