"""From an accepted step to numbers: gaps, forces, energy, and the certificate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ngcell.contact.assembly import Assembly, State
from ngcell.contact.facing import FacingWalls
from ngcell.contact.walls import Walls
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.results.certificate import Certificate, Check
from ngcell.results.fields import jacobian_range
from ngcell.results.forces import ContactForces, body_resultants, contact_forces
from ngcell.results.overlap import deepest_overlap
from ngcell.results.record import WallRecord

Array = NDArray[np.float64]

#: A wall counts as open where its gap exceeds this share of the wall's thickness.
OPEN = 1e-2
#: A body is held by nothing if the contacts press it no more than this multiple of what the tether pulls.
HELD = 10.0
#: Forces and energies of walls strained by less than this count as nothing when shares are taken.
_SMALL_STRAIN = 1e-4


@dataclass(frozen=True, eq=False)
class Scene:
    """What measurements need to know: the walls, who faces whom, and the supports.

    Attributes
    ----------
    walls : Walls
        All walls.
    facing : FacingWalls
        Pairs that face each other at rest.
    motion : PrescribedMotion
        The supports.
    moved : str
        Region of the support whose force and displacement are reported; a regular expression.
    travel : array of float, shape (dimension,)
        Displacement of that support at load factor 1 [length].
    """

    walls: Walls
    facing: FacingWalls
    motion: PrescribedMotion
    moved: str
    travel: Array


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
    unstored_work : float
        Work of the supports since the step before that is not stored, as far as quadrature does not explain it: not
        zero where this step's walls have taken another branch of equilibria [stress * length**2].
    free_bodies : tuple of int
        Bodies held by nothing.
    certificate : Certificate
        The verdict.
    """

    load_factor: float
    energy: float
    gap: Array
    forces: ContactForces
    plate_force: Array
    support_work_rate: float
    unstored_work: float
    free_bodies: tuple[int, ...]
    certificate: Certificate

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
    tether_force: Array,
    before: Measurement | None,
) -> Measurement:
    """Measure an accepted step.

    Parameters
    ----------
    scene : Scene
        The walls and supports.
    assembly : Assembly
        What was solved: compact or released.
    state : State
        The accepted state.
    load_factor : float
        In [0, 1].
    tether_force : array of float, shape (unknowns,)
        Nodal forces that the tether exerts on the bodies [stress * length].
    before : Measurement, optional
        The accepted step before, of the same phase.
    """
    displacement = assembly.expand(state.displacement)
    positions = assembly.positions(displacement)
    nodes = scene.walls.nodes(positions)
    gap = scene.facing.gaps(scene.walls, nodes)
    internal = assembly.bulk.gradient(displacement)
    contact = assembly.contact_force(state)
    # Supports carry what internal, contact and tether forces leave.
    reaction = assembly.reactions(internal + contact - tether_force)
    work_rate = float(reaction @ scene.motion.imposed(np.zeros_like(reaction), 1.0))
    forces = contact_forces(assembly, state)
    plate_force = scene.motion.resultant(reaction, scene.moved)
    free = _held_by_nothing(assembly, scene, forces, tether_force) if assembly.contact is not None else ()
    scale = _scales(assembly)
    surplus = _surplus_of_work(before, load_factor, state.energy, work_rate)
    certificate = Certificate(
        (
            Check("residual", _residual(assembly, state, tether_force, internal, scale)),
            Check("penetration_over_wall", _penetration(scene, assembly, state, nodes)),
            Check("tension", _tension(assembly, state)),
            Check("complementarity", _complementarity(assembly, state, scale)),
            Check("body_balance", _body_balance(assembly, forces, reaction, scale)),
            Check("plate_balance", _plate_balance(assembly, forces, reaction, scale)),
            Check("smallest_jacobian", jacobian_range(assembly, state.displacement)[0]),
            Check("stabilisation", _stabilisation(tether_force, internal, scale)),
            Check("work_mismatch", _work_mismatch(assembly, surplus, state.energy, scale)),
        )
    )
    return Measurement(
        load_factor, state.energy, gap, forces, plate_force, work_rate, surplus, free, certificate
    )


def wall_records(scene: Scene, measured: Measurement, step: int, thickness: float) -> list[WallRecord]:
    """Return a row for each facing pair of a step."""
    facing, clump = scene.facing, measured.forces.clumps()
    count = len(facing.pairs)
    is_open = measured.gap > OPEN * thickness
    largest = np.full(count, -np.inf)
    np.maximum.at(largest, facing.pair, measured.gap)
    length = np.bincount(facing.pair, facing.weight, count)
    mean = np.bincount(facing.pair, facing.weight * measured.gap, count) / length
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
            clump=int(clump[one]),
        )
        for pair, (one, two) in enumerate(facing.pairs)
    ]


def parted_pairs(scene: Scene, measured: Measurement, thickness: float) -> NDArray[np.bool_]:
    """Return which facing pairs are apart along the whole middle half of the wall, shape (pairs,)."""
    facing = scene.facing
    closed = facing.is_middle & (measured.gap <= OPEN * thickness)
    return np.asarray(np.bincount(facing.pair[closed], minlength=len(facing.pairs)) == 0)


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


def _residual(
    assembly: Assembly, state: State, tether_force: Array, internal: Array, scale: _Scales
) -> float:
    out_of_balance = (assembly.gradient(state) - assembly.gather(tether_force))[assembly.free]
    return float(np.linalg.norm(out_of_balance)) / max(float(np.linalg.norm(internal)), scale.force)


def _stabilisation(tether_force: Array, internal: Array, scale: _Scales) -> float:
    return float(np.linalg.norm(tether_force)) / max(float(np.linalg.norm(internal)), scale.force)


def _penetration(scene: Scene, assembly: Assembly, state: State, nodes: Array) -> float:
    if state.contact is None:
        return 0.0  # The compact solid has no contact: what it leaves untied, at rounded corners, may overlap.
    deepest = 0.0
    if len(state.contact.stiffness):
        gaps = state.contact.kinematics.gaps(assembly.positions(state.displacement))
        deepest = max(0.0, -float(gaps.min()))
    return max(deepest, deepest_overlap(scene.walls, nodes)) / assembly.space.bodies.thickness


def _tension(assembly: Assembly, state: State) -> float:
    if state.contact is None or not len(state.contact.stiffness):
        return 0.0
    pressure = state.contact.pressures(assembly.positions(state.displacement))
    return max(0.0, -float(pressure.min())) / min(law.shear_modulus for law in assembly.bulk.laws)


def _complementarity(assembly: Assembly, state: State, scale: _Scales) -> float:
    if state.contact is None:
        return 0.0
    gaps = np.minimum(state.contact.kinematics.gaps(assembly.positions(state.displacement)), 0)
    return float((state.contact.stiffness * gaps**2).sum()) / max(state.energy, scale.energy)


def _largest_force(forces: ContactForces, reaction_of_body: Array) -> float:
    sizes = [np.linalg.norm(forces.force, axis=1).max(initial=0.0)]
    sizes.append(np.linalg.norm(reaction_of_body, axis=1).max(initial=0.0))
    return float(max(sizes))


def _body_balance(
    assembly: Assembly, forces: ContactForces, reaction: Array, scale: _Scales
) -> float:
    if assembly.contact is None:
        return 0.0
    held = body_resultants(assembly, reaction)
    out_of_balance = np.linalg.norm(forces.on_body + held, axis=1).max()
    return float(out_of_balance) / max(_largest_force(forces, held), scale.force)


def _plate_balance(
    assembly: Assembly, forces: ContactForces, reaction: Array, scale: _Scales
) -> float:
    held = body_resultants(assembly, reaction)
    return float(np.linalg.norm(held.sum(0))) / max(_largest_force(forces, held), scale.force)


def _surplus_of_work(before: Measurement | None, load_factor: float, energy: float, work_rate: float) -> float:
    """Return the work of the supports minus the change of energy, as far as quadrature does not explain it.

    The work is taken by the trapezoidal rule, which for a monotonic force errs by at most half of the force's
    change times the step. A surplus is energy that was released when walls snapped to another equilibrium; a deficit is
    energy from nowhere, and never right.
    """
    load, old_energy, old_rate = (
        (before.load_factor, before.energy, before.support_work_rate) if before else (0.0, 0.0, 0.0)
    )
    step = load_factor - load
    mismatch = step * (work_rate + old_rate) / 2 - (energy - old_energy)
    allowed = step * abs(work_rate - old_rate) / 2
    return float(np.sign(mismatch) * max(abs(mismatch) - allowed, 0.0))


def _work_mismatch(assembly: Assembly, surplus: float, energy: float, scale: _Scales) -> float:
    """Return the unstored work over the energy; released levels do not follow each other, and are not judged by it."""
    return 0.0 if assembly.contact is not None else abs(surplus) / max(energy, scale.energy)


def _held_by_nothing(
    assembly: Assembly, scene: Scene, forces: ContactForces, tether_force: Array
) -> tuple[int, ...]:
    pull = np.linalg.norm(body_resultants(assembly, tether_force), axis=1)
    supported = np.unique(assembly.space.body_of_unknown[scene.motion.fixed.any(0)])
    free = forces.pressed <= HELD * pull
    free[supported] = False
    return tuple(int(body) for body in np.flatnonzero(free))
