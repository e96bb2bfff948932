"""From an accepted step to numbers: gaps, forces, energy, and the certificate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.pairing.facing import FacingWalls
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.near import components
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.problem.assembly import Assembly
from ngcell.problem.state import State
from ngcell.results.certificate import Certificate
from ngcell.results.checks import Account, NodalForces, certify
from ngcell.results.forces import ContactForces, body_resultants, contact_forces
from ngcell.results.record import WallRecord

Array = NDArray[np.float64]

#: A wall counts as open where its gap exceeds this share of the wall's thickness.
OPEN = 1e-2
#: A body is held by nothing if the contacts press it no more than this multiple of what the proximal term pulls.
HELD = 10.0


@dataclass(frozen=True, eq=False)
class Scene:
    """What measurements need to know: the walls, who faces whom, and the supports.

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
    prescribed displacement : array of float, shape (dimension,)
        Displacement of that support at load factor 1 [length].
    """

    walls: Surface
    facing: FacingWalls
    motion: PrescribedMotion
    moved: str
    prescribed_displacement: Array


@dataclass(frozen=True)
class WorkPoint:
    """What the work from one accepted step to the next is reckoned from; see `Measurement`."""

    load_factor: float
    load_share: float
    energy: float
    support_work_rate: float
    load_potential: float
    filling_rate: float


@dataclass(frozen=True, eq=False)
class Measurement:
    """Numbers of one accepted step; gaps open > 0, forces of the moved support on the tissue.

    Attributes
    ----------
    load_factor, energy : float
        Load factor [1] and stored energy [stress * length**2].
    gap : array of float, shape (facing points,)
        Gap of each facing point [length].
    forces : ContactForces
        Forces between bodies.
    plate_force : array of float, shape (dimension,)
        Force of the moved support [stress * length].
    support_work_rate : float
        Work of all supports per unit of load factor [stress * length**2].
    load_potential : float
        Potential of the loads as they are at load factor 1 [stress * length**2]; falls as they do work.
    load_share : float
        Share of these loads that acts.
    unstored_work : float
        Work of supports and loads since the step before that is not stored, beyond what quadrature explains: not
        zero where this step's walls have taken another branch of equilibria [stress * length**2].
    free_bodies : tuple of int
        Bodies held by nothing.
    certificate : Certificate
        The verdict.
    reaction : array of float, shape (unknowns,)
        Nodal forces of the supports on the bodies [stress * length].
    filling_rate : float
        Work for each unit of the loads' share that filling up fluids takes [stress * length**2].
    separation_energy : float
        Energy of separation that bonds do not give back [stress * length**2]; 0 without cohesion.
    bonded_share : float
        Share of the bonded length that has not been opened beyond its strength; 0 without cohesion.
    dissipation : float
        Energy that was lost as walls snapped or bonds softened at held supports [stress * length**2].
    """

    load_factor: float
    energy: float
    gap: Array
    forces: ContactForces
    plate_force: Array
    support_work_rate: float
    load_potential: float
    load_share: float
    unstored_work: float
    free_bodies: tuple[int, ...]
    certificate: Certificate
    reaction: Array
    filling_rate: float = 0.0
    separation_energy: float = 0.0
    bonded_share: float = 0.0
    dissipation: float = 0.0

    @property
    def work(self) -> WorkPoint:
        """What the work to the next step is reckoned from."""
        return WorkPoint(
            self.load_factor,
            self.load_share,
            self.energy,
            self.support_work_rate,
            self.load_potential,
            self.filling_rate,
        )

    def opened_share(self, facing: FacingWalls, thickness: float) -> float:
        """Return the share of the facing wall length that is open, in [0, 1]."""
        is_open = self.gap > OPEN * thickness
        return float(facing.weight @ is_open / max(facing.weight.sum(), np.finfo(float).tiny))


def measure(
    scene: Scene,
    assembly: Assembly,
    state: State,
    *,
    load_factor: float,
    proximal_force: Array,
    before: WorkPoint | None,
    account: Account | None = None,
) -> Measurement:
    """Measure an accepted step.

    Parameters
    ----------
    scene : Scene
        The walls and supports.
    assembly : Assembly
        What was solved: tied or released.
    state : State
        The accepted state.
    load_factor : float
        In [0, 1].
    proximal_force : array of float, shape (unknowns,)
        Nodal forces that the proximal term exerts on the bodies [stress * length].
    before : WorkPoint, optional
        The accepted step before, of the same phase.
    account : Account, optional
        Where energy went, where that is known better than from the step before.
    """
    displacement = assembly.expand(state.displacement)
    positions = assembly.positions(displacement)
    nodes = scene.walls.nodes(positions)
    gap = scene.facing.gaps(scene.walls, nodes)
    loads = assembly.bulk.loads
    applied = np.zeros_like(displacement) if loads is None else -loads.gradient(displacement)
    internal = assembly.bulk.gradient(displacement) + applied
    fluid = assembly.fluid
    filling_rate = 0.0
    if fluid is not None:
        applied = applied - fluid.gradient(displacement)
        filling_rate = fluid.filling_rate(displacement)
    contact = assembly.contact_force(state)
    if assembly.bonds is not None:
        contact = contact + assembly.bonds.gradient(positions)
    # Supports have what internal, contact, bond, load and proximal term forces leave.
    reaction = assembly.reactions(internal + contact - applied - proximal_force)
    work_rate = float(reaction @ scene.motion.rate(load_factor))
    forces = contact_forces(assembly, state)
    plate_force = scene.motion.resultant(reaction, scene.moved)
    free = _held_by_nothing(assembly, scene, forces, proximal_force) if assembly.contact is not None else ()
    load_potential = 0.0 if loads is None else loads.potential(displacement, 1.0)
    acting = loads or fluid
    load_share = 0.0 if acting is None else acting.share(load_factor)
    work = WorkPoint(load_factor, load_share, state.energy, work_rate, load_potential, filling_rate)
    surplus = 0.0 if account is not None else _surplus_of_work(before, work)
    nodal = NodalForces(internal, reaction, applied, proximal_force)
    certificate = certify(assembly, state, nodal, forces, surplus, account)
    return Measurement(
        load_factor,
        state.energy,
        gap,
        forces,
        plate_force,
        work_rate,
        load_potential,
        load_share,
        surplus,
        free,
        certificate,
        reaction,
        filling_rate,
        *_of_bonds(assembly, positions),
        dissipation=0.0 if account is None else account.dissipation,
    )


def pair_gaps(facing: FacingWalls, measured: Measurement) -> Array:
    """Return the mean gap of each facing pair [length]."""
    count = len(facing.pairs)
    length = np.bincount(facing.pair, facing.weight, count)
    return np.bincount(facing.pair, facing.weight * measured.gap, count) / length


def wall_records(scene: Scene, measured: Measurement, step: int, thickness: float, onset: Array) -> list[WallRecord]:
    """Return a row for each facing pair of a step; `onset` is where each has opened, shape (pairs,)."""
    facing, component = scene.facing, cell_components(scene, measured, thickness)
    count = len(facing.pairs)
    is_open = measured.gap > OPEN * thickness
    largest = np.full(count, -np.inf)
    np.maximum.at(largest, facing.pair, measured.gap)
    length = np.bincount(facing.pair, facing.weight, count)
    mean = pair_gaps(facing, measured)
    share = np.bincount(facing.pair, facing.weight * is_open, count) / length
    parted = parted_pairs(scene, measured, thickness)
    force = measured.forces.between(facing.pairs)
    return [
        WallRecord(
            step=step,
            load_factor=measured.load_factor,
            cell_a=int(one),
            cell_b=int(two),
            largest_gap=float(largest[pair]),
            mean_gap=float(mean[pair]),
            force=float(force[pair]),
            opened_share=float(share[pair]),
            parted=bool(parted[pair]),
            component=int(component[one]),
            onset=float(onset[pair]),
        )
        for pair, (one, two) in enumerate(facing.pairs)
    ]


def parted_pairs(scene: Scene, measured: Measurement, thickness: float) -> NDArray[np.bool_]:
    """Return which facing pairs are apart along the whole middle half of the wall, shape (pairs,)."""
    facing = scene.facing
    closed = facing.is_middle & (measured.gap <= OPEN * thickness)
    return np.asarray(np.bincount(facing.pair[closed], minlength=len(facing.pairs)) == 0)


def cell_components(scene: Scene, measured: Measurement, thickness: float) -> NDArray[np.int64]:
    """Return the component that each body belongs to, shape (bodies,): bodies joined by walls that have not parted."""
    joined = scene.facing.pairs[~parted_pairs(scene, measured, thickness)]
    return components(len(measured.forces.on_body), joined[:, 0], joined[:, 1])


def _of_bonds(assembly: Assembly, positions: Array) -> tuple[float, float]:
    """Return the energy of separation and the share of length that is still bonded."""
    bonds = assembly.bonds
    if bonds is None:
        return 0.0, 0.0
    return bonds.spent(positions), 1 - float(bonds.weight @ bonds.broken(positions) / bonds.weight.sum())


def _surplus_of_work(before: WorkPoint | None, now: WorkPoint) -> float:
    """Return the work of supports and loads minus the change of energy, as far as quadrature does not explain it.

    The work is taken by the trapezoidal rule, which for a monotonic force errs by at most half of the force's
    change times the step. A surplus is energy that was released when walls snapped to another equilibrium; a deficit is
    energy from nowhere, and never right.
    """
    old = before or WorkPoint(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    step, shared = now.load_factor - old.load_factor, now.load_share - old.load_share
    fall = old.load_potential - now.load_potential
    work = step * (now.support_work_rate + old.support_work_rate) / 2
    work += (now.load_share + old.load_share) / 2 * fall + shared * (now.filling_rate + old.filling_rate) / 2
    mismatch = work - (now.energy - old.energy)
    spread = abs(shared) * (abs(fall) + abs(now.filling_rate - old.filling_rate))
    allowed = (abs(step * (now.support_work_rate - old.support_work_rate)) + spread) / 2
    return float(np.sign(mismatch) * max(abs(mismatch) - allowed, 0.0))


def _held_by_nothing(assembly: Assembly, scene: Scene, forces: ContactForces, proximal_force: Array) -> tuple[int, ...]:
    pull = np.linalg.norm(body_resultants(assembly, proximal_force), axis=1)
    supported = np.unique(assembly.space.body_of_unknown[scene.motion.fixed.any(0)])
    free = forces.pressed <= HELD * pull
    free[supported] = False
    return tuple(int(body) for body in np.flatnonzero(free))
