"""From an accepted step to numbers: gaps, forces, energy, work, and the certificate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ngcell.mechanics.drive import Drive
from ngcell.mechanics.report import Check
from ngcell.problem.problem import Problem
from ngcell.problem.reports import columns
from ngcell.problem.state import State
from ngcell.results.certificate import Certificate
from ngcell.results.checks import Path, certify, scales_of
from ngcell.results.equilibrium import Setup, balance_of
from ngcell.results.forces import ContactForces

Array = NDArray[np.float64]


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
