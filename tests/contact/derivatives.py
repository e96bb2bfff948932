"""Steps that cross no kink of an energy, and the check that forces and tangent are its derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.contact.cohesion.bonds import Bonds
from ngcell.problem.problem import Problem
from tests.tissues import contact_set, whole_tangent


def assert_derivatives(problem: Problem, at: np.ndarray, way: np.ndarray, step: float, rel: float) -> None:
    """Forces are the derivative of the energy along `way`, to `rel`, and the tangent is that of the forces."""
    state = problem.at(at)
    after, before = problem.at(at + step * way), problem.at(at - step * way)
    force = problem.gradient(state)
    assert (after.energy - before.energy) / (2 * step) == pytest.approx(force @ way, rel=rel)
    bent = whole_tangent(problem, problem.linearise(state)) @ way
    change = (problem.gradient(after) - problem.gradient(before)) / (2 * step)
    np.testing.assert_allclose(change, bent, atol=2e-6 * np.abs(bent).max())


def step_between_kinks(gap: np.ndarray, rate: np.ndarray) -> float:
    """A step along which no gap changes its sign."""
    return min(1e-5, 0.5 * np.min(np.abs(gap) / np.abs(rate), initial=1.0))


def smooth_step(problem: Problem, bonds: Bonds, at: np.ndarray, way: np.ndarray) -> float:
    """A step on which no wall closes, no bond turns from pressed to open, and none passes its history."""

    def sides(displacement: np.ndarray) -> np.ndarray:
        positions = problem.configuration(displacement).positions
        gap, _, _ = contact_set(problem, problem.at(at)).penalty_terms(positions)
        opening, height = bonds.openings(positions), bonds.kinematics.gaps(positions)
        return np.concatenate([gap > 0, height > 0, opening > bonds.largest])

    step = 1e-5
    while not all(np.array_equal(sides(at), sides(at + sign * step * way)) for sign in (-1, 1)):
        step /= 2
        assert step > 1e-8
    return step
