"""The width of bodies: what a banded matrix and a ring have, and which solver it chooses."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.build.options import Options
from ngcell.build.simulation import Simulation
from ngcell.solve.options import MinimiserOptions, SolverOptions
from ngcell.solve.width import profile_width, width_of_bodies
from tests.prisms import case


def test_a_shuffled_band_has_the_width_of_the_band():
    size, width = 400, 5
    row, column = np.nonzero(np.tri(size, dtype=bool) & ~np.tri(size, k=-width - 1, dtype=bool))
    shuffled = np.random.default_rng(0).permutation(size)
    assert profile_width(shuffled[row], shuffled[column], size) == pytest.approx(width, rel=0.05)


def test_a_ring_is_twice_as_wide_as_its_cross_section():
    size = 400
    row = np.arange(size)
    assert profile_width(row, (row + 1) % size, size) == pytest.approx(2.0, rel=0.05)


def test_prisms_are_wider_the_higher_they_are_meshed_and_the_width_chooses_the_solver():
    def width(slices):
        solids = case(0.4)
        return width_of_bodies(
            Simulation(solids.model_copy(update={"mesh": solids.mesh.model_copy(update={"slices": slices})})).problem
        )

    one, three = width(1), width(3)
    assert 1.5 * one < three < 4 * one

    def is_iterative(narrow):
        options = Options(solver=SolverOptions(minimiser=MinimiserOptions(most_direct=0, narrow=narrow)))
        solids = case(0.4)
        return Simulation(solids, options=options).released.minimisers[0].is_iterative

    slices = case(0.4).mesh.slices
    assert is_iterative(0.9 * width(slices))
    assert not is_iterative(1.1 * width(slices))
