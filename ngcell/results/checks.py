"""The checks of all scenes: each compares a number that should vanish with the size of what it is a part of."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.surface.edges import EdgeSurface
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.report import Check, Scales
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.term import Configuration, Role
from ngcell.problem.problem import Problem
from ngcell.problem.reports import checks, deepest_overlap
from ngcell.problem.state import State
from ngcell.results.certificate import LIMITS, Certificate, common_check
from ngcell.results.covered_twice import depth_in_itself, depth_in_others
from ngcell.results.forces import ContactForces
from ngcell.results.jacobian import smallest_jacobian
from ngcell.results.overlap import deepest_overlap_of_bodies
from ngcell.results.quadrature import quadrature_error

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
class Path:
    """How a step was reached.

    Attributes
    ----------
    follows : bool
        Whether it was reached from the state of the step before, of the same phase.
    tied : Configuration, optional
        The tied state at the same load that walls were released from.
    account : Account, optional
        Where energy went, of a scene with a history.
    lowest_curvature : float, optional
        Lowest eigenvalue of the tangent over the scale of curvatures; None where it was not sought.
    accuracy : float
        Relative error that is asked for, by which the path ends; infinite where none is estimated.
    """

    follows: bool = False
    tied: Configuration | None = None
    account: Account | None = None
    lowest_curvature: float | None = None
    accuracy: float = inf


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
    """Return what counts as nothing: force and energy of a wall of the softest shear modulus that is hardly strained.

    The section that bears the force is in the plane the thickness, and of a solid the thickness times a length: the
    side of a square of the area that a body has at its own thickness, of the body where it is shortest.
    """
    share, thickness = space.one * (space.scalar_mass @ space.one), space.bodies.thickness
    area = np.bincount(space.body_of_unknown, share, space.body_count) / space.bodies.thickness_of_body
    length = float(np.sqrt(area.min())) if space.dimension == 3 else 1.0
    force = _SMALL_STRAIN * modulus * thickness * length
    return Scales(force, _SMALL_STRAIN**2 * modulus * float(share.sum()), thickness, stored)


def certify(
    problem: Problem,
    walls: Surface,
    state: State,
    nodal: NodalForces,
    forces: ContactForces,
    scales: Scales,
    *,
    unstored_work: float,
    path: Path,
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
    path : Path
        How the state was reached.
    """
    space, parts = problem.space, problem.unknowns.lets_bodies_part
    held, loaded = space.resultants(nodal.reaction), space.resultants(nodal.load)
    largest = max(_largest(forces.force), _largest(held), scales.force)
    on_body = _largest(forces.on_body + held + loaded) if parts else 0.0
    common = {
        "residual": _residual(problem, state, nodal, scales),
        "penetration_over_wall": _penetration(problem, walls, state),
        "body_balance": on_body / largest,
        "plate_balance": _plate_balance(held, loaded, largest),
        "quadrature_error": quadrature_error(problem.terms, state.at) / scales.at_stake,
        "stabilisation": _stabilisation(nodal, scales),
        "work_mismatch": _work_mismatch(unstored_work, parts, path) / scales.at_stake,
        **({} if path.account is None else {"energy_balance": path.account.mismatch_share}),
        **({} if path.tied is None else {"energy_above_tied": _above(problem, state.at, path.tied) / scales.at_stake}),
        **({} if path.lowest_curvature is None else {"lowest_curvature": path.lowest_curvature}),
    }
    found: list[Check] = [common_check(name, value, accuracy=path.accuracy) for name, value in common.items()]
    found += [_smallest_jacobian(space, state), *_self_penetration(space, state)]
    return Certificate((*found, *checks(problem.terms, state.at, scales)))


def _plate_balance(held: Array, loaded: Array, largest: float) -> float:
    """Return the sum of support forces and loads on bodies, shape (bodies, dimension), over what goes through supports.

    That is the sum of the forces that point one way in each direction, from one plate to the other, or the largest
    force in play, if that is more.
    """
    through = float(np.linalg.norm(np.maximum(held, 0.0).sum(0)))
    return float(np.linalg.norm((held + loaded).sum(0))) / max(largest, through)


def _work_mismatch(unstored_work: float, parts: bool, path: Path) -> float:
    """Return the part of the work that is judged.

    The tied solid follows one path, on which all work is stored. Released walls may snap, and release energy; but
    energy that nothing supplied is wrong, where the state was reached from that before. Released states that are
    selected one by one, each from its own tied state or lifting, may be on different branches, and either may store
    more: there it is the tied state that bounds the energy, and the work between levels is reported only.
    """
    if not parts:
        return abs(unstored_work)
    return max(-unstored_work, 0.0) if path.follows else 0.0


def _above(problem: Problem, at: Configuration, tied: Configuration) -> float:
    """Return by how much the potential of the released walls is above that of the tied state [stress * length**2].

    The tied state meets the prescribed values of the released walls, whose potential V + C is minimised: V is what is
    stored, and the potential of loads and fluids, C >= 0 the energy of contact and bonds. From ``V + C <= V_tied +
    C_tied`` follows ``V <= V_tied + C_tied``. Tied walls touch, so that C_tied is small: what contact sees at corners,
    some of which are left untied. With multipliers C is zero at the released state, whose conditions hold, and not
    positive where walls do not overlap; then V_tied alone is the bound.
    """
    return max(_potential(problem, at) - _potential(problem, tied) - max(_interaction(problem, tied), 0.0), 0.0)


def _potential(problem: Problem, at: Configuration) -> float:
    return sum(term.value(at) for term in problem.terms if term.role is not Role.INTERACTION)


def _interaction(problem: Problem, at: Configuration) -> float:
    return sum(term.value(at) for term in problem.terms if term.role is Role.INTERACTION)


def _smallest_jacobian(space: DisplacementSpace, state: State) -> Check:
    found = smallest_jacobian(space, state.at.displacement)
    body = space.bodies.body_names[space.bodies.body_of_element[found.element]]
    at = ", ".join(f"{coordinate:.4g}" for coordinate in found.point)
    return common_check("smallest_jacobian", found.value, f"{body}, element {found.element}, about ({at}) at rest")


def _self_penetration(space: DisplacementSpace, state: State) -> tuple[Check, ...]:
    """Return how deep bodies lie in themselves; nothing in three dimensions, where that is not looked for."""
    if space.dimension == 3:
        return ()
    share, body = depth_in_itself(space, state.positions, space.bodies.thickness_of_body)
    place = space.bodies.body_names[body] if share > 0 else ""
    return (common_check("self_penetration_over_wall", share, place),)


def _largest(forces: Array) -> float:
    return float(np.linalg.norm(forces, axis=1).max(initial=0.0))


def _share(force: Array, internal: Array, scales: Scales) -> float:
    return float(np.linalg.norm(force)) / max(float(np.linalg.norm(internal)), scales.force)


def _stabilisation(nodal: NodalForces, scales: Scales) -> float:
    """Return the share of the forces in bodies that the proximal term takes.

    Where nothing is stored, a force that is nothing is none: bodies that slide out press each other less and less, and
    what the proximal term holds falls with that.
    """
    is_nothing = scales.is_unstrained and np.linalg.norm(nodal.proximal) <= scales.force_of_nothing
    return 0.0 if is_nothing else _share(nodal.proximal, nodal.internal, scales)


def _residual(problem: Problem, state: State, nodal: NodalForces, scales: Scales) -> float:
    out_of_balance = problem.gradient(state) - problem.unknowns.gather(nodal.proximal)
    residual = _share(out_of_balance[problem.free], nodal.internal, scales)
    if residual <= LIMITS["residual"] or not problem.unknowns.lets_bodies_part or not np.isfinite(residual):
        return residual
    beyond = np.maximum(np.abs(out_of_balance) - _last_digits(problem, state), 0.0)
    return _share(beyond[problem.free], nodal.internal, scales)


def _last_digits(problem: Problem, state: State) -> Array:
    """Return the forces that the last digits of positions stand for: ``eps |K| |x|``.

    K has the constraints that are closed, or open by no more than round-off.

    A gap is a sum over nodes: n terms of it are off by up to n eps times the sum of their magnitudes (Higham, Accuracy
    and Stability of Numerical Algorithms, 2002, section 3.1, doi:10.1137/1.9780898718027).
    """
    eps, line = np.finfo(float).eps, problem.linearise(state)
    place = np.abs(state.positions).ravel()
    row, column = problem.pattern
    stiffness = np.abs(line.stiffness)
    force = np.bincount(row, stiffness * place[column], len(place))
    off = row != column
    force += np.bincount(column[off], (stiffness * place[row])[off], len(place))
    slopes = abs(sparse.csr_array(line.jacobian))
    digits = np.diff(slopes.indptr) * (slopes @ place)
    force += slopes.T @ (line.penalty * (line.gap < eps * digits) * digits)
    return np.asarray(eps * force)


def _penetration(problem: Problem, walls: Surface, state: State) -> float:
    """Return the deepest overlap over the thickness of the thinner body, as contact sees it and from outlines.

    In three dimensions the tied solid has no contact: what it leaves untied, at rounded corners, may overlap.
    """
    thickness = problem.space.bodies.thickness_of_body
    seen = deepest_overlap(problem.terms, state.at, thickness)
    if seen is None:
        return 0.0
    space, at = problem.space, state.positions
    shared = depth_in_others(space, walls, at, thickness) if isinstance(walls, EdgeSurface) else 0.0
    return max(seen, deepest_overlap_of_bodies(space, walls, at, thickness), shared)
