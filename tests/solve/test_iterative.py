"""Conjugate gradients over bodies, against dense linear algebra and against the direct solver on prisms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from ngcell.build.options import Options
from ngcell.build.simulation import Simulation
from ngcell.solve import system
from ngcell.solve.condensed import CondensedMatrix
from ngcell.solve.iterative import RESIDUAL, IterativeMatrix
from ngcell.solve.options import MinimiserOptions, SolverOptions
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.stiffness import Stiffness
from tests.prisms import case

#: Whatever the number of unknowns, solids are solved by iterations.
ITERATIVE = Options(solver=SolverOptions(minimiser=MinimiserOptions(most_direct=0, narrow=0.0)))


class Bodies:
    """Three bodies of twelve unknowns each: definite matrices of their own, penalty terms between them, some held."""

    def __init__(self, seed: int, damping: float = 1.0) -> None:
        random = np.random.default_rng(seed)
        self.part = np.repeat([0, 1, 2], 12)
        mixed = random.standard_normal((36, 36)) * (self.part[:, None] == self.part)
        self.own = mixed @ mixed.T + damping * np.eye(36)
        self.free = random.uniform(size=36) < 0.8
        self.jacobian = sparse.random_array((10, 36), density=0.2, rng=random, data_sampler=random.standard_normal)
        self.penalty = 10 * random.uniform(size=10)
        self.curvature = sparse.random_array((36, 36), density=0.1, rng=random)
        self.curvature = ((self.curvature + self.curvature.T) * 0.01).tocoo()
        self.right = random.standard_normal(36)
        self.rows, self.columns = np.nonzero(np.tril(self.part[:, None] == self.part))

    @property
    def full(self) -> np.ndarray:
        jacobian = self.jacobian.toarray()
        return self.own + self.curvature.toarray() + jacobian.T @ (self.penalty[:, None] * jacobian)

    @property
    def solution(self) -> np.ndarray:
        solution = np.zeros(36)
        inside = self.full[np.ix_(self.free, self.free)]
        solution[self.free] = np.linalg.solve(inside, self.right[self.free])
        return solution

    def solved(self, rows: np.ndarray, columns: np.ndarray) -> tuple[IterativeMatrix, Stiffness]:
        matrix = IterativeMatrix(36, self.free, rows, columns, self.part)
        values = np.zeros(matrix.entry_count)
        values[matrix.locate(self.rows, self.columns)] = self.own[self.rows, self.columns]
        stiffness = Stiffness(values, self.curvature.tocsr())
        matrix.factorise(stiffness, self.jacobian.tocsr(), self.penalty)
        return matrix, stiffness


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("together", [False, True], ids=["apart", "coupled in the pattern"])
def test_solving_gives_the_dense_solution_in_free_rows_and_zero_elsewhere(seed, together):
    bodies = Bodies(seed)
    rows, columns = np.tril_indices(36) if together else (bodies.rows, bodies.columns)
    matrix, stiffness = bodies.solved(rows, columns)
    without = bodies.own + bodies.curvature.toarray()
    np.testing.assert_allclose(matrix.multiply(stiffness, bodies.right), without @ bodies.right, atol=1e-12)
    away = matrix.solve(bodies.right) - bodies.solution
    energy = bodies.solution @ bodies.full @ bodies.solution
    assert away @ bodies.full @ away < 10 * RESIDUAL**2 * energy
    assert not away[~bodies.free].any()


def test_a_body_alone_is_solved_at_once():
    bodies = Bodies(1)
    bodies.penalty, bodies.curvature = 0 * bodies.penalty, 0 * bodies.curvature
    matrix, _ = bodies.solved(bodies.rows, bodies.columns)
    np.testing.assert_allclose(matrix.solve(bodies.right), bodies.solution, atol=1e-10)
    assert matrix.iterations <= 1


@pytest.mark.parametrize("concave", ["within a body", "between bodies"])
def test_negative_curvature_is_told_by_a_step_that_leads_uphill(concave):
    bodies = Bodies(2)
    bodies.free[:] = True
    if concave == "within a body":
        value, vector = np.linalg.eigh(bodies.own[:12, :12])
        bodies.own[:12, :12] -= (value[0] + 0.01) * np.outer(vector[:, 0], vector[:, 0])
        bodies.penalty = 0 * bodies.penalty
    else:
        bodies.curvature = sparse.coo_array(([-1e3, -1e3], ([3, 20], [20, 3])), shape=(36, 36))
    matrix, _ = bodies.solved(bodies.rows, bodies.columns)
    found = matrix.solve(bodies.right)
    assert found @ bodies.full @ found < 0
    assert bodies.right @ found < 0
    assert found @ bodies.full @ found == pytest.approx(bodies.right @ found, rel=1e-9)


def test_prisms_are_those_of_the_direct_solver(monkeypatch):
    """Tied and released; the minimisers make matrices that need no room for contact."""
    scene = case(0.4, tissue={"rows": 2, "cols": 2, "wall": 0.1, "height": 0.4})
    direct = list(Simulation(scene).accepted_steps())
    made: list[object] = []
    monkeypatch.setattr(system, "CondensedMatrix", lambda *_: made.append(None))
    iterative = list(Simulation(scene, options=ITERATIVE).accepted_steps())
    assert not made
    for one, two in zip(direct, iterative, strict=True):
        assert one.record.certified and two.record.certified
        assert two.record.energy == pytest.approx(one.record.energy, rel=1e-6)
        assert two.record.plate_force_x == pytest.approx(one.record.plate_force_x, rel=1e-6)
        assert two.record.contact_force == pytest.approx(one.record.contact_force, rel=1e-5)


def test_penalty_terms_that_pull_at_more_than_there_is_room_for_are_solved_for_as_well():
    """The pattern holds the diagonal only; bodies hardly know of their own penalty terms: the solution is the same."""
    bodies = Bodies(4)
    bodies.own, bodies.curvature = np.eye(36), 0 * bodies.curvature
    bodies.rows = bodies.columns = np.arange(36)
    matrix, _ = bodies.solved(bodies.rows, bodies.columns)
    away = matrix.solve(bodies.right) - bodies.solution
    assert away @ bodies.full @ away < 100 * RESIDUAL**2 * (bodies.solution @ bodies.full @ bodies.solution)


def test_planar_scenes_are_never_solved_by_iterations():
    simulation = Simulation(case(None), options=ITERATIVE)
    minimiser = simulation.released.minimisers[0]
    assert not minimiser.is_iterative
    assert Simulation(case(0.4), options=ITERATIVE).released.minimisers[0].is_iterative
    state = minimiser.problem.at(np.zeros(simulation.space.unknowns))
    minimiser.assembly.model(state, minimiser.problem.linearise(state), ProximalTerm(1.0, state.displacement))
    assert isinstance(minimiser.assembly.system.matrix, CondensedMatrix)
