"""What a residual is let off by is round-off, and nothing that a solver could leave behind."""

import numpy as np
import pytest

from ngcell import read_case
from ngcell.build.simulation import Simulation
from ngcell.results.checks import _last_digits


def share_of_last_digits() -> float:
    simulation = Simulation(read_case("shear-empty", ("tissue.rows=2", "tissue.cols=2", "accuracy=inf")))
    problem = simulation.problem
    # Pressed together by a hundredth, so that walls that touch are strained but closed penalty terms act, too.
    place = -0.01 * simulation.space.rest * np.array([[1.0], [0.0]])
    state = problem.at(place.ravel() + 1e-6 * np.sin(np.arange(place.size)))
    return float(np.linalg.norm(_last_digits(problem, state)) / np.linalg.norm(problem.gradient(state)))


def test_last_digits_are_nothing_beside_the_limit_of_the_residual():
    assert 0 < share_of_last_digits() < 1e-9


def test_walls_that_are_open_by_round_off_count_as_closed():
    simulation = Simulation(read_case("shear-empty", ("tissue.rows=2", "tissue.cols=2", "accuracy=inf")))
    touching, apart = simulation.problem, simulation.released.apart.problem
    space, norm = simulation.space, {}
    centre = np.array([space.rest[:, space.body_of_unknown == body].mean(1) for body in range(space.body_count)])
    outward = (centre - centre.mean(0))[space.body_of_unknown].T * space.one
    for gap in (4e-15, 1e-9):  # less than sums over nodes are off by, and far more
        at = (gap * outward).ravel()
        norm[gap] = [float(np.linalg.norm(_last_digits(each, each.at(at)))) for each in (touching, apart)]
    assert norm[4e-15][0] > 1.5 * norm[4e-15][1]
    assert norm[1e-9][0] == pytest.approx(norm[1e-9][1], rel=1e-6)
