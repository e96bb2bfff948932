"""Whether an equilibrium is a minimum: directions of negative curvature, and how a saddle is left along them.

Newton's method keeps symmetries: a slender block that is compressed along its axis stays straight past the load at
which it buckles, where the energy has directions in which it falls. No factor of `sparsecholesky` tells them. Here the
lowest eigenvalue of the tangent K in the metric M of the mass matrix is asked for, walls that are closed held closed:
the largest eigenvalues of ``(K + s M)^-1 M`` are ``1 / (k + s)``, and Lanczos' method finds them first (Ericsson and
Ruhe, Math. Comp. 35, 1980, doi:10.1090/S0025-5718-1980-0583502-2). Any that is negative, or beyond 1 / s, is a
direction of negative curvature, whatever s is.

Whether the energy really falls is told by the energy: at a kink, where a wall that just touches opens, the tangent of
one side says nothing. A saddle is left both ways, along each direction that is nearly as low as the lowest, and the
lowest of the minima counts: of two directions that are as low, the last digits of the mesh would choose one.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.options import StabilityOptions
from ngcell.solve.problem import SymmetricOperator

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Mode:
    """An eigenvalue of a tangent, closed contacts held closed.

    Attributes
    ----------
    curvature : float
        The eigenvalue in the metric of the mass matrix [stress / length**2].
    direction : array of float, shape (unknowns,)
        Its eigenvector, largest component 1.
    rounds : int
        Rounds of Lanczos' method that it took; 0 where ARPACK found it.
    """

    curvature: float
    direction: Array
    rounds: int


def stable_minimum(
    minimiser: Minimiser,
    minimum: Minimum,
    until_met: Callable[[Minimum], Minimum],
    options: StabilityOptions,
    *,
    scale: float,
    length: float,
) -> Minimum:
    """Return a minimum with its lowest curvature: the one that is given, or one below it if that is a saddle.

    Where systems are solved by iterations it is left as it is, without a curvature: these detect negative curvature on
    the way, and the minimisation goes along it.

    Parameters
    ----------
    minimiser : Minimiser
        What found it.
    minimum : Minimum
        Where it ended.
    until_met : function
        Returns a minimum near one, with the conditions of contact met.
    options : StabilityOptions
        The method's own numbers.
    scale : float
        Scale of curvatures: shear modulus over squared size of a body [stress / length**2].
    length : float
        How far from a saddle other minima are looked for [length].
    """
    for _ in range(options.most_saddles):
        if minimiser.is_iterative or not minimum.is_found:
            return minimum
        mode = lowest_mode(minimiser, minimum, options, scale=scale)
        curvature, below = mode.curvature, None
        if curvature < -options.negative * scale:
            curvature, below = _below(minimiser, minimum, [length * mode.direction], options)
        if below is None:
            return replace(minimum, lowest_curvature=curvature / scale)
        modes = modes_as_low(minimiser, minimum, mode, options)
        if len(modes) > 1:
            _, lowest = _below(minimiser, minimum, [length * each.direction for each in modes], options)
            below = lowest or below
        _log.info("a saddle is left: energy %.8e, then %.8e", minimum.state.energy, below.state.energy)
        saddle, minimum = minimum, until_met(below)
        if minimum.ending is Ending.NO_ENERGY:  # it was folded between the points of a rule that is finer now
            minimum = until_met(minimiser.minimise(saddle.state.displacement, saddle.proximal))
    return replace(minimum, ending=Ending.SADDLE)


def lowest_mode(minimiser: Minimiser, minimum: Minimum, options: StabilityOptions, *, scale: float) -> Mode:
    """Return the lowest eigenvalue of the tangent at a minimum, its vector, and what it took.

    Beside a weight that is much larger, eigenvalues near zero hardly differ, and rounds would end before the lowest one
    is found. So weights are only somewhat larger than what has been found. `scale` [stress / length**2] is that of
    curvatures. It is NaN where the tangent has next to no inverse, with whatever weight.
    """
    weight, lowest = options.near * scale, None
    for _ in range(options.most_weights):
        mode = _mode_near(minimiser, minimum, weight, options)
        _log.info("lowest curvature %.1e times the scale, %d rounds", mode.curvature / scale, mode.rounds)
        if np.isnan(mode.curvature):  # the matrix has next to no inverse at this weight
            weight, lowest = options.farther * weight, lowest or mode
            continue
        if lowest is None or np.isnan(lowest.curvature) or mode.curvature < lowest.curvature:
            lowest = mode
        if mode.curvature > -weight:
            break
        weight = -options.farther * mode.curvature
    assert lowest is not None
    return lowest


def _mode_near(minimiser: Minimiser, minimum: Minimum, weight: float, options: StabilityOptions) -> Mode:
    """Return the lowest eigenvalue; where some are below ``-weight``, the one of these that is nearest to it."""
    solve, free = minimiser.stiffened(minimum, weight), minimiser.problem.free
    theta, direction, rounds = _lanczos(solve, minimiser.problem.mass, free, options)
    return Mode(float(1 / theta) - weight, direction if np.isnan(theta) else _oriented(direction), rounds)


def modes_as_low(
    minimiser: Minimiser, minimum: Minimum, lowest: Mode, options: StabilityOptions
) -> tuple[Mode, ...]:
    """Return the modes whose curvatures are nearly as low as the lowest one, which is negative, in ascending order.

    Lanczos' method from one vector ends before it tells two close eigenvalues apart, and never tells equal ones;
    ARPACK starts again within the space that it has found (Lehoucq, Sorensen and Yang, ARPACK Users' Guide, 1998,
    doi:10.1137/1.9780898719628).
    """
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh  # few runs need it

    weight, free = -options.farther * lowest.curvature, minimiser.problem.free
    solve, mass = minimiser.stiffened(minimum, weight), minimiser.problem.mass.tocsr()[free][:, free]
    count = min(options.most_modes, mass.shape[0] - 1)
    if not count:
        return (lowest,)

    def solved(force: Array) -> Array:
        whole = np.zeros(len(free))
        whole[free] = force
        return np.asarray(solve(whole)[free])

    try:
        values, vectors = eigsh(
            mass, count, mass, sigma=-weight, v0=_pattern(mass.shape[0]), tol=options.unmixed,
            OPinv=LinearOperator(mass.shape, solved, dtype=float),  # which is all that it takes of K
        )  # fmt: skip
    except ArpackError:  # not converged, or a tangent that has next to no inverse
        return (lowest,)
    directions = np.zeros((count, len(free)))
    directions[:, free] = vectors.T
    modes = [Mode(float(value), _oriented(way), 0) for value, way in zip(values, directions, strict=True)]
    as_low = tuple(mode for mode in modes if mode.curvature <= options.as_low * modes[0].curvature)
    _log.info("as low: %s", ", ".join(f"{mode.curvature / lowest.curvature:.3f}" for mode in as_low))
    return as_low


def _oriented(direction: Array) -> Array:
    """Return a direction with largest component 1, of a sign that no symmetry of the direction makes a tie."""
    sign = np.sign(direction @ _pattern(len(direction))) or 1.0
    return np.asarray(sign * direction / np.abs(direction).max())


def _below(
    minimiser: Minimiser, minimum: Minimum, directions: Sequence[Array], options: StabilityOptions
) -> tuple[float, Minimum | None]:
    """Return the curvature of the energy along directions, and the lowest of the minima on both sides of a saddle.

    There is no minimum where the energy does not fall. The curvature is the lowest that differences of energies show
    [stress / length**2]; falls that count as nothing do not.
    """
    proximal, problem = minimum.proximal, minimiser.problem
    whole = minimum.state.energy + minimiser.proximal_energy(minimum.state.displacement, proximal)
    least = max(options.fallen * abs(whole), minimiser.options.noise * minimiser.energy_scale)
    curvature, found = np.inf, []
    for way in (sign * direction for direction in directions for sign in (1.0, -1.0)):
        moved = float(way @ (problem.mass @ way))
        for share in options.departures:
            start = minimum.state.displacement + share * way
            fallen = whole - problem.at(start).energy - minimiser.proximal_energy(start, proximal)
            if np.isfinite(fallen):
                curvature = min(curvature, -2 * (fallen if fallen > least else min(fallen, 0.0)) / (share**2 * moved))
            if fallen > least:
                trial = minimiser.minimise(start, proximal, least)
                if trial.is_found:
                    left = trial.state.energy + minimiser.proximal_energy(trial.state.displacement, proximal)
                    found.append((left, trial))
                break
    if not found or min(found, key=lambda one: one[0])[0] >= whole - least:
        return curvature, None
    lowest = found[0]
    for other in found[1:]:  # of two that are as low, the first
        lowest = other if other[0] < lowest[0] - options.same * abs(lowest[0]) else lowest
    return curvature, lowest[1]


def _pattern(size: int) -> Array:
    return np.random.default_rng(size).standard_normal(size)


def _lanczos(
    solve: Callable[[Array], Array], mass: SymmetricOperator, free: NDArray[np.bool_], options: StabilityOptions
) -> tuple[float, Array, int]:
    """Return the extreme eigenvalue of ``(K + s M)^-1 M``, the most negative or else the largest, with its vector.

    It ends once the residual of the Ritz pair is below the share `options.settled`: the error of the value is then
    about its square (Parlett, The Symmetric Eigenvalue Problem, 1980, section 11.6).
    """
    vector = np.where(free, _pattern(len(free)), 0.0)
    norm = float(np.sqrt(vector @ (mass @ vector)))
    basis, weighed = np.empty((2, options.rounds, len(free)))  # rows that are not reached take no memory
    small = np.zeros((options.rounds + 1, options.rounds + 1))
    for count in range(1, options.rounds + 1):
        known, duals = basis[:count], weighed[:count]
        known[-1] = vector / norm
        duals[-1] = np.where(free, mass @ known[-1], 0.0)
        vector = solve(duals[-1])
        small[count - 1, count - 1] = vector @ duals[-1]
        for _ in range(2):
            vector = vector - known.T @ (duals @ vector)
        norm = float(np.sqrt(max(float(vector @ (mass @ vector)), 0.0)))
        if not np.isfinite(norm):
            return float("nan"), np.zeros(len(free)), count
        small[count - 1, count] = small[count, count - 1] = norm
        values, vectors = np.linalg.eigh(small[:count, :count])
        pick = 0 if values[0] < -options.lost * np.abs(values).max() else count - 1
        if norm * abs(vectors[-1, pick]) <= options.settled * abs(values[pick]):
            break
    return float(values[pick]), np.asarray(vectors[:, pick] @ known), count
