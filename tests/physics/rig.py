"""Bodies wired by hand, from a scene to accepted equilibria, and what is read off them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from netgen import occ

from ngcell.contact.methods.protocol import ContactSet
from ngcell.contact.methods.terms import ContactTerm
from ngcell.contact.surface.find import find_surface
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.mechanics.symbolic_sum import fused
from ngcell.problem.problem import Problem
from ngcell.results.forces import ContactForces, contact_forces
from ngcell.scene.bodies import BodyScene, BodySupport
from ngcell.solve.continuation import Continuation
from ngcell.solve.minimise import Minimiser
from ngcell.solve.released import Released
from ngcell.solve.step import Accepted
from tests.tissues import contact_set, single_step


def rubber(bulk_modulus: float) -> MooneyRivlin:
    """Mooney-Rivlin of shear modulus 1."""
    return MooneyRivlin(c1=0.8, c2=0.2, bulk_modulus=bulk_modulus)


def ring(inner: float, outer: float, centre: tuple[float, float] = (0.0, 0.0)) -> occ.TopoDS_Shape:
    return occ.Circle(centre, outer).Face() - occ.Circle(centre, inner).Face()


def swelling(boundary: str, radius: float, at_rest: float) -> BodySupport:
    """A circle about the origin that grows to a radius."""
    growth = radius / at_rest - 1
    return BodySupport(boundary, gradient=((growth, 0.0), (0.0, growth)))


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """An accepted step of a rig."""

    rig: Rig
    accepted: Accepted

    @property
    def load_factor(self) -> float:
        return self.accepted.load_factor

    @property
    def displacement(self) -> np.ndarray:
        return self.accepted.minimum.state.displacement

    @cached_property
    def positions(self) -> np.ndarray:
        """Deformed positions as unknowns, shape (2, size)."""
        return self.accepted.minimum.state.positions

    @cached_property
    def reactions(self) -> np.ndarray:
        """Forces that the supports exert, shape (unknowns,)."""
        problem = self.rig.problem
        return problem.unknowns.reactions(problem.gradient(self.accepted.minimum.state))

    @property
    def work_rate(self) -> float:
        """Work of the supports for each unit of the load factor."""
        final = self.rig.motion.imposed(np.zeros_like(self.reactions), 1.0)
        return float(self.reactions @ final)

    @property
    def contact_forces(self) -> ContactForces:
        return contact_forces(self.rig.problem, self.accepted.minimum.state)

    def force(self, boundary: str) -> np.ndarray:
        """Force of the supports on a boundary, shape (2,)."""
        return self.rig.motion.resultant(self.reactions, boundary)

    @property
    def contact_set(self) -> ContactSet:
        """All contact pairs."""
        return contact_set(self.rig.problem, self.accepted.minimum.state)

    def contact_points(self) -> tuple[np.ndarray, np.ndarray]:
        """Gap and pressure on the reference length, of all contact pairs."""
        contact = self.contact_set
        weight = contact.kinematics.pairs.weight
        return contact.kinematics.gaps(self.positions), 2 * contact.contact_forces(self.positions) / weight

    def is_contact_point_in(self, *, low: tuple[float, float], high: tuple[float, float]) -> np.ndarray:
        """Which of the contact points lie in a box at rest."""
        walls = self.rig.walls
        pairs = self.contact_set.kinematics.pairs
        point = walls.places(pairs.primary, pairs.primary_xi, walls.rest)
        return ((point >= low) & (point <= high)).all(1)

    def vertices(self, boundary: str) -> np.ndarray:
        """Deformed vertices of a boundary, shape (n, 2)."""
        space = self.rig.space
        unknowns = space.region_unknowns(boundary)
        return self.positions[:, unknowns[space.one[unknowns] > 0]].T

    def radius(self, boundary: str) -> float:
        """Mean distance of a boundary's vertices from the origin."""
        return float(np.linalg.norm(self.vertices(boundary), axis=1).mean())

    def body_energy(self, body: int) -> float:
        """Stored energy of a body: what is left when all others are put back to rest."""
        alone = self.displacement.reshape(2, -1) * (self.rig.space.body_of_unknown == body)
        return self.rig.bulk.form.energy(alone.ravel())


class Rig:
    """A scene, wired.

    Parameters
    ----------
    scene : BodyScene
        The bodies.
    walls : str, optional
        Boundaries that may touch, a regular expression; by default those that the geometry room found.
    """

    def __init__(self, scene: BodyScene, walls: str | None = None) -> None:
        names = [body.name for body in scene.bodies]
        self.scene = scene
        shapes = [body.shape for body in scene.bodies]
        self.bodies = mesh_shapes(shapes, names, order=scene.plain_order, size=scene.size)
        if walls is not None:
            self.bodies = replace(self.bodies, wall_names=walls)
        self.space = DisplacementSpace(self.bodies, scene.plain_order)
        self.laws = [
            MooneyRivlin(c1=body.material.c1, c2=body.material.c2, bulk_modulus=body.material.bulk_modulus)
            for body in scene.bodies
        ]
        supports = [
            Support(given.boundary, np.array(given.gradient), np.array(given.translation), given.components)
            for given in scene.supports
        ]
        self.motion = PrescribedMotion(self.space, supports)
        self.bulk = BodyEnergy(self.space, self.laws)
        loads = [AppliedLoads(self.space, scene.loads, self.motion)] if scene.loads else []
        self.terms = fused([self.bulk, *loads])
        self.walls = find_surface(self.bodies, self.space.scalar, self.space.rest)
        self.stages = self._stages()
        self.problem = self.stages[-1]

    def _stages(self) -> list[Problem]:
        moduli = np.array([law.plane_strain_modulus for law in self.laws])
        methods = self.scene.contact.stages(self.walls, moduli, reach=self.bodies.thickness)
        return [Problem(self.space, (*self.terms, ContactTerm(method)), self.motion.fixed) for method in methods]

    def _minimiser(self, problem: Problem) -> Minimiser:
        modulus = max(law.shear_modulus for law in self.laws)
        volume = float(self.space.one @ self.space.scalar_mass @ self.space.one)
        return Minimiser(problem, self.bodies.thickness / 2, energy_scale=modulus * volume)

    def accepted_steps(self) -> Iterator[Equilibrium]:
        """Equilibria at the levels."""
        apart = self._minimiser(Problem(self.space, self.terms, self.motion.fixed))
        scale = max(law.shear_modulus for law in self.laws) / self.bodies.length**2
        released = Released(apart, tuple(map(self._minimiser, self.stages)), Continuation(scale))
        for accepted in single_step(released, self.motion, steps=self.scene.level_factors):
            yield Equilibrium(self, accepted)


def work_is_change_of_energy(path: list[Equilibrium]) -> bool:
    """Whether the supports' work on the path, by the trapezoidal rule, is the change of energy."""
    for one, two in pairwise(path):
        span = two.load_factor - one.load_factor
        work = span * (one.work_rate + two.work_rate) / 2
        change = two.accepted.minimum.state.energy - one.accepted.minimum.state.energy
        if abs(work - change) > 0.5 * span * abs(two.work_rate - one.work_rate):
            return False
    return True
