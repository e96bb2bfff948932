"""The memory that is foreseen: from the entries that the release's matrix has."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.build.memory import entry_count, foreseen_memory
from ngcell.build.options import Options
from ngcell.build.simulation import Simulation
from ngcell.run import inspect
from ngcell.solve.minimise import Minimiser
from ngcell.solve.options import MinimiserOptions, SolverOptions
from ngcell.solve.proximal import ProximalTerm
from tests.prisms import case


def matrix_of(minimiser: Minimiser) -> object:
    state = minimiser.problem.at(np.zeros(len(minimiser.problem.free)))
    return minimiser.assembly.model(state, minimiser.problem.linearise(state), ProximalTerm(1.0, state.displacement))[1]


@pytest.mark.parametrize("height", [None, 0.4])
@pytest.mark.parametrize("solver", ["direct", "iterative"])
def test_entries_are_those_of_the_matrix_that_a_release_makes(height, solver):
    most = 0 if solver == "iterative" else 200_000
    options = Options(solver=SolverOptions(minimiser=MinimiserOptions(most_direct=most, narrow=0.0)))
    simulation = Simulation(case(height), options=options)
    entries = entry_count(simulation.problem)
    assert entries == matrix_of(simulation.released.minimisers[0]).entry_count
    told = inspect(case(height), options=options)
    assert told["solver"] == ("direct" if height is None else solver)  # planar scenes are never solved by iterations
    assert told["matrix_entries"] == entries
    foreseen = foreseen_memory(entries, 2 if height is None else 3, told["solver"])
    assert told["memory_foreseen_gib"] == pytest.approx(foreseen, abs=0.005)


def test_a_tissue_of_63_000_unknowns_takes_what_was_measured():
    """5x7 prisms, two elements through walls and height: 4.4 million entries took 2.60 GiB."""
    assert foreseen_memory(4_401_180, 3) == pytest.approx(2.60, rel=0.05)


def test_the_same_solved_by_iterations_takes_what_was_measured():
    """With a tied solid before: 4.4 million entries took 2.23 GiB."""
    assert foreseen_memory(4_401_180, 3, "iterative") == pytest.approx(2.23, rel=0.05)


def test_planar_tissues_take_what_was_measured():
    """Hollow: 2.9 million entries of 100 cells took 0.87 GiB, 30 of 1024 cells 7.74; filled, 8.5 took 3.15."""
    assert foreseen_memory(2_928_000, 2) == pytest.approx(0.87, rel=0.16)
    assert foreseen_memory(29_982_720, 2) == pytest.approx(7.74, rel=0.03)
    assert foreseen_memory(8_472_300, 2, is_filled=True) == pytest.approx(3.15, rel=0.03)
