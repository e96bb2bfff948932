"""Gauss-Lobatto rules: what they integrate exactly, and where their points are."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.mechanics.lobatto import lobatto, lobatto_across


@pytest.mark.parametrize("count", [2, 3, 5])
def test_polynomials_are_integrated_exactly_up_to_the_degree_told_and_no_further(count):
    points, weights = lobatto(count)
    assert points[0] == 0 and points[-1] == 1
    for degree in range(2 * count - 2):
        assert weights @ points**degree == pytest.approx(1 / (degree + 1), rel=1e-13)
    assert abs(weights @ points ** (2 * count - 2) - 1 / (2 * count - 1)) > 1e-8


def test_rules_across_have_the_corners_and_are_exact_in_each_direction():
    rules = lobatto_across(2)
    points, weights = np.array(rules[ngsolve.ET.QUAD].points)[:, :2], np.array(rules[ngsolve.ET.QUAD].weights)
    assert {(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)} <= {(float(x), float(y)) for x, y in points}
    x, y = points.T
    assert weights @ (x**5 * y**4) == pytest.approx(1 / 30, rel=1e-13)
    x, y, z = np.array(rules[ngsolve.ET.HEX].points).T
    assert rules[ngsolve.ET.HEX].weights @ (x**5 * y**4 * z**5) == pytest.approx(1 / 180, rel=1e-13)
