"""The condition of the last tangent of a run, estimated from the inside of the solver."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from ngcell.build.simulation import Simulation
from ngcell.scene import AnyCase

Array = NDArray[np.float64]

_POWERS = 40


def condition(case: AnyCase, displacement: Array) -> float:
    """Return an estimate of the condition of the released tangent about a displacement."""
    simulation = Simulation(case)
    problem, path, options = simulation.problem, simulation.continuation, simulation.options.solver
    problem.apply(simulation.levels[-1])
    line = problem.linearise(problem.at(displacement))
    rows, columns = problem.pattern
    lower = sparse.coo_array((line.stiffness, (rows, columns)), shape=(len(problem.free),) * 2).tocsr()
    matrix = lower + lower.T - sparse.diags_array(lower.diagonal())
    if line.curvature is not None:
        matrix = matrix + line.curvature
    closed = np.where(line.gap <= options.minimiser.touching * simulation.longest_step, line.penalty, 0.0)
    matrix = matrix + line.jacobian.T @ (sparse.diags_array(closed) @ line.jacobian)
    matrix = matrix + path.scale * path.options.last * problem.mass.tocsr()
    free = np.flatnonzero(problem.free)
    matrix = matrix.tocsc()[free][:, free]
    return _largest(matrix.dot, len(free)) * _largest(splu(matrix).solve, len(free))


def _largest(apply: Callable[[Array], Array], size: int) -> float:
    """Return the largest magnitude of an eigenvalue of a symmetric operator, by so many steps of the power method."""
    vector, length = np.random.default_rng(0).standard_normal(size), 1.0
    for _ in range(_POWERS):
        vector = apply(vector / np.linalg.norm(vector))
        length = float(np.linalg.norm(vector))
    return length
