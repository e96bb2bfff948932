"""The memory that is foreseen: from the entries that the release's matrix has."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.build.memory import entry_count, foreseen_memory
from ngcell.build.options import Options
from ngcell.build.simulation import Simulation
from ngcell.run import inspect
from ngcell.solve.options import MinimiserOptions, SolverOptions
from tests.prisms import case


@pytest.mark.parametrize("height", [None, 0.4])
def test_entries_are_those_of_the_matrix_that_a_release_makes(height):
    scene = case(height)
    simulation = Simulation(scene)
    minimiser = simulation.released.minimisers[0]
    minimiser.assembly.make_room(minimiser.problem.at(np.zeros(simulation.space.unknowns)))
    entries = entry_count(simulation.problem, minimiser)
    assert entries == minimiser.assembly.system.matrix.entry_count
    told = inspect(scene)
    assert told["matrix_entries"] == entries
    assert told["memory_foreseen_gib"] == pytest.approx(foreseen_memory(entries), abs=0.005)


def test_matrices_of_the_iterative_solver_have_room_for_no_contact():
    options = Options(solver=SolverOptions(minimiser=MinimiserOptions(most_direct=0)))
    simulation = Simulation(case(0.4), options=options)
    minimiser = simulation.released.minimisers[0]
    minimiser.assembly.make_room(minimiser.problem.at(np.zeros(simulation.space.unknowns)))
    entries = entry_count(simulation.problem, minimiser)
    assert entries == minimiser.assembly.system.matrix.entry_count
    told = inspect(case(0.4), options=options)
    assert told["solver"] == "iterative" and told["matrix_entries"] == entries
    told = inspect(case(0.4))
    assert told["solver"] == "direct" and told["matrix_entries"] > entries


def test_a_tissue_of_63_000_unknowns_takes_what_was_measured():
    """5x7 prisms, two elements through walls and height: 6.1 million entries took 2.65 GiB."""
    assert foreseen_memory(6_116_922) == pytest.approx(2.65, rel=0.05)


def test_the_same_solved_by_iterations_takes_what_was_measured():
    """With a tied solid before: 4.4 million entries took 2.23 GiB."""
    assert foreseen_memory(4_401_180, "iterative") == pytest.approx(2.23, rel=0.05)
