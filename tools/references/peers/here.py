"""This package, by each of its contact methods, on meshes of Netgen whose elements have the sizes of the grids'.

Blocks and rings have its Mooney-Rivlin, whose volumetric part is ``kappa/2 (ln J)^2``; the cells have that of the other
programs, ``kappa/2 (J - 1)^2``, in a law of a script.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from time import perf_counter
from typing import Any

import ngsolve
import numpy as np
from netgen import occ

from ngcell import (
    Body,
    BodyScene,
    BodySupport,
    CustomLaw,
    MooneyRivlin,
    Mortar,
    NgcellError,
    NgsolveContact,
    Penalty,
    Refinement,
)
from tools.references.peers.answer import LIMIT, Answer, stopped_after
from tools.references.peers.grids import Array, Grid, Indices
from tools.references.peers.problems import C1, C2, Problem
from tools.solutions import Solution, solved

#: How far inside a wall its displacement is read, since walls of two bodies are at one place at rest [length].
_INSIDE = 1e-5

METHODS: dict[str, Any] = {
    "penalty": Penalty(stiffness=10.0),
    "ngsolve": NgsolveContact(stiffness=10.0),
    "mortar": Mortar(),
}


def solve(method: str, problem: Problem, order: int, *, grades: int = 0, limit: int = LIMIT) -> Answer:
    """Solve a problem.

    Parameters
    ----------
    method : str
        Kind of contact.
    problem : Problem
        The problem.
    order : int
        Polynomial order.
    grades : int
        How often elements are halved where stresses are singular.
    limit : int
        Seconds after which it is stopped.

    Raises
    ------
    RuntimeError
        If there is no certified result.
    """
    described = scene(problem, METHODS[method], order, grades)
    started = perf_counter()
    try:
        with stopped_after(limit):
            solution = solved(described)
    except NgcellError as error:
        raise RuntimeError(str(error)) from error
    seconds = perf_counter() - started
    if not solution.certified:
        raise RuntimeError("not certified")
    force = sum(
        float(np.dot(support.shares, solution.resultant("|".join(f"{support.body}-{side}" for side in support.sides))))
        for support in problem.supports
        if any(support.shares)
    )
    return Answer(force, _opening(problem, solution), seconds, solution.unknowns)


def scene(problem: Problem, contact: Any, order: int, grades: int = 0) -> BodyScene:
    """Return the problem as a scene."""
    law: Any = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=problem.kappa)
    if problem.opening is not None:
        law = CustomLaw(_isochoric, lambda jacobian: problem.kappa / 2 * (jacobian - 1) * (jacobian - 1))
    touching = {wall for pair in problem.pairs for wall in (pair.first, pair.second)}
    bodies = []
    for name, grid in problem.bodies.items():
        untouched = tuple(f"{name}-{side}" for side in grid.sides if (name, side) not in touching)
        bodies.append(Body(_face(name, grid), law, name, untouched))
    supports = [
        BodySupport(f"{held.body}-{side}", held.gradient, held.translation, (0 in held.axes, 1 in held.axes))
        for held in problem.supports
        for side in held.sides
    ]
    size = max(grid.size for grid in problem.bodies.values())
    within = size / 2
    refinements = [Refinement(at=tuple(at), within=within, size=size / 2**grades) for at in problem.singular if grades]
    return BodyScene(
        bodies,
        supports,
        size=size,
        order=order,
        levels=1,
        contact=contact,
        refinements=refinements,
        accuracy=inf,
    )


def _face(name: str, grid: Grid) -> occ.Face:
    """Return the face within the sides of a grid, less its hole, with the names of the sides on its edges."""
    outlines = [occ.Face(occ.Wire([_edge(grid.places[nodes]) for nodes in sides])) for sides in _outlines(grid)]
    whole, *holes = sorted(outlines, key=lambda face: -face.mass)
    for hole in holes:
        whole = whole - hole
    face = whole.faces[0]
    for edge in face.edges:
        ends = np.array([[end.x, end.y] for end in (edge.start, edge.end)])
        edge.name = f"{name}-{next(side for side, nodes in grid.sides.items() if _joins(grid.places[nodes], ends))}"
    face.maxh = grid.size
    return face


def _outlines(grid: Grid) -> Iterator[list[Indices]]:
    """Yield the sides of each closed outline, one after another."""
    left = list(grid.sides.values())
    while left:
        outline = [left.pop(0)]
        end = outline[0][-1]
        while end != outline[0][0]:
            number = next(number for number, nodes in enumerate(left) if end in nodes[[0, -1]])
            outline.append(left.pop(number))
            end = outline[-1][0 if end == outline[-1][-1] else -1]
        yield outline


def _edge(places: Array) -> Any:
    """Return the straight line, or the arc of a circle, through the first, the middle and the last place."""
    start, middle, end = ((float(x), float(y), 0.0) for x, y in places[[0, len(places) // 2, -1]])
    is_straight = np.allclose(places[len(places) // 2], (places[0] + places[-1]) / 2)
    return occ.Segment(start, end) if is_straight else occ.ArcOfCircle(start, middle, end)


def _joins(places: Array, ends: Array) -> bool:
    """Return whether places begin and end at two ends, in whichever order."""
    return any(np.allclose(places[[0, -1]], ordered) for ordered in (ends, ends[::-1]))


def _opening(problem: Problem, solution: Solution) -> float | None:
    """Return how far the middles of two walls have parted along the normal at rest."""
    if problem.opening is None:
        return None
    mesh, displacement, normal, moved = solution.mesh, solution.displacement, problem.normal, []
    for (body, side), inwards in ((problem.opening.first, -normal), (problem.opening.second, normal)):
        grid = problem.bodies[body]
        x, y = grid.places[grid.middle(side)] + _INSIDE * inwards
        moved.append(np.array(displacement(mesh(x, y))))
    return float((moved[1] - moved[0]) @ normal)


def _isochoric(gradient: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
    """Return the part of Mooney-Rivlin without volume change [stress]."""
    right = gradient.trans * gradient
    first = ngsolve.Trace(right)
    second = (first * first - ngsolve.Trace(right * right)) / 2
    scale = ngsolve.exp(-2 / 3 * ngsolve.log(ngsolve.Det(gradient)))
    return C1 / 2 * (scale * first - 3) + C2 / 2 * (scale * scale * second - 3)
