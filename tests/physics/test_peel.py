"""A double-cantilever strip peels at the energy release rate of beam theory."""

from __future__ import annotations

import numpy as np
import pytest

from tools.references.peel import peeled, strip


def test_a_strip_peels_at_the_energy_release_rate_of_beams():
    rows = list(peeled(strip(toughness=5.5e-7, zone=0.2, opening=0.24, size=0.1, order=3, steps=8)))
    grown = [row for row in rows if row["opening"] > 0.2]
    assert len(grown) > 3
    crack = np.array([row["crack_of_compliance"] for row in grown])
    assert crack[-1] > crack[0] + 0.1
    np.testing.assert_allclose([row["release_over_toughness"] for row in grown], 1, atol=0.03)
    # What separated is the toughness times how far the crack came.
    separated = np.diff([row["separation_energy"] for row in grown]).sum()
    assert separated == pytest.approx(5.5e-7 * (crack[-1] - crack[0]), rel=0.03)
    assert all(row["certified"] for row in rows)
