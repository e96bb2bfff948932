"""From an accepted step to numbers: gaps, forces, energy, work, and the certificate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.pairing.facing import FacingWalls
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.report import Check
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Drive, Role
from ngcell.problem.problem import Problem
from ngcell.problem.reports import columns
from ngcell.problem.state import State
from ngcell.results.certificate import Certificate
from ngcell.results.checks import NodalForces, Path, certify, scales_of
from ngcell.results.error import Numbers
from ngcell.results.forces import ContactForces, body_resultants, contact_forces

Array = NDArray[np.float64]

#: A body is held by nothing if the contacts press it no more than this multiple of what the proximal term pulls.
HELD = 10.0
#: A wall counts as open where its gap exceeds this share of the wall's thickness.
OPEN = 1e-2


@dataclass(frozen=True, eq=False)
class Setup:
    """What measurements need to know of a scene: the walls, who faces whom, and the supports.

    Attributes
    ----------
    walls : Surface
        All walls.
    facing : FacingWalls
        Pairs that face each other at rest.
    motion : PrescribedMotion
        The supports.
    moved : str
        Region of the support whose force and displacement are reported; a regular expression.
    prescribed_displacement : array of float, shape (dimension,)
        Displacement of that support at load factor 1 [length].
    modulus : float
        Shear modulus of the softest wall [stress].
    """

    walls: Surface
    facing: FacingWalls
    motion: PrescribedMotion
    moved: str
    prescribed_displacement: Array
    modulus: float


@dataclass(frozen=True)
class WorkPoint:
    """What the work from one accepted step to the next is reckoned from.

    Attributes
    ----------
    load_factor, energy : float
        Load factor [1] and stored energy [stress * length**2].
    support_work_rate : float
        Work of all supports per unit of load factor [stress * length**2].
    drives : tuple of Drive
        How driven terms take in work.
    """

    load_factor: float = 0.0
    energy: float = 0.0
    support_work_rate: float = 0.0
    drives: tuple[Drive, ...] = ()


@dataclass(frozen=True, eq=False)
class Measurement:
    """Numbers of one accepted step; gaps open > 0, forces of the moved support on the tissue.

    Attributes
    ----------
    gap : array of float, shape (facing points,)
        Gap of each facing point [length].
    forces : ContactForces
        Forces between bodies.
    plate_force : array of float, shape (dimension,)
        Force of the moved support [stress * length].
    unstored_work : float
        Work of supports and loads since the step before that is not stored, beyond what quadrature explains: not
        zero where this step's walls have taken another branch of equilibria [stress * length**2].
    free_bodies : tuple of int
        Bodies held by nothing.
    certificate : Certificate
        The verdict.
    reaction : array of float, shape (unknowns,)
        Nodal forces of the supports on the bodies [stress * length].
    work : WorkPoint
        What the work to the next step is reckoned from.
    columns : dict of str to float
        What terms report for the table of steps.
    dissipation : float
        Energy that was lost as walls snapped or bonds softened at held supports [stress * length**2].
    """

    gap: Array
    forces: ContactForces
    plate_force: Array
    unstored_work: float
    free_bodies: tuple[int, ...]
    certificate: Certificate
    reaction: Array
    work: WorkPoint
    columns: dict[str, float] = field(default_factory=dict)
    dissipation: float = 0.0

    @property
    def load_factor(self) -> float:
        """Load factor of the step."""
        return self.work.load_factor

    @property
    def energy(self) -> float:
        """Stored energy [stress * length**2]."""
        return self.work.energy


class Held(Protocol):
    """What holds floating bodies; see `ngcell.solve.proximal.ProximalTerm`."""

    def value(self, displacement: Array, mass: sparse.csr_array) -> float:
        """Return its energy."""

    def gradient(self, displacement: Array, mass: sparse.csr_array) -> Array:
        """Return its gradient."""


@dataclass(frozen=True, eq=False)
class Balance:
    """The forces in a state, and the gaps between walls.

    Attributes
    ----------
    gap : array of float, shape (facing points,)
        Gap of each facing point [length].
    nodal : NodalForces
        Forces on the unknowns.
    forces : ContactForces
        Forces between bodies.
    free_bodies : tuple of int
        Bodies held by nothing.
    """

    gap: Array
    nodal: NodalForces
    forces: ContactForces
    free_bodies: tuple[int, ...]


def balance_of(setup: Setup, problem: Problem, state: State, proximal_force: Array) -> Balance:
    """Return forces and gaps in a state; `proximal_force` is what the proximal term exerts on the bodies."""
    at = state.at
    internal, load = problem.force(at, Role.INTERNAL), -problem.force(at, Role.LOAD)
    # Supports bear what internal, contact, load and proximal forces leave.
    left = internal + problem.force(at, Role.INTERACTION) - load - proximal_force
    forces = contact_forces(problem, state)
    return Balance(
        gap=setup.facing.gaps(setup.walls, setup.walls.nodes(at.positions)),
        nodal=NodalForces(internal, problem.unknowns.reactions(left), load, proximal_force),
        forces=forces,
        free_bodies=_held_by_nothing(problem, setup, forces, proximal_force),
    )


def numbers_of(setup: Setup, problem: Problem, state: State, proximal: Held) -> Numbers:
    """Return the numbers of a state, held by a proximal term, that errors are estimated for."""
    at = state.displacement
    balance = balance_of(setup, problem, state, -proximal.gradient(at, problem.mass))
    thickness, proximal_energy = problem.space.bodies.thickness, proximal.value(at, problem.mass)
    energy, held = state.energy - problem.unstored(state.at), setup.facing.between_held(balance.free_bodies)
    scales = scales_of(problem.space, setup.modulus, energy)
    force = max(scales.force, float(np.linalg.norm(balance.forces.force, axis=1).max(initial=0.0)))
    mean, largest = mean_and_largest(setup.facing, balance.gap, held)
    return Numbers(
        energy=energy,
        plate_force=setup.motion.resultant(balance.nodal.reaction, setup.moved),
        contact_force=balance.forces.total,
        mean_gap=mean,
        largest_gap=largest,
        scales=(scales.energy, force, OPEN * thickness),
        besides=problem.overlap_work(state.at) / 2 + proximal_energy,
    )


def mean_and_largest(facing: FacingWalls, gap: Array, chosen: NDArray[np.bool_]) -> tuple[float, float]:
    """Return mean and largest gap over chosen facing points [length]; 0 where there are none, or all overlap."""
    weight = facing.weight * chosen
    mean = float(weight @ gap / weight.sum()) if weight.any() else 0.0
    return mean, float(gap[chosen].max(initial=0.0))


def measure(
    setup: Setup,
    problem: Problem,
    state: State,
    *,
    load_factor: float,
    proximal_force: Array,
    before: WorkPoint | None,
    path: Path | None = None,
    judged: Sequence[Check] = (),
) -> Measurement:
    """Measure an accepted step.

    Parameters
    ----------
    setup : Setup
        The walls and supports.
    problem : Problem
        What was solved: tied or released.
    state : State
        The accepted state.
    load_factor : float
        In [0, 1].
    proximal_force : array of float, shape (unknowns,)
        Nodal forces that the proximal term exerts on the bodies [stress * length].
    before : WorkPoint, optional
        The accepted step before, of the same phase, or rest; None where no equilibrium before this one is known, and
        so no work to it.
    path : Path, optional
        How the state was reached; by default nothing is known of it.
    judged : sequence of Check
        What else is judged.
    """
    path = path or Path()
    account = path.account
    at = state.at
    balance = balance_of(setup, problem, state, proximal_force)
    reaction, forces = balance.nodal.reaction, balance.forces
    work = WorkPoint(
        load_factor,
        state.energy - problem.unstored(at),
        float(reaction @ setup.motion.rate(load_factor)),
        problem.drives(state.displacement, load_factor),
    )
    surplus = 0.0 if account is not None or before is None else _surplus_of_work(before, work)
    certificate = certify(
        problem,
        setup.walls,
        state,
        balance.nodal,
        forces,
        scales_of(problem.space, setup.modulus, work.energy),
        unstored_work=surplus,
        path=path,
    )
    return Measurement(
        gap=balance.gap,
        forces=forces,
        plate_force=setup.motion.resultant(reaction, setup.moved),
        unstored_work=surplus,
        free_bodies=balance.free_bodies,
        certificate=Certificate((*certificate.checks, *judged)),
        reaction=reaction,
        work=work,
        columns=columns(problem.terms, at),
        dissipation=0.0 if account is None else account.dissipation,
    )


def _surplus_of_work(old: WorkPoint, now: WorkPoint) -> float:
    """Return the work of supports and loads minus the change of energy, as far as quadrature does not explain it.

    The work is taken by the trapezoidal rule, which for a monotonic force errs by at most half of the force's
    change times the step. A surplus is energy that was released when walls snapped to another equilibrium. A deficit is
    energy from nowhere where states follow each other; where each is selected by itself, both are a change of branch.
    """
    step = now.load_factor - old.load_factor
    work = step * (now.support_work_rate + old.support_work_rate) / 2
    allowed = abs(step * (now.support_work_rate - old.support_work_rate)) / 2
    for number, drive in enumerate(now.drives):
        before = old.drives[number] if old.drives else Drive(0.0, 0.0, 0.0)
        fall, shared = before.potential - drive.potential, drive.share - before.share
        work += (drive.share + before.share) / 2 * fall + shared * (drive.rate + before.rate) / 2
        allowed += abs(shared) * (abs(fall) + abs(drive.rate - before.rate)) / 2
    mismatch = work - (now.energy - old.energy)
    return float(np.sign(mismatch) * max(abs(mismatch) - allowed, 0.0))


def _held_by_nothing(problem: Problem, setup: Setup, forces: ContactForces, proximal_force: Array) -> tuple[int, ...]:
    if not problem.unknowns.lets_bodies_part:
        return ()
    pull = np.linalg.norm(body_resultants(problem.space, proximal_force), axis=1)
    free = forces.pressed <= HELD * pull
    free[np.unique(problem.space.body_of_unknown[setup.motion.fixed.any(0)])] = False
    return tuple(int(body) for body in np.flatnonzero(free))
