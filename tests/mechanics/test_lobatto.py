"""Gauss-Lobatto rules: what they integrate exactly, and where their points are."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.mechanics.lobatto import lobatto, lobatto_on_quadrilaterals


@pytest.mark.parametrize("count", [2, 3, 5])
def test_polynomials_are_integrated_exactly_up_to_the_degree_told_and_no_further(count):
    points, weights = lobatto(count)
    assert points[0] == 0 and points[-1] == 1
    for degree in range(2 * count - 2):
        assert weights @ points**degree == pytest.approx(1 / (degree + 1), rel=1e-13)
    assert abs(weights @ points ** (2 * count - 2) - 1 / (2 * count - 1)) > 1e-8


def test_the_rule_on_quadrilaterals_has_their_corners_and_is_as_exact_in_each_direction():
    rule = lobatto_on_quadrilaterals(4)
    points, weights = np.array(rule.points)[:, :2], np.array(rule.weights)
    assert {(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)} <= {(float(x), float(y)) for x, y in points}
    x, y = points.T
    assert weights @ (x**5 * y**4) == pytest.approx(1 / 30, rel=1e-13)
