"""Pairs of near points against all distances, and components against scipy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from ngcell.geometry.near import components, near_pairs


@pytest.mark.parametrize("reach", [1e-9, 0.01, 0.08, 0.7, 5.0])
@pytest.mark.parametrize("scale", [(1.0, 1.0), (1e-3, 1.0), (1.0, 0.0)])
@pytest.mark.parametrize("count", [0, 1, 2, 300])
def test_no_near_pair_is_missed_and_none_is_found_twice(count, scale, reach):
    points = np.random.default_rng(7).uniform(-1, 1, (count, 2)) * scale
    points[count // 2 :: 5] = points[: len(points[count // 2 :: 5])]  # some coincide
    one, two = near_pairs(points, reach)
    upper = np.array(np.nonzero(np.triu(np.linalg.norm(points[:, None] - points, axis=2) <= reach, 1)))
    np.testing.assert_array_equal([one, two], upper)


def test_points_on_the_borders_of_boxes_find_each_other():
    points = np.stack(np.meshgrid(np.arange(6.0), np.arange(5.0)), axis=-1).reshape(-1, 2)
    one, two = near_pairs(points, 1.0)
    assert len(one) == 5 * 5 + 6 * 4
    assert len(near_pairs(points, 0.999)[0]) == 0


@pytest.mark.parametrize("links", [0, 30, 100, 400])
def test_components_are_those_of_the_graph(links):
    one, two = np.random.default_rng(links).integers(0, 120, (2, links))
    graph = sparse.coo_array((np.ones(links), (one, two)), shape=(120, 120))
    np.testing.assert_array_equal(components(120, one, two), connected_components(graph, directed=False)[1])


def test_a_long_chain_is_one_component():
    order = np.random.default_rng(3).permutation(5000)
    assert components(5000, order[:-1], order[1:]).max() == 0
