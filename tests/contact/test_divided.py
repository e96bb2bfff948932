"""The quadrature rule on walls whose edges are divided into equal parts."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tissues import small_tissue


@pytest.mark.parametrize("parts", [1, 2, 4])
def test_the_rule_of_equal_parts_is_exact_for_what_has_kinks_between_them(parts: int):
    walls = small_tissue(1, 2, order=3).walls
    points = walls.divided(parts)
    length = np.bincount(points.facet, points.weight)
    np.testing.assert_allclose(length, walls.weights.sum(1), rtol=1e-13)
    assert (np.diff(points.xi.reshape(walls.facet_count, -1), axis=1) > 0).all()  # points between parts are there once
    kinked = sum(np.abs(points.xi - place) for place in np.arange(1, parts) / parts)
    expected = sum((place**2 + (1 - place) ** 2) / 2 for place in np.arange(1, parts) / parts)
    np.testing.assert_allclose(np.bincount(points.facet, points.weight * kinked), expected * length, rtol=1e-12)
