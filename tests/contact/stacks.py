"""Two bodies on top of each other with meshes that do not match: what the tests of segments and the mortar stand on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from netgen import occ

from ngcell.contact.methods.mortar import MortarContact
from ngcell.contact.methods.penalty_stiffness import penalty_stiffness
from ngcell.contact.methods.terms import ContactTerm
from ngcell.contact.surface.find import find_surface
from ngcell.contact.surface.surface import Surface
from ngcell.geometry.shapes import mesh_shapes
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.problem.problem import Problem

LAW = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0)
REACH = 0.2


@dataclass(frozen=True, eq=False)
class Stack:
    """Body 0, the lower one, and body 1, the upper one, at rest on it."""

    space: DisplacementSpace

    @cached_property
    def walls(self) -> Surface:
        return find_surface(self.space.bodies, self.space.scalar, self.space.rest)

    @cached_property
    def problem(self) -> Problem:
        free = np.zeros((2, self.space.size), dtype=bool)
        return Problem(self.space, [BodyEnergy(self.space, [LAW] * 2), ContactTerm(self.contact)], free)

    @cached_property
    def contact(self) -> MortarContact:
        modulus = np.full(2, LAW.plane_strain_modulus)
        return MortarContact(self.walls, penalty_stiffness(self.walls, modulus, 10.0), REACH)

    def upper_moved(self, translation: tuple[float, float]) -> np.ndarray:
        """Displacement that moves the upper body only."""
        member = (self.space.body_of_unknown == 1) * self.space.one
        return (np.array(translation)[:, None] * member).ravel()

    def positions(self, displacement: np.ndarray) -> np.ndarray:
        return self.space.rest + displacement.reshape(2, -1)

    def bent(self, amplitude: float, seed: int) -> np.ndarray:
        """A random displacement, smooth over each body, with bubbles on top."""
        random = np.random.default_rng(seed)
        x, y = self.space.rest
        terms = [part * (self.space.body_of_unknown == body) for body in (0, 1) for part in (x, y, x * y, x * x - y)]
        mix = random.standard_normal((2, len(terms))) / len(terms)
        bubbles = 0.05 * random.standard_normal((2, self.space.size)) * (self.space.one == 0)
        return amplitude * (mix @ (terms * self.space.one) + bubbles).ravel()


def stack(shapes: tuple[occ.TopoDS_Shape, occ.TopoDS_Shape], sizes: tuple[float, float], order: int) -> Stack:
    faces = [shape.faces[0] for shape in shapes]
    for face, size in zip(faces, sizes, strict=True):
        face.maxh = size
    bodies = mesh_shapes(faces, ["lower", "upper"], order=order, size=max(sizes))
    return Stack(DisplacementSpace(bodies, order))


def blocks(sizes: tuple[float, float] = (0.3, 0.4), *, width: float = 1.0, order: int = 2) -> Stack:
    """Blocks of height 0.5 on the line y = 0.5; the upper one may have another width, both are centred at x = 0."""
    lower = occ.MoveTo(-0.5, 0.0).Rectangle(1.0, 0.5).Face()
    upper = occ.MoveTo(-width / 2, 0.5).Rectangle(width, 0.5).Face()
    return stack((lower, upper), sizes, order)


def rings(sizes: tuple[float, float], *, order: int = 2) -> Stack:
    """A ring in another one; they touch along the circle of radius 1."""
    bore, inner_rim, outer_bore, rim = (occ.Circle((0.0, 0.0), radius).Face() for radius in (0.7, 1.0, 1.0, 1.3))
    return stack((inner_rim - bore, rim - outer_bore), sizes, order)
