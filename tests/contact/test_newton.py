"""Newton's method with pairs found anew in every iteration, near the solution."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.problem.problem import Problem
from ngcell.solve.minimum import Ending
from ngcell.solve.proximal import ProximalTerm
from tests.tissues import SmallTissue, contact_set, small_tissue, whole_tangent


def pressed_cells(order: int) -> SmallTissue:
    """Two cells side by side: the left end is held, the right end moved inward and up."""
    normals = small_tissue(1, 2).lattice.normals
    right = int(np.argmax(normals[:, 0]))
    left_end, right_end = np.zeros((2, 2, 6), dtype=bool)
    left_end[0, (right + 3) % 6] = right_end[1, right] = True
    ends = {"left": left_end, "right": right_end}
    return small_tissue(1, 2, order=order, edges=3, wall=0.15, prescribed_displacement=(-0.3, 0.1), supports=ends)


def newton_step(problem: Problem, displacement: np.ndarray) -> np.ndarray:
    state, free = problem.at(displacement), np.flatnonzero(problem.free)
    tangent = whole_tangent(problem, problem.linearise(state)).toarray()[np.ix_(free, free)]
    moved = displacement.copy()
    moved[free] -= np.linalg.solve(tangent, problem.gradient(state)[free])
    return moved


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_update_of_pairs_converges_quadratically(order):
    tissue = pressed_cells(order)
    problem, minimiser = tissue.released, tissue.minimiser(tissue.released)
    displacement = tissue.motion.lifting(0.0)
    for load in (0.25, 0.5, 0.75, 1.0):
        grown = displacement + tissue.motion.lifting(load) - tissue.motion.lifting(load - 0.25)
        minimum = minimiser.minimise(grown, ProximalTerm(0.0, grown), 1e-12)
        assert minimum.ending is Ending.CONVERGED
        displacement = minimum.state.displacement
    for _ in range(4):
        displacement = newton_step(problem, displacement)
    state = problem.at(displacement)
    assert np.abs(problem.gradient(state)[problem.free]).max() < 1e-12
    kinematics = contact_set(problem, state).kinematics
    closed = kinematics.gaps(tissue.positions(displacement)) < 0
    assert closed.sum() > 3
    trial = displacement + 5e-5 * tissue.smooth(1.0, 3) * problem.free
    errors = []
    for _ in range(4):
        trial = newton_step(problem, trial)
        errors.append(np.abs(trial - displacement).max())
    # Once the same walls are closed: e' <= C e^2 with one C, down to round-off.
    assert errors[0] < 1e-4 and errors[-1] < 1e-13
    assert all(after <= 50 * before**2 + 1e-13 for before, after in zip(errors, errors[1:], strict=False))
