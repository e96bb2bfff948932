"""The same scene gives the same bits with any number of threads."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ngcell.build.checkpoint import Checkpoint
from ngcell.build.simulation import Simulation
from ngcell.mechanics.symbolic import assembly_threads
from ngcell.scene import read_case

_CASES = Path(__file__).parents[2] / "cases"


def _first_state(threads: int) -> np.ndarray:
    """Displacement of the first step of a tissue whose cells choose sides by last digits."""
    with assembly_threads(threads):
        simulation = Simulation(read_case(_CASES / "shear-empty-3x3.toml"))
        return next(simulation.follow(Checkpoint())).minimum.state.displacement


def test_threads_change_no_bit() -> None:
    assert np.array_equal(_first_state(1), _first_state(2))


def test_more_threads_solve_to_the_same_bits() -> None:
    """NGSolve's Cholesky factor uses as many threads as are set, even without a task manager."""
    simulation = Simulation(read_case(_CASES / "shear-empty-3x3.toml"))
    minimiser = simulation.tied[-1]
    at_rest, jump = np.zeros(len(minimiser.problem.free)), simulation.motion.imposed(np.zeros(simulation.space.unknowns), 0.1)
    found = []
    for threads in (1, 2, 2):
        with assembly_threads(threads):
            found.append(minimiser.predict(at_rest, jump, 1.0))
    assert np.array_equal(found[0], found[1]) and np.array_equal(found[1], found[2])
