"""Hollow spheres pressed together by inner pressure, against the radial solution in one dimension."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from netgen import occ

from ngcell.build.simulation import Simulation
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin, Penalty, Pressure
from tools.references.radial import RadialSolid, Ring, closing, first_touch

C1, C2, KAPPA = 0.8, 0.2, 20.0
SOLID = RadialSolid(C1, C2, KAPPA, around=2)
INNER, OUTER = Ring(SOLID, 0.6, 1.0), Ring(SOLID, 1.03, 1.4)
PRESSURE = 0.6


def octant(name: str, inner: float, outer: float) -> Body:
    """The part with x, y, z > 0; its planes of symmetry and whatever is no contact are no walls."""
    shell = occ.Sphere((0, 0, 0), outer) - occ.Sphere((0, 0, 0), inner)
    solid = (shell * occ.Box((0, 0, 0), (2, 2, 2))).solids[0]
    for face in solid.faces:
        at = np.array([face.center.x, face.center.y, face.center.z])
        flat = np.flatnonzero(np.abs(at) < 1e-9)
        far = np.linalg.norm(at) > np.sqrt(3) / 2 * (inner + outer) / 2  # centres of eighths of spheres
        face.name = f"{name}_{'xyz'[flat[0]]}" if len(flat) else f"{name}_{'outer' if far else 'inner'}"
    wall = "outer" if name == "inside" else "inner"
    sides = ("x", "y", "z", "inner", "outer")
    untouched = tuple(f"{name}_{side}" for side in sides if side != wall)
    return Body(solid, MooneyRivlin(c1=C1, c2=C2, bulk_modulus=KAPPA), name, untouched)


def test_radial_shells_touch_and_press():
    touch = first_touch(INNER, OUTER)
    assert touch.inside.outer == pytest.approx(1.03, rel=1e-9)
    state = closing(INNER, OUTER, PRESSURE)
    assert PRESSURE > touch.inside.inner_pressure
    assert state.gap == pytest.approx(0, abs=1e-12)
    assert 0 < state.contact_pressure < PRESSURE


def test_shells_pressed_together_bear_the_radial_solution():
    exact = closing(INNER, OUTER, PRESSURE)
    bodies = [octant("inside", 0.6, 1.0), octant("outside", 1.03, 1.4)]
    mirrors = [
        BodySupport(f"{body.name}_{axis}", components=tuple(axis == other for other in "xyz"))
        for body in bodies
        for axis in "xyz"
    ]
    scene = BodyScene(
        bodies,
        mirrors,
        size=0.5,
        order=2,
        levels=1,
        contact=Penalty(stiffness=3.0),
        loads=[Pressure(boundary="inside_inner", value=PRESSURE)],
        accuracy=inf,
    )
    simulation = Simulation(scene)
    step = list(simulation.accepted_steps())[-1]
    assert step.record.certified
    grid = step.snapshot.bulk
    place, rest = grid.points + grid.point_data["displacement"], np.linalg.norm(grid.points, axis=1)
    for at, radius in ((0.6, exact.inside.inner), (1.0, exact.inside.outer), (1.4, exact.outside.outer)):
        here = np.abs(rest - at) < 2e-3
        assert np.linalg.norm(place[here], axis=1).mean() == pytest.approx(radius, rel=5e-3)
    force = step.record.contact_force / np.sqrt(3)  # its component along an axis
    assert force / (np.pi / 4 * exact.inside.outer**2) == pytest.approx(exact.contact_pressure, rel=0.03)
