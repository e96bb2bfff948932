"""Quarters of concentric rings with meshes that do not match, held to a one-dimensional solution (`radial`).

press-fit, tight-fit
    An inner ring [0.5, 1.0] in one that is narrower, [0.9, 1.5] or [0.8, 1.5].
pulled
    An outer ring [1.0, 1.5] whose rim is pulled to 1.6; the rings part.
below, touch, above
    An inner ring [0.5, 1.0] that a pressure of 0.2, of first touch, or of 0.6 drives towards [1.1, 1.6].
cylinder
    The inner ring alone under a pressure of 0.3.

``kappa / mu = 1000``, and 10 where a name ends with ``soft``: there order 1 does not lock.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import inf
from typing import Any

import numpy as np
from netgen import occ

from ngcell import Body, BodyScene, BodySupport, MooneyRivlin, Pressure
from tools.references import radial
from tools.solutions import Solution

C1, C2 = 0.5, 0.5
#: Bore and rim of the outer ring, the radius that its rim is pulled to, and the pressure in the inner ring [0.5, 1.0].
PROBLEMS: dict[str, tuple[float, float, float | None, float | None]] = {
    "press-fit": (0.9, 1.5, None, None),
    "tight-fit": (0.8, 1.5, None, None),
    "pulled": (1.0, 1.5, 1.6, None),
    "below": (1.1, 1.6, None, 0.2),
    "touch": (1.1, 1.6, None, None),
    "above": (1.1, 1.6, None, 0.6),
}
#: Problems in which the rings press on each other: those that have a pressure to be wrong about.
PRESSED = ("press-fit", "tight-fit", "above")
#: Circles of which radii are compared.
BOUNDARIES = ("inner-bore", "inner-rim", "outer-bore")
#: Elements of the outer ring are smaller by this factor.
MISMATCH = 0.8


def split(problem: str) -> tuple[str, float]:
    """Return the problem without its ending, and kappa / mu."""
    name = problem.removesuffix(" soft")
    return name, 1000.0 if name == problem else 10.0


@cache
def exact(problem: str) -> dict[str, float]:
    """Return radii, gap and contact pressure, and for `touch` the pressure that leads there."""
    name, kappa = split(problem)
    bore, rim, pulled, pressure = PROBLEMS[name]
    solid = radial.RadialSolid(C1, C2, kappa)
    pair = radial.Ring(solid, 0.5, 1.0), radial.Ring(solid, bore, rim)
    if name == "touch":
        state = radial.first_touch(*pair)
    elif pulled is not None:
        state = radial.pulled_apart(*pair, pulled)
    elif pressure is not None:
        state = radial.closing(*pair, pressure)
    else:
        state = radial.press_fit(*pair)
    inside = state.inside
    values = (inside.inner, inside.outer, state.gap, state.contact_pressure, inside.inner_pressure)
    return dict(zip(("bore", "interface", "gap", "pressure", "inner_pressure"), map(float, values), strict=True))


def scene(problem: str, contact: Any, order: int, size: float, accuracy: float = inf) -> BodyScene:
    """Return the scene."""
    name, kappa = split(problem)
    bore, rim, pulled, pressure = PROBLEMS[name]
    if name == "touch":
        pressure = exact(problem)["inner_pressure"]
    material = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=kappa)
    sides = (("inner", 0.5, 1.0, size), ("outer", bore, rim, MISMATCH * size))
    bodies = [Body(quarter(a, b, n, h), material, n, (f"{n}-x", f"{n}-y")) for n, a, b, h in sides]
    supports = []
    if pulled is not None:
        growth = pulled / rim - 1
        supports.append(BodySupport("outer-rim", gradient=((growth, 0.0), (0.0, growth))))
    for body in ("inner", "outer"):
        supports.append(BodySupport(f"{body}-x", components=(False, True)))
        supports.append(BodySupport(f"{body}-y", components=(True, False)))
    loads = [] if pressure is None else [Pressure(boundary="inner-bore", value=pressure)]
    meant = {"contact": contact, "loads": loads, "accuracy": accuracy}
    return BodyScene(bodies, supports, size=size, order=order, levels=1, **meant)


def quarter(bore: float, rim: float, name: str, size: float) -> Any:
    """Return a quarter of a ring in the first quadrant."""
    ring = occ.Circle((0.0, 0.0), rim).Face() - occ.Circle((0.0, 0.0), bore).Face()
    face = (ring * occ.Rectangle(2 * rim, 2 * rim).Face()).faces[0]
    for edge in face.edges:
        ends = abs(edge.start.x) + abs(edge.end.x), abs(edge.start.y) + abs(edge.end.y)
        if min(ends) < 1e-9:
            edge.name = f"{name}-y" if ends[0] < ends[1] else f"{name}-x"
        else:
            edge.name = f"{name}-rim" if sum(ends) > bore + rim else f"{name}-bore"
    face.maxh = size
    return face


def errors(problem: str, solution: Solution) -> dict[str, float]:
    """Return relative errors of the last step."""
    sides = [solution.resultant(f"outer-{side}") for side in "xy"]
    places = [solution.places(boundary) for boundary in BOUNDARIES]
    return compared(problem, places, hoop=-float(sides[0][1] + sides[1][0]) / 2)


def compared(problem: str, circles: Sequence[Any], hoop: float) -> dict[str, float]:
    """Return relative errors: the largest of the lengths, that of the pressure, and that of the hoop force.

    Parameters
    ----------
    problem : str
        Name of the problem.
    circles : sequence of array of float, shape (n, 2)
        Deformed places on each of the circles `BOUNDARIES` [length].
    hoop : float
        Pull of the supports on a plane of symmetry of the outer ring [stress * length]; it bears the pressure.
    """
    name, _ = split(problem)
    right = exact(problem)
    radii = [float(np.linalg.norm(places, axis=1).mean()) for places in circles]
    found = []
    if name != "pulled":
        found += [abs(radius / right[what] - 1) for what, radius in zip(("bore", "interface"), radii, strict=False)]
    if name in ("pulled", "below"):
        found.append(abs((radii[2] - radii[1]) / right["gap"] - 1))
    result = {"gap": max(found)}
    if name in PRESSED:
        result["pressure"] = abs(hoop / min(radii[1:]) / right["pressure"] - 1)
        result["force"] = abs(hoop / (right["pressure"] * right["interface"]) - 1)
    return result
