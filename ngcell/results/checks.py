"""The checks of a certificate: each a share, of what should be nothing in what is at stake."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ngcell.problem.assembly import Assembly
from ngcell.problem.state import State
from ngcell.results.certificate import LIMITS, Certificate, Check
from ngcell.results.fields import jacobian_range
from ngcell.results.forces import ContactForces, body_resultants
from ngcell.results.overlap import deepest_overlap_of_bodies

Array = NDArray[np.float64]

#: Forces and energies of walls strained by less than this count as nothing when shares are taken.
_SMALL_STRAIN = 1e-4


class Account(Protocol):
    """Where energy went on the way to a step of a problem with a memory; see `ngcell.solve.step.Account`."""

    @property
    def dissipation(self) -> float:
        """What was lost as the energy fell at held supports, since rest [stress * length**2]."""

    @property
    def mismatch(self) -> float:
        """Work minus the change of all energies and losses, since the step before [stress * length**2]."""

    @property
    def mismatch_share(self) -> float:
        """Its magnitude over the energy that the step moved."""


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
    proximal term : array of float
        What is left of the proximal term.
    """

    internal: Array
    reaction: Array
    load: Array
    proximal: Array


def certify(
    assembly: Assembly,
    state: State,
    nodal: NodalForces,
    forces: ContactForces,
    unstored_work: float,
    account: Account | None = None,
) -> Certificate:
    """Judge a step.

    Parameters
    ----------
    assembly : Assembly
        What was solved: tied or released.
    state : State
        The accepted state.
    nodal : NodalForces
        Forces on the unknowns.
    forces : ContactForces
        Forces between bodies.
    unstored_work : float
        Work since the step before that is not stored [stress * length**2].
    account : Account, optional
        Where energy went, with cohesion.
    """
    scale = _scales(assembly)
    return Certificate(
        (
            Check("residual", _residual(assembly, state, nodal, scale)),
            Check("penetration_over_wall", _penetration(assembly, state)),
            Check("tension", _tension(assembly, state)),
            Check("complementarity", _complementarity(assembly, state, scale)),
            *_conditions(assembly, state, scale),
            *_areas(assembly, state),
            Check("body_balance", _body_balance(assembly, forces, nodal, scale)),
            Check("plate_balance", _plate_balance(assembly, forces, nodal, scale)),
            Check("smallest_jacobian", jacobian_range(assembly, state.displacement)[0]),
            Check("stabilisation", _share(nodal.proximal, nodal.internal, scale)),
            Check("work_mismatch", _work_mismatch(assembly, unstored_work, state.energy, scale)),
            *(() if account is None else (Check("energy_balance", account.mismatch_share),)),
        )
    )


@dataclass(frozen=True)
class _Scales:
    """What counts as nothing: the force and the energy of a wall strained by `_SMALL_STRAIN`."""

    force: float
    energy: float


def _scales(assembly: Assembly) -> _Scales:
    modulus = min(law.shear_modulus for law in assembly.bulk.laws)
    space = assembly.space
    volume = float(space.one @ space.scalar_mass @ space.one)
    return _Scales(_SMALL_STRAIN * modulus * space.bodies.thickness, _SMALL_STRAIN**2 * modulus * volume)


def _share(force: Array, internal: Array, scale: _Scales) -> float:
    return float(np.linalg.norm(force)) / max(float(np.linalg.norm(internal)), scale.force)


def _residual(assembly: Assembly, state: State, nodal: NodalForces, scale: _Scales) -> float:
    out_of_balance = assembly.gradient(state) - assembly.gather(nodal.proximal)
    residual = _share(out_of_balance[assembly.free], nodal.internal, scale)
    if residual <= LIMITS["residual"] or state.contact is None or not np.isfinite(residual):
        return residual
    beyond = np.maximum(np.abs(out_of_balance) - _last_digits(assembly, state), 0.0)
    return _share(beyond[assembly.free], nodal.internal, scale)


def _last_digits(assembly: Assembly, state: State) -> Array:
    """Return the forces that the last digits of positions stand for: ``eps |K| |x|``, K with the closed penalty terms."""
    line = assembly.linearise(state)
    place = np.abs(assembly.positions(state.displacement)).ravel()
    row, column = assembly.pattern
    stiffness = np.abs(line.stiffness)
    force = np.bincount(row, stiffness * place[column], len(place))
    off = row != column
    force += np.bincount(column[off], (stiffness * place[row])[off], len(place))
    slopes = abs(line.jacobian)
    force += slopes.T @ (line.penalty * (line.gap < 0) * (slopes @ place))
    return np.asarray(np.finfo(float).eps * force)


def _penetration(assembly: Assembly, state: State) -> float:
    if assembly.contact is None or state.contact is None:
        return 0.0  # The tied solid has no contact: what it leaves untied, at rounded corners, may overlap.
    positions, walls = assembly.positions(state.displacement), assembly.contact.walls
    gaps = state.contact.kinematics.gaps(positions)
    seen = deepest_overlap_of_bodies(assembly.space, walls, positions)
    return max(-float(gaps.min(initial=0.0)), seen) / assembly.space.bodies.thickness


def _tension(assembly: Assembly, state: State) -> float:
    if state.contact is None:
        return 0.0
    normal_force = state.contact.contact_forces(assembly.positions(state.displacement))
    return max(0.0, -float(normal_force.min(initial=0.0)))


def _complementarity(assembly: Assembly, state: State, scale: _Scales) -> float:
    if state.contact is None:
        return 0.0
    positions = assembly.positions(state.displacement)
    work = state.contact.contact_forces(positions) @ state.contact.kinematics.gaps(positions)
    return abs(float(work)) / max(state.energy, scale.energy)


def _conditions(assembly: Assembly, state: State, scale: _Scales) -> tuple[Check, ...]:
    """Return the checks of a contact method's own conditions."""
    if state.contact is None:
        return ()
    missed = state.contact.missed(assembly.positions(state.displacement))
    units = {
        "weighted_overlap": assembly.space.bodies.thickness,
        "weighted_complementarity": max(state.energy, scale.energy),
    }
    return tuple(Check(name, value / units[name]) for name, value in missed.items())


def _areas(assembly: Assembly, state: State) -> tuple[Check, ...]:
    if assembly.fluid is None:
        return ()
    return (Check("lumen_area", assembly.fluid.missed(assembly.expand(state.displacement))),)


def _largest_force(forces: ContactForces, reaction_of_body: Array) -> float:
    sizes = [np.linalg.norm(forces.force, axis=1).max(initial=0.0)]
    sizes.append(np.linalg.norm(reaction_of_body, axis=1).max(initial=0.0))
    return float(max(sizes))


def _body_balance(assembly: Assembly, forces: ContactForces, nodal: NodalForces, scale: _Scales) -> float:
    if assembly.contact is None:
        return 0.0
    held, loaded = body_resultants(assembly, nodal.reaction), body_resultants(assembly, nodal.load)
    out_of_balance = np.linalg.norm(forces.on_body + held + loaded, axis=1).max()
    return float(out_of_balance) / max(_largest_force(forces, held), scale.force)


def _plate_balance(assembly: Assembly, forces: ContactForces, nodal: NodalForces, scale: _Scales) -> float:
    held, loaded = body_resultants(assembly, nodal.reaction), body_resultants(assembly, nodal.load)
    return float(np.linalg.norm((held + loaded).sum(0))) / max(_largest_force(forces, held), scale.force)


def _work_mismatch(assembly: Assembly, surplus: float, energy: float, scale: _Scales) -> float:
    """Return the unstored work over the energy; released levels do not follow each other, and are not judged by it."""
    return 0.0 if assembly.contact is not None else abs(surplus) / max(energy, scale.energy)
