"""This package on blocks and rings, by each of its contact methods, on meshes of Netgen of the same sizes."""

from __future__ import annotations

from math import inf
from time import perf_counter
from typing import Any

from netgen import occ

from ngcell import Body, BodyScene, BodySupport, MooneyRivlin, Mortar, NgsolveContact, Penalty
from tools.references.peers.problems import C1, C2, KAPPA, PRESSED, RADII
from tools.solutions import Solution, solved
from tools.studies.work_precision.rings import quarter

METHODS: dict[str, Any] = {
    "penalty": Penalty(stiffness=10.0),
    "ngsolve": NgsolveContact(stiffness=10.0),
    "mortar": Mortar(),
}


def force(method: str, problem: str, count: int, order: int) -> tuple[float, float, int]:
    """Return the force that `exact_force` tells, seconds on the clock, and the number of unknowns."""
    scene = (_blocks if problem == "blocks" else _rings)(METHODS[method], count, order)
    started = perf_counter()
    solution: Solution = solved(scene)
    seconds = perf_counter() - started
    if not solution.certified:
        raise RuntimeError("not certified")
    if problem == "blocks":
        return -float(solution.resultant("ceiling")[1]), seconds, solution.unknowns
    sides = [solution.resultant(f"outer-{side}") for side in "xy"]
    return -float(sides[0][1] + sides[1][0]) / 2, seconds, solution.unknowns


def _rings(contact: Any, count: int, order: int) -> BodyScene:
    material = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=KAPPA["rings"])
    bodies, supports = [], []
    for name, (bore, rim), size in zip(("inner", "outer"), RADII, (0.5 / count, 0.8 / count), strict=True):
        bodies.append(Body(quarter(bore, rim, name, size), material, name, (f"{name}-x", f"{name}-y")))
        supports.append(BodySupport(f"{name}-x", components=(False, True)))
        supports.append(BodySupport(f"{name}-y", components=(True, False)))
    return BodyScene(bodies, supports, size=0.8 / count, order=order, levels=1, contact=contact, accuracy=inf)


def _blocks(contact: Any, count: int, order: int) -> BodyScene:
    material, bodies = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=KAPPA["blocks"]), []
    for name, bottom, size in (("lower", 0, 1 / count), ("upper", 1, 1 / max(1, 3 * count // 4))):
        face = occ.MoveTo(0, bottom).Rectangle(1, 1).Face().faces[0]
        face.edges.Min(occ.Y).name = "floor" if bottom == 0 else "upper-bottom"
        face.edges.Max(occ.Y).name = "ceiling" if bottom == 1 else "lower-top"
        face.edges.Min(occ.X).name, face.edges.Max(occ.X).name = f"{name}-left", f"{name}-right"
        face.maxh = size
        bodies.append(Body(face, material, name, (f"{name}-left", f"{name}-right")))
    sides = [f"{name}-{side}" for name in ("lower", "upper") for side in ("left", "right")]
    supports = [BodySupport(side, components=(True, False)) for side in sides]
    supports.append(BodySupport("floor", components=(False, True)))
    supports.append(BodySupport("ceiling", translation=(0.0, 2 * (PRESSED - 1)), components=(False, True)))
    return BodyScene(bodies, supports, size=2 / count, order=order, levels=1, contact=contact, accuracy=inf)
