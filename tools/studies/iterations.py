"""Seconds of single Newton iterations of a released tissue, and of the factorisation and solve in them.

A run would take minutes where a few iterations tell the same, so this is measured inside the solver.
"""

from __future__ import annotations

import resource
from time import process_time
from typing import Any

import numpy as np

from ngcell.build.simulation import Simulation
from ngcell.solve.proximal import ProximalTerm

#: Iterations that are timed.
ITERATIONS = 4


def peak() -> float:
    """Return the largest resident memory so far [MiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def iterated(case: Any) -> dict[str, float]:
    """Time `ITERATIONS` Newton iterations of a released tissue, its proximal term a hundredth of its stiffness."""
    before = peak()
    simulation = Simulation(case)
    minimiser = simulation.released.minimisers[-1]
    start = simulation.motion.lifting(1.0)
    proximal = ProximalTerm(0.01 * simulation.continuation.scale, start)
    minimiser.minimise(start, proximal, most=1)  # what is made once
    clock, effort = simulation.clock.seconds, minimiser.effort.copy()
    clock.clear()
    minimiser.minimise(start, proximal, most=ITERATIONS)
    spent = minimiser.effort - effort
    system = minimiser.assembly.system
    assert system is not None  # it has made one
    rest = clock["pairs and energies"] + clock["assembly"]
    return {
        "cells": case.tissue.rows * case.tissue.cols,
        "unknowns": simulation.space.unknowns,
        "iterations": spent.iterations,
        "factorisations": spent.factorisations,
        "seconds of an iteration": (rest + clock["factorisation"]) / spent.iterations,
        "of it without the direct solver": rest / spent.iterations,
        "factorisation and solve alone": _seconds_of_solver(system.matrix),
        "MiB": peak() - before,
    }


def _seconds_of_solver(matrix: Any) -> float:
    """Return the smallest of three times that a factorisation and a solve of the last condensed matrix take."""
    condensed = matrix._elimination.matrix._factorised
    values, right, taken = condensed._factor._values.copy(), np.ones(condensed.size), []
    for _ in range(3):
        started = process_time()
        condensed.factorise(values)
        condensed.solve(right)
        taken.append(process_time() - started)
    return min(taken)
