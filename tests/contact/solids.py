"""Two solids whose meshes do not match: what the tests of contact and cohesion in three dimensions stand on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from netgen import occ

from ngcell.contact.methods.penalty import PenaltyContact
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.terms import ContactTerm
from ngcell.contact.surface.find import find_surface
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.problem import Problem

LAW = MooneyRivlin(c1=0.7, c2=0.3, bulk_modulus=20.0)


@dataclass(frozen=True, eq=False)
class Pair:
    """Body 0, the lower one, and body 1, the upper one."""

    space: DisplacementSpace

    @cached_property
    def walls(self) -> Surface:
        return find_surface(self.space.bodies, self.space.scalar, self.space.rest)

    @property
    def nowhere(self) -> np.ndarray:
        """Nothing is held."""
        return np.zeros((3, self.space.size), dtype=bool)

    @cached_property
    def bulk(self) -> BodyEnergy:
        return BodyEnergy(self.space, [LAW] * 2)

    @cached_property
    def problem(self) -> Problem:
        stiffness = penalty_stiffness(self.walls, np.full(2, LAW.plane_strain_modulus), 10.0)
        contact = PenaltyContact(self.walls, stiffness, 0.4)
        return Problem(self.space, [self.bulk, ContactTerm(contact)], self.nowhere)

    def moved(self, translation: tuple[float, float, float], amplitude: float, seed: int) -> np.ndarray:
        """The upper body moved, both bent at random, with bubbles on top."""
        return self.bent(amplitude, seed) + (np.array(translation)[:, None] * self.upper).ravel()

    @property
    def upper(self) -> np.ndarray:
        return (self.space.body_of_unknown == 1) * self.space.one

    def bent(self, amplitude: float, seed: int) -> np.ndarray:
        random = np.random.default_rng(seed)
        x, y, z = self.space.rest
        parts = (x, y, z, x * y, y * z, x * x - z)
        terms = [part * (self.space.body_of_unknown == body) for body in (0, 1) for part in parts]
        mix = random.standard_normal((3, len(terms))) / len(terms)
        bubbles = 0.05 * random.standard_normal((3, self.space.size)) * (self.space.one == 0)
        return amplitude * (mix @ (terms * self.space.one) + bubbles).ravel()


def pair(lower: occ.Solid, upper: occ.Solid, order: int, size: float = 0.6) -> Pair:
    bodies = mesh_shapes([lower, upper], ["lower", "upper"], order=order, size=size)
    return Pair(DisplacementSpace(bodies, order))


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> occ.Solid:
    return occ.Box(low, high)


def blocks(order: int) -> Pair:
    """The upper block is smaller: its corners and sides press, and its faces meet others in between."""
    return pair(block((0, 0, 0), (1, 1, 0.5)), block((0.2, 0.15, 0.5), (0.75, 0.8, 0.9)), order)


def balls(order: int) -> Pair:
    return pair(occ.Sphere((0, 0, 0), 0.5).solids[0], occ.Sphere((0.1, 0.05, 0.98), 0.5).solids[0], order)


def straddling(order: int) -> Pair:
    """The upper block reaches over a side and a corner of the lower one."""
    return pair(block((0, 0, 0), (1, 1, 0.5)), block((0.6, 0.5, 0.5), (1.3, 1.4, 0.9)), order)
