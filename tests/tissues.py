"""Small tissues, wired by hand: what the tests of mechanics, contact and solve stand on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, tril

from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.protocol import ContactSet
from ngcell.contact.methods.terms import ContactTerm
from ngcell.contact.surface.find import find_surface
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.lattice import Lattice, hexagonal_lattice
from ngcell.geometry.sections import ring_mesh
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.stored import StoredEnergy
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.problem.problem import Problem
from ngcell.problem.state import Linearisation, State
from ngcell.problem.tie import Tie, tie_walls
from ngcell.solve.minimise import Minimiser
from ngcell.solve.released import Released
from ngcell.solve.step import Accepted, Motion
from ngcell.solve.strategies.single_step import SingleStep
from ngcell.solve.strategies.strategy import Progress, Task

Array = NDArray[np.float64]

LAW = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0)
#: Longest step of the minimiser; contact is searched in twice this distance.
LONGEST_STEP = 0.05
#: What bodies at rest store; for methods that do not ask.
NOTHING = StoredEnergy(lambda: (np.zeros(0), 0.0))


@dataclass(frozen=True, eq=False)
class SmallTissue:
    """Cells of side 1 with everything that can be asked of them; `motion` holds what the supports say."""

    lattice: Lattice
    bodies: BodyMesh
    space: DisplacementSpace
    motion: PrescribedMotion

    @cached_property
    def walls(self) -> Surface:
        return find_surface(self.bodies, self.space.scalar, self.space.rest)

    @cached_property
    def bulk(self) -> BodyEnergy:
        return BodyEnergy(self.space, [LAW] * self.bodies.body_count)

    @cached_property
    def contact(self) -> PenaltyContact:
        modulus = np.full(self.bodies.body_count, LAW.plane_strain_modulus)
        stiffness = penalty_stiffness(self.walls, modulus, 1.0)
        return PenaltyContact(self.walls, stiffness, reach=2 * LONGEST_STEP)

    @cached_property
    def tie(self) -> Tie:
        return tie_walls(self.walls, self.space.size)

    @cached_property
    def released(self) -> Problem:
        return Problem(self.space, [self.bulk, ContactTerm(self.contact)], self.motion.fixed)

    @cached_property
    def tied(self) -> Problem:
        return Problem(self.space, [self.bulk], self.motion.fixed, tie=self.tie)

    @property
    def volume(self) -> float:
        return float(self.space.one @ self.space.scalar_mass @ self.space.one)

    def minimiser(self, problem: Problem) -> Minimiser:
        has_contact = any(isinstance(term, ContactTerm) for term in problem.terms)
        longest = LONGEST_STEP if has_contact else np.inf
        return Minimiser(problem, longest, energy_scale=LAW.shear_modulus * self.volume)

    def positions(self, displacement: Array) -> Array:
        return self.space.rest + displacement.reshape(2, -1)

    def rigid_motion(self, angle: float, translation: tuple[float, float] = (0.0, 0.0)) -> Array:
        """Displacement of a rotation about the origin and a translation after it."""
        return self.space.affine(rotation(angle) - np.eye(2), np.array(translation)).ravel()

    def body_translation(self, body: int, translation: Array) -> Array:
        """Displacement that moves one body and leaves the others."""
        member = (self.space.body_of_unknown == body) * self.space.one
        return (np.asarray(translation)[:, None] * member).ravel()

    def smooth(self, amplitude: float, seed: int) -> Array:
        """A random displacement, smooth over each body, that bends walls."""
        random = np.random.default_rng(seed)
        x, y = self.space.rest
        centre = self.lattice.centres[self.space.body_of_unknown]
        x, y = x - centre[:, 0] * self.space.one, y - centre[:, 1] * self.space.one
        noise = amplitude * 0.05 * random.standard_normal((2, self.space.size)) * (self.space.one == 0)
        terms = [self.space.one * part for part in (x, y, x * y, x * x - y * y, x**3 - y)]
        mix = random.standard_normal((2, len(terms), self.bodies.body_count)) / len(terms)
        field = sum(mix[:, k, self.space.body_of_unknown] * term for k, term in enumerate(terms))
        return (amplitude * field + noise).ravel()


def rotation(angle: float) -> Array:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def small_tissue(
    rows: int,
    cols: int,
    *,
    order: int = 2,
    edges: int = 2,
    wall: float = 0.2,
    radius: float = 0.0,
    prescribed_displacement: tuple[float, float] = (0.0, 0.0),
    pointy: bool = True,
    supports: dict[str, NDArray[np.bool_]] | None = None,
) -> SmallTissue:
    """Cells between plates, the regions ``low``, held, and ``high``, moved; or other supports."""
    lattice = hexagonal_lattice(rows, cols, side=1.0, pointy=pointy)
    if supports is None:
        supports = {"low": lattice.hull_walls(0, -1), "high": lattice.hull_walls(rows - 1, 1)}
    bodies = ring_mesh(lattice.outlines, wall=wall, radius=radius, edges=edges, layers=1, supports=supports)
    space = DisplacementSpace(bodies, order)
    return SmallTissue(lattice, bodies, space, plates(space, supports, np.array(prescribed_displacement)))


def plates(space: DisplacementSpace, regions: dict[str, NDArray], prescribed_displacement: Array) -> PrescribedMotion:
    """The first region is held, the others move; the lifting grows in proportion along the way."""
    still = np.zeros((2, 2))
    translations = [np.zeros(2), *[prescribed_displacement] * (len(regions) - 1)]
    held = [Support(name, still, translation) for name, translation in zip(regions, translations, strict=True)]
    if len(held) < 2:
        return PrescribedMotion(space, held)
    low, high = (space.rest[:, _vertices(space, name)].mean(1) for name in list(regions)[:2])
    way = (high - low) / ((high - low) @ (high - low))

    def lifting(at: Array) -> Array:
        return prescribed_displacement[:, None] * np.clip(way @ (at - low[:, None]), 0, 1)

    return PrescribedMotion(space, held, lifting)


def _vertices(space: DisplacementSpace, region: str) -> NDArray[np.int64]:
    unknowns = space.region_unknowns(region)
    return unknowns[space.one[unknowns] > 0]


def contact_term(problem: Problem) -> ContactTerm:
    """The term of a problem that keeps bodies apart."""
    (term,) = (term for term in problem.terms if isinstance(term, ContactTerm))
    return term


def contact_set(problem: Problem, state: State) -> ContactSet:
    """The contact pairs of a state."""
    return contact_term(problem).found(state.at)


def single_step(released: Released, motion: Motion, *, steps: Sequence[float]) -> Iterator[Accepted]:
    """Equilibria with contact at load factors, one after the other."""
    task = Task(SimpleNamespace(tied=(), released=released, renew_budget=lambda: None), motion, steps, steps)
    return SingleStep().follow(task, Progress())


def whole_tangent(problem: Problem, line: Linearisation) -> csr_matrix:
    """The whole tangent: bodies, curvature of the contacts, penalty terms of closed ones."""
    size = len(problem.free)
    lower = csr_matrix((line.stiffness, problem.pattern), shape=(size, size))
    closed = line.jacobian[np.flatnonzero(line.gap < 0)]
    matrix = lower + tril(lower, -1).T + closed.T @ closed.multiply(line.penalty[line.gap < 0][:, None])
    return csr_matrix(matrix if line.curvature is None else matrix + line.curvature)
