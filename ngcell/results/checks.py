"""The checks of all scenes: each compares a number that should vanish with the size of what it is a part of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.report import Check, Scales
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.problem import Problem
from ngcell.problem.reports import checks, deepest_overlap
from ngcell.problem.state import State
from ngcell.results.certificate import LIMITS, Certificate, common_check
from ngcell.results.fields import jacobian_range
from ngcell.results.forces import ContactForces, body_resultants
from ngcell.results.overlap import deepest_overlap_of_bodies

Array = NDArray[np.float64]

#: Forces and energies of walls strained by less than this count as nothing when shares are taken.
_SMALL_STRAIN = 1e-4


class Account(Protocol):
    """Where energy went on the way to a step of a problem with a history; see `ngcell.solve.step.Account`."""

    @property
    def dissipation(self) -> float:
        """What was lost as the energy fell at held supports, since rest [stress * length**2]."""

    @property
    def mismatch_share(self) -> float:
        """Work minus the change of all energies and losses, over the energy that the step moved."""


@dataclass(frozen=True, eq=False)
class NodalForces:
    """Forces on the unknowns, each of shape (unknowns,) [stress * length].

    Attributes
    ----------
    internal : array of float
        Gradient of the stored energy.
    reaction : array of float
        What supports exert on the bodies.
    load : array of float
        What loads exert on the bodies.
    proximal : array of float
        What the proximal term that is left exerts on the bodies.
    """

    internal: Array
    reaction: Array
    load: Array
    proximal: Array


def scales_of(space: DisplacementSpace, modulus: float, stored: float) -> Scales:
    """Return what counts as nothing: force and energy of a wall of the softest shear modulus that is hardly strained."""
    volume, thickness = float(space.one @ space.scalar_mass @ space.one), space.bodies.thickness
    return Scales(_SMALL_STRAIN * modulus * thickness, _SMALL_STRAIN**2 * modulus * volume, thickness, stored)


def certify(
    problem: Problem,
    walls: Surface,
    state: State,
    nodal: NodalForces,
    forces: ContactForces,
    scales: Scales,
    *,
    unstored_work: float,
    account: Account | None = None,
) -> Certificate:
    """Judge a step.

    Parameters
    ----------
    problem : Problem
        What was solved: tied or released.
    walls : Surface
        All walls.
    state : State
        The accepted state.
    nodal : NodalForces
        Forces on the unknowns.
    forces : ContactForces
        Forces between bodies.
    scales : Scales
        What counts as nothing.
    unstored_work : float
        Work since the step before that is not stored [stress * length**2].
    account : Account, optional
        Where energy went, of a scene with a history.
    """
    space, parts = problem.space, problem.unknowns.lets_bodies_part
    held, loaded = body_resultants(space, nodal.reaction), body_resultants(space, nodal.load)
    largest = max(_largest(forces.force), _largest(held), scales.force)
    on_body = _largest(forces.on_body + held + loaded) if parts else 0.0
    # Released levels do not follow each other: their work is reported, and not judged.
    mismatch = 0.0 if parts else abs(unstored_work)
    common = {
        "residual": _residual(problem, state, nodal, scales),
        "penetration_over_wall": _penetration(problem, walls, state) / scales.thickness,
        "body_balance": on_body / largest,
        "plate_balance": float(np.linalg.norm((held + loaded).sum(0))) / largest,
        "smallest_jacobian": jacobian_range(space, state.at.displacement)[0],
        "stabilisation": _share(nodal.proximal, nodal.internal, scales),
        "work_mismatch": mismatch / scales.at_stake,
        **({} if account is None else {"energy_balance": account.mismatch_share}),
    }
    found: list[Check] = [common_check(name, value) for name, value in common.items()]
    return Certificate((*found, *checks(problem.terms, state.at, scales)))


def _largest(forces: Array) -> float:
    return float(np.linalg.norm(forces, axis=1).max(initial=0.0))


def _share(force: Array, internal: Array, scales: Scales) -> float:
    return float(np.linalg.norm(force)) / max(float(np.linalg.norm(internal)), scales.force)


def _residual(problem: Problem, state: State, nodal: NodalForces, scales: Scales) -> float:
    out_of_balance = problem.gradient(state) - problem.unknowns.gather(nodal.proximal)
    residual = _share(out_of_balance[problem.free], nodal.internal, scales)
    if residual <= LIMITS["residual"] or not problem.unknowns.lets_bodies_part or not np.isfinite(residual):
        return residual
    beyond = np.maximum(np.abs(out_of_balance) - _last_digits(problem, state), 0.0)
    return _share(beyond[problem.free], nodal.internal, scales)


def _last_digits(problem: Problem, state: State) -> Array:
    """Return the forces that the last digits of positions stand for: ``eps |K| |x|``, K with closed constraints."""
    line = problem.linearise(state)
    place = np.abs(state.positions).ravel()
    row, column = problem.pattern
    stiffness = np.abs(line.stiffness)
    force = np.bincount(row, stiffness * place[column], len(place))
    off = row != column
    force += np.bincount(column[off], (stiffness * place[row])[off], len(place))
    slopes = abs(line.jacobian)
    force += slopes.T @ (line.penalty * (line.gap < 0) * (slopes @ place))
    return np.asarray(np.finfo(float).eps * force)


def _penetration(problem: Problem, walls: Surface, state: State) -> float:
    """Return the deepest overlap [length], as contact sees it and from outlines.

    The tied solid has no contact: what it leaves untied, at rounded corners, may overlap.
    """
    seen = deepest_overlap(problem.terms, state.at)
    if seen is None:
        return 0.0
    return max(seen, deepest_overlap_of_bodies(problem.space, walls, state.positions))
