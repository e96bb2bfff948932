"""Whether an equilibrium is a minimum: directions of negative curvature, and how a saddle is left along them.

Newton's method keeps symmetries: a slender block that is compressed along its axis stays straight past the load at
which it buckles, where the energy has directions in which it falls. No factor of `sparsecholesky` tells them. Here the
lowest eigenvalue of the tangent K in the metric M of the mass matrix is asked for, walls that are closed held closed:
the largest eigenvalues of ``(K + s M)^-1 M`` are ``1 / (k + s)``, and Lanczos' method finds them first (Ericsson and
Ruhe, Math. Comp. 35, 1980, doi:10.1090/S0025-5718-1980-0583502-2). Any that is negative, or beyond 1 / s, is a
direction of negative curvature, whatever s is.

Whether the energy really falls is told by the energy: at a kink, where a wall that just touches opens, the tangent of
one side says nothing. A saddle is left both ways, and the lower of the two minima counts.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.options import StabilityOptions

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)


def leave_saddle(
    minimiser: Minimiser, minimum: Minimum, options: StabilityOptions, *, scale: float, length: float
) -> Minimum:
    """Return a minimum: the one that is given, unless it is a saddle.

    Parameters
    ----------
    minimiser : Minimiser
        What found it.
    minimum : Minimum
        Where it ended.
    options : StabilityOptions
        The method's own numbers.
    scale : float
        Scale of curvatures: shear modulus over squared size of a body [stress / length**2].
    length : float
        How far from a saddle other minima are looked for [length].
    """
    weight = options.weight * scale
    for _ in range(options.most_saddles):
        direction = concave_direction(minimiser, minimum, weight, options) if minimum.is_found else None
        below = None if direction is None else _below(minimiser, minimum, length * direction, options)
        if below is None:
            return minimum
        _log.info("a saddle is left: energy %.8e, then %.8e", minimum.state.energy, below.state.energy)
        minimum = below
    return replace(minimum, ending=Ending.SADDLE)


def concave_direction(
    minimiser: Minimiser, minimum: Minimum, weight: float, options: StabilityOptions
) -> Array | None:
    """Return a direction of negative curvature, its largest component 1; None where none was found.

    `weight` [stress / length**2] should be large beside the curvatures worth finding.
    Three-dimensional scenes are not searched.
    """
    if minimiser.problem.dimension == 3:
        return None
    solve, free = minimiser.stiffened(minimum, weight), minimiser.problem.free
    theta, direction = _lanczos(solve, minimiser.problem.mass, free, options.rounds)
    curvature = (1 / theta if theta else np.inf) - weight
    if not curvature < -options.negative * weight:
        return None
    _log.info("curvature %.1e times the scale", curvature / weight)
    # A sign that no symmetry of the direction makes a tie.
    sign = np.sign(direction @ _pattern(len(direction))) or 1.0
    return np.asarray(sign * direction / np.abs(direction).max())


def _below(minimiser: Minimiser, minimum: Minimum, direction: Array, options: StabilityOptions) -> Minimum | None:
    """Return the lower of the minima on both sides of a saddle; None where the energy does not fall."""
    proximal, problem = minimum.proximal, minimiser.problem
    whole = minimum.state.energy + minimiser.proximal_energy(minimum.state.displacement, proximal)
    least = max(options.fallen * abs(whole), minimiser.options.noise * minimiser.energy_scale)
    found: list[tuple[float, Minimum]] = []
    for sign in (1.0, -1.0):
        for share in options.departures:
            start = minimum.state.displacement + sign * share * direction
            energy = problem.at(start).energy + minimiser.proximal_energy(start, proximal)
            if energy < whole - least:
                trial = minimiser.minimise(start, proximal)
                if trial.is_found:
                    left = trial.state.energy + minimiser.proximal_energy(trial.state.displacement, proximal)
                    found.append((left, trial))
                break
    if not found or min(found, key=lambda one: one[0])[0] >= whole - least:
        return None
    first, *other = found
    return other[0][1] if other and other[0][0] < first[0] - options.same * abs(first[0]) else first[1]


def _pattern(size: int) -> Array:
    return np.random.default_rng(size).standard_normal(size)


def _lanczos(
    solve: Callable[[Array], Array], mass: sparse.csr_array, free: NDArray[np.bool_], rounds: int
) -> tuple[float, Array]:
    """Return the extreme eigenvalue of ``(K + s M)^-1 M``, the most negative or else the largest, and its vector."""
    vector = np.where(free, _pattern(len(free)), 0.0)
    basis: list[Array] = []
    weighed: list[Array] = []
    diagonal: list[float] = []
    beside: list[float] = []
    norm = float(np.sqrt(vector @ (mass @ vector)))
    for _ in range(rounds):
        vector = vector / norm
        basis.append(vector)
        weighed.append(np.where(free, mass @ vector, 0.0))
        nxt = solve(weighed[-1])
        diagonal.append(float(nxt @ weighed[-1]))
        known, duals = np.array(basis), np.array(weighed)
        for _ in range(2):
            nxt = nxt - known.T @ (duals @ nxt)
        norm = float(np.sqrt(max(nxt @ (mass @ nxt), 0.0)))
        if norm <= 1e-12 * abs(diagonal[0]):
            break
        beside.append(norm)
        vector = nxt
    count = len(diagonal)
    small = np.diag(diagonal) + np.diag(beside[: count - 1], 1) + np.diag(beside[: count - 1], -1)
    values, vectors = np.linalg.eigh(small)
    pick = 0 if values[0] < -1e-9 * abs(values).max() else count - 1
    return float(values[pick]), np.asarray(vectors[:, pick] @ np.array(basis))
