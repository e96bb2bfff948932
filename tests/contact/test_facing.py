"""Points of facing walls: the same ones, whatever round-off and meshes say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import ngcell
from ngcell.build.simulation import Simulation
from ngcell.contact.pairing.facing import find_facing
from tests.tissues import small_tissue

#: Edges to a side and orders whose quadrature points lie on the border of the middle half of a wall.
ON_THE_BORDER = [(2, 1), (2, 3), (4, 1), (4, 2), (4, 3)]


@pytest.mark.parametrize(("edges", "order"), ON_THE_BORDER)
def test_points_on_the_border_of_the_middle_half_do_not_depend_on_round_off(edges: int, order: int):
    walls, random = small_tissue(2, 2, order=order, edges=edges).walls, np.random.default_rng(1)
    found = find_facing(walls, tolerance=1e-3)
    assert 0 < found.is_middle.sum() < len(found.is_middle)
    for _ in range(10):
        moved = replace(walls, rest=walls.rest + 1e-15 * random.uniform(-1, 1, walls.rest.shape))
        assert np.array_equal(find_facing(moved, tolerance=1e-3).is_middle, found.is_middle)


def half_cylinder(factor: float, order: int = 2) -> Simulation:
    """Return a half-cylinder on a block, with so many times the sizes of elements of the shipped case."""
    sets = [f"mesh.size={3 * factor}", f"mesh.refine=[{{at=[0, 0], within=1.5, size={0.05 * factor}}}]"]
    return Simulation(ngcell.read_case("hertz-half-cylinder", ["accuracy=inf", f"mesh.order={order}", *sets]))


def test_what_faces_a_curved_wall_does_not_go_with_the_mesh():
    lengths = [half_cylinder(factor).setup.facing.weight.sum() for factor in (0.5, 1.0, 2.0)]
    assert max(lengths) < 1.0005 * min(lengths)


def test_the_mean_gap_of_a_curved_wall_goes_with_neither_order_nor_size_of_elements():
    found = []
    for factor, order in ((2.0, 2), (2.0, 4), (1.0, 2)):
        *_, step = half_cylinder(factor, order).accepted_steps()
        found.append(step.record.mean_gap)
    assert max(found) < 1.003 * min(found)
