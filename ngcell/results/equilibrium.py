"""The forces in a state and the gaps between walls, and the numbers of it that errors are estimated for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from ngcell.contact.pairing.facing import FacingWalls
from ngcell.contact.surface.surface import Surface
from ngcell.mechanics.report import Scales
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.term import Role
from ngcell.problem.problem import Problem
from ngcell.problem.state import State
from ngcell.results.certificate import LIMITS
from ngcell.results.checks import NodalForces, scales_of
from ngcell.results.error import Numbers
from ngcell.results.forces import ContactForces, contact_forces
from ngcell.results.gaps_of_pairs import gaps_of_pairs
from ngcell.results.growth import ONSET
from ngcell.results.quadrature import quadrature_error
from ngcell.results.rupture.strength import WallStrength

Array = NDArray[np.float64]

#: A body is held by nothing if the contacts press it no more than this multiple of what the proximal term pulls.
HELD = 10.0
#: A body that is pressed between two others may press both with so many times that: as a wedge of 39 degrees does.
_WEDGED = 3.0
#: A wall counts as open where its gap exceeds this share of the wall's thickness.
OPEN = 1e-2
#: Share of the force in play below which walls do not press on each other.
_NO_FORCE = 1e-12


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
    accuracy : float
        Relative error by which the path of released walls ends; infinite where it goes to its own end.
    strength : WallStrength, optional
        What walls bear; by default nobody says it, and nothing of rupture is reported.
    """

    walls: Surface
    facing: FacingWalls
    motion: PrescribedMotion
    moved: str
    prescribed_displacement: Array
    modulus: float
    accuracy: float
    strength: WallStrength | None = None


class Held(Protocol):
    """What holds floating bodies; see `ngcell.solve.proximal.ProximalTerm`."""

    def value(self, displacement: Array, metric: sparse.csr_array) -> float:
        """Return its energy."""

    def gradient(self, displacement: Array, metric: sparse.csr_array) -> Array:
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
    forces, reaction = contact_forces(problem, state), problem.unknowns.reactions(left)
    scales = scales_of(problem.space, setup.modulus, state.energy - problem.unstored(at))
    return Balance(
        gap=setup.facing.gaps(setup.walls, setup.walls.nodes(at.positions)),
        nodal=NodalForces(internal, reaction, load, proximal_force),
        forces=forces,
        free_bodies=_held_by_nothing(problem, setup, scales, forces, proximal_force, left - reaction),
    )


def numbers_of(setup: Setup, problem: Problem, state: State, proximal: Held, to_fall: float = 0.0) -> Numbers:
    """Return the numbers of a state, held by a proximal term, that errors are estimated for.

    By `to_fall` [energy] the energy may fall while bodies that hardly anything holds move on.
    """
    at, displacement = state.displacement, state.at.displacement
    pull = -proximal.gradient(at, problem.metric)
    balance = balance_of(setup, problem, state, pull)
    proximal_energy = proximal.value(at, problem.metric)
    energy, held = state.energy - problem.unstored(state.at), setup.facing.between_held(balance.free_bodies)
    scales = scales_of(problem.space, setup.modulus, energy)
    # Pressures all around a body have no resultant.
    force = max(scales.force, float(balance.forces.normal.max(initial=0.0)))
    mean, largest = mean_and_largest(setup.facing, balance.gap, held)
    overlap_work = problem.overlap_work(state.at)
    between = sum(term.overlap_work(state.at) for term in problem.terms if term.overlap(state.at) is not None)
    return Numbers(
        potential=state.energy + overlap_work / 2,  # without what penalty terms take
        energy=energy,
        plate_force=setup.motion.resultant(balance.nodal.reaction, setup.moved),
        contact_force=balance.forces.total,
        mean_gap=mean,
        largest_gap=largest,
        scales=(scales.energy, force, ONSET * _thinnest(setup, problem)),
        besides=overlap_work + proximal_energy + quadrature_error(problem.terms, state.at) + max(to_fall, 0.0),
        overlap=between / max(float(balance.forces.normal.sum()), force * _NO_FORCE),
        gaps=gaps_of_pairs(setup.facing, balance.gap, balance.free_bodies),
        utilisation=0.0 if setup.strength is None else setup.strength.utilisation(problem.terms, displacement).largest,
        pulled=float(np.linalg.norm(problem.resultants(pull).sum(0))),
    )


def _thinnest(setup: Setup, problem: Problem) -> float:
    """Return the thickness of the thinnest body that faces another [length]: bodies far away set no scale of gaps."""
    thickness = setup.facing.thickness
    return float(thickness.min()) if len(thickness) else problem.space.bodies.thickness


def mean_and_largest(facing: FacingWalls, gap: Array, chosen: NDArray[np.bool_]) -> tuple[float, float]:
    """Return mean and largest gap over chosen facing points [length]; 0 where there are none, or all overlap."""
    weight = facing.weight * chosen
    mean = float(weight @ gap / weight.sum()) if weight.any() else 0.0
    return mean, float(gap[chosen].max(initial=0.0))


def _held_by_nothing(
    problem: Problem, setup: Setup, scales: Scales, forces: ContactForces, proximal_force: Array, unbalanced: Array
) -> tuple[int, ...]:
    """Return the bodies that contacts press by hardly more than what pulls them, and than what is not balanced yet.

    What bodies that nothing holds are pulled by they hand on to those that they lean on, from one to the next: where
    dozens are loose, the last of them are pressed by the pulls of all, and by nothing else. Where nothing is
    stored, forces that are nothing hold nothing: bodies have slid out, as far as they still pressed.
    """
    if not problem.unknowns.lets_bodies_part:
        return ()
    pull, left = (np.linalg.norm(problem.space.resultants(part), axis=1) for part in (proximal_force, unbalanced))
    # Where no pull is left, a force that a certificate takes for balance holds nothing.
    largest = max(float(forces.pressed.max(initial=0.0)), scales.force)
    holds = scales.force_of_nothing if scales.is_unstrained else LIMITS["residual"] * largest
    free = forces.pressed <= np.maximum(HELD * pull + left, holds)
    # A support holds a body if it leaves it no direction: mirrored prisms may still move in the plane.
    body, count = problem.space.body_of_unknown, len(free)
    is_supported = np.all([np.bincount(body[fixed], minlength=count) > 0 for fixed in setup.motion.fixed], axis=0)
    free, known = free & ~is_supported, -1
    while known < free.sum():
        known, leaning = int(free.sum()), forces.from_bodies(free)
        explained = HELD * pull + left + _WEDGED * leaning
        free |= ~is_supported & (forces.pressed - leaning <= explained)
    return tuple(int(body) for body in np.flatnonzero(free))
