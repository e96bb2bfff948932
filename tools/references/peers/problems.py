"""The three problems that all programs solve.

blocks
    Two unit blocks on each other between slippery walls, pressed together by a tenth of their height, on meshes that do
    not match: every section bears the same pressure.
rings
    A quarter of a press-fit: a ring [0.5, 1.0] in one of [0.9, 1.5], by its one-dimensional solution.
cells
    Seven hollow hexagonal cells of side 1, one and six around it, each a body of its own with a wall of 1/6 and nothing
    in it. The three outer walls of each of the six follow a stretch by 5 % along x, a compression by as much along y,
    and a shear by 3 %. Corners of cells are cut off, a tenth of each wall: walls that touch others do not end where
    they are held, and no corner has to pass another, on either side of which there would be an equilibrium. Walls part
    from the centre cell at 120 and 300 degrees; the others hold it. Rotated by 180 degrees, the scene is the same.

mu = 1, c1 = c2, plane strain; kappa / mu is 5 for the blocks, 100 for the rings, 10 for the cells. The force is what
the upper wall, a plane of symmetry of the outer ring, or the outer walls of the two upper cells bear [stress * length];
the opening is that between the middles of the walls of the centre cell and of its neighbour at 120 degrees [length].
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from tools.references import radial
from tools.references.peers.grids import Grid, block, hollow_cell, quarter

Array = NDArray[np.float64]
Wall = tuple[str, str]

C1, C2 = 0.5, 0.5
PRESSED = 0.9
RADII = ((0.5, 1.0), (0.9, 1.5))
WALL, CUT, MOTION = 1 / 6, 0.1, ((0.05, 0.03), (0.0, -0.05))
KAPPA = {"blocks": 5.0, "rings": 100.0, "cells": 10.0}
#: The walls of an outer cell that are held.
OUTSIDE = ("wall5", "corner5", "wall0", "corner0", "wall1")
STILL = ((0.0, 0.0), (0.0, 0.0))


@dataclass(frozen=True)
class Pair:
    """Two walls that may touch.

    Attributes
    ----------
    first, second : tuple of str
        A body and one of its sides each. GetFEM has its multipliers on the first (slave) and searches the second;
        CalculiX has its points on the second (dependent) and searches the first. This package finds its pairs itself.
    """

    first: Wall
    second: Wall


@dataclass(frozen=True)
class Support:
    """Sides of a body whose displacement is ``gradient @ X + translation``.

    Attributes
    ----------
    body : str
        The body.
    sides : tuple of str
        Its sides, as one.
    axes : tuple of int
        Which components are prescribed.
    gradient, translation : tuple
        Displacement gradient, and displacement of the origin [length].
    shares : tuple of float, shape (2,)
        What both components of the force on the body count in the force that is compared.
    """

    body: str
    sides: tuple[str, ...]
    axes: tuple[int, ...] = (0, 1)
    gradient: tuple[tuple[float, float], tuple[float, float]] = STILL
    translation: tuple[float, float] = (0.0, 0.0)
    shares: tuple[float, float] = (0.0, 0.0)

    def displacement(self, places: Array) -> Array:
        """Return the displacement of places, both of shape (n, 2) [length]."""
        return np.asarray(places @ np.array(self.gradient).T + np.array(self.translation))


@dataclass(frozen=True, eq=False)
class Problem:
    """Bodies, what they do to each other, and what is compared.

    Attributes
    ----------
    bodies : mapping of str to Grid
        The bodies by name.
    pairs : tuple of Pair
        Walls that may touch.
    supports : tuple of Support
        What is held and moved.
    kappa : float
        Bulk modulus [stress].
    steps : int
        Load steps of programs that choose none themselves.
    opening : Pair, optional
        Walls whose middles part: along the normal at rest from the first to the second.
    start : mapping of str to array of float, shape (nodes, 2)
        Displacements that Newton's method may start from, by body [length].
    singular : array of float, shape (n, 2)
        Where stresses are singular [length].
    """

    bodies: Mapping[str, Grid]
    pairs: tuple[Pair, ...]
    supports: tuple[Support, ...]
    kappa: float
    steps: int = 1
    opening: Pair | None = None
    start: Mapping[str, Array] = field(default_factory=dict)
    singular: Array = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def normal(self) -> Array:
        """Normal at rest of the first wall of the opening, outwards."""
        if self.opening is None:
            return np.zeros(2)
        body, side = self.opening.first
        nodes = self.bodies[body].sides[side]
        along = self.bodies[body].places[nodes[-1]] - self.bodies[body].places[nodes[0]]
        return np.asarray(np.array([along[1], -along[0]]) / np.linalg.norm(along))


def problem(name: str, count: int) -> Problem:
    """Return a problem with `count` elements across its first body."""
    return {"blocks": _blocks, "rings": _rings, "cells": _cells}[name](count)


def _blocks(count: int) -> Problem:
    bodies = {"lower": block(0.0, count), "upper": block(1.0, max(1, 3 * count // 4))}
    supports = [Support(body, (side,), (0,)) for body in bodies for side in ("first", "last")]
    supports.append(Support("lower", ("low",), (1,)))
    down = (0.0, 2 * (PRESSED - 1))
    supports.append(Support("upper", ("high",), (1,), translation=down, shares=(0.0, -1.0)))
    pair = Pair(("lower", "high"), ("upper", "low"))
    return Problem(bodies, (pair,), tuple(supports), KAPPA["blocks"], steps=4)


def _rings(count: int) -> Problem:
    bodies = {"inner": quarter(*RADII[0], count), "outer": quarter(*RADII[1], max(1, 3 * count // 4))}
    supports = []
    for body, share in (("inner", 0.0), ("outer", -0.5)):
        supports.append(Support(body, ("low",), (1,), shares=(0.0, share)))
        supports.append(Support(body, ("high",), (0,), shares=(share, 0.0)))
    pair = Pair(("inner", "last"), ("outer", "first"))
    rim, bore = RADII[0][1], RADII[1][0]
    start = {"inner": _to_the_middle(bodies["inner"], rim, bore), "outer": _to_the_middle(bodies["outer"], bore, rim)}
    return Problem(bodies, (pair,), tuple(supports), KAPPA["rings"], start=start)


def _to_the_middle(ring: Grid, radius: float, other: float) -> Array:
    """Return displacements of a ring of constant area by which a radius of it goes half the way to another."""
    size: Array = np.linalg.norm(ring.places, axis=1, keepdims=True)
    middle = (radius + other) / 2
    return np.asarray((np.sqrt(size**2 + middle**2 - radius**2) / size - 1) * ring.places)


def _cells(count: int) -> Problem:
    bodies = {"cell0": hollow_cell(np.zeros(2), 0.0, WALL, CUT, count)}
    supports, pairs = [], []
    for number in range(1, 7):
        angle = np.radians(60 * (number - 1))
        centre = np.sqrt(3) * np.array([np.cos(angle), np.sin(angle)])
        name, following = f"cell{number}", f"cell{number % 6 + 1}"
        bodies[name] = hollow_cell(centre, angle, WALL, CUT, count)
        shares = (0.0, -1.0) if number in (2, 3) else (0.0, 0.0)
        supports.append(Support(name, OUTSIDE, gradient=MOTION, shares=shares))
        pairs += [Pair(("cell0", f"wall{number - 1}"), (name, "wall3")), Pair((name, "wall2"), (following, "wall4"))]
    starts = [(body, side) for body, cell in bodies.items() for side in cell.sides if side.startswith("lumen")]
    starts += [(body, side) for body in list(bodies)[1:] for side in ("wall5", "corner1")]
    singular = np.array([bodies[body].places[bodies[body].sides[side][0]] for body, side in starts])
    opening = Pair(("cell0", "wall2"), ("cell3", "wall3"))
    return Problem(bodies, tuple(pairs), tuple(supports), KAPPA["cells"], 5, opening, singular=singular)


@cache
def exact_force(name: str, *, in_logarithm: bool) -> float:
    """Return the force of blocks or rings [stress * length].

    The volumetric energy is ``kappa/2 (ln J)^2``, or ``kappa/2 (J - 1)^2``; on the rings the two differ by less than
    anything is told here.
    """
    kappa = KAPPA[name]
    solid = radial.RadialSolid(C1, C2, kappa)
    if name == "rings":
        state = radial.press_fit(radial.Ring(solid, *RADII[0]), radial.Ring(solid, *RADII[1]))
        return float(state.contact_pressure * state.outside.inner)
    pressure = -float(solid.slopes(1.0, PRESSED)[1])
    return pressure if in_logarithm else pressure + kappa * (np.log(PRESSED) / PRESSED - (PRESSED - 1))
