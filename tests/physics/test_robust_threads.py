"""The same scene gives the same bits with any number of threads."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ngcell.build.checkpoint import Checkpoint
from ngcell.build.simulation import Simulation
from ngcell.scene import read_case
from ngcell.threads import threads

_CASES = Path(__file__).parents[2] / "cases"


def _first_state(count: int) -> np.ndarray:
    """Displacement of the first step of a tissue whose cells choose sides by last digits."""
    with threads(count):
        simulation = Simulation(read_case(_CASES / "shear-empty-3x3.toml", ["accuracy=inf"]))
        return next(simulation.follow(Checkpoint())).minimum.state.displacement


def test_threads_change_no_bit() -> None:
    assert np.array_equal(_first_state(1), _first_state(2))
