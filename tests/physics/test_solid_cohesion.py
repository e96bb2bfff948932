"""Cohesion in three dimensions: solids separate as the law says, and prisms held along their axis are planar cells."""

from __future__ import annotations

from functools import cache
from math import inf

import numpy as np
import pytest
from scipy.integrate import simpson

from ngcell.build.simulation import Simulation, Step
from ngcell.scene import BodyScene, Cohesion
from tests.physics.test_stacked_solids import block, held
from tests.prisms import case

LAW = Cohesion(strength=0.1, energy=0.01)
PEAKS, STEPS = 4.0, 4
HEIGHT = 0.4


@cache
def parted() -> list[Step]:
    """Quarters of blocks, whose meshes do not match, pulled apart by so many times the opening at the peak."""
    bodies = [block("lower", 0.0, 0.5, 1.5), block("upper", 0.5, 1.0, 0.9)]
    mirrors = [held(f"{body.name}_{side}") for body in bodies for side in ("x0", "y0")]
    supports = [*mirrors, held("lower_z0"), held("upper_z1", PEAKS * LAW.peak)]
    cohesion = LAW
    return list(
        Simulation(
            BodyScene(bodies, supports, size=1.5, order=1, steps=STEPS, cohesion=cohesion, accuracy=inf)
        ).accepted_steps()
    )


def test_the_work_of_the_support_is_what_is_separated_and_stored():
    steps = parted()
    assert all(step.record.certified for step in steps)
    force = np.array([0.0, *(step.record.plate_force_z for step in steps)])
    prescribed_displacement = PEAKS * LAW.peak * np.array([0.0, *(step.record.load_factor for step in steps)])
    last = steps[-1].record
    assert simpson(force, prescribed_displacement) == pytest.approx(last.separation_energy + last.energy, rel=2e-5)
    opening = np.array(last.mean_gap)
    given_back = float(LAW.traction(opening) * opening / 2)
    assert last.separation_energy == pytest.approx(float(LAW.work(opening)) - given_back, rel=1e-6)  # the area is 1
    assert last.dissipation < 1e-4 * LAW.energy
    assert last.bonded_share == 0


def test_traction_between_solids_follows_the_law():
    force = np.array([step.record.plate_force_z for step in parted()])
    opening = np.array([step.record.mean_gap for step in parted()])
    np.testing.assert_allclose(force, LAW.traction(opening), atol=1e-6 * LAW.strength)


@pytest.mark.parametrize("kind", ["sddp", "load-stepping"])
def test_bonded_prisms_held_along_their_axis_are_bonded_cells(kind):
    parts = {"cohesion": {"strength": 0.02, "energy": 0.0005}, "strategy": {"kind": kind}}
    planar = list(Simulation(case(None, **parts)).accepted_steps())
    solid = list(Simulation(case(HEIGHT, ends="held", **parts)).accepted_steps())
    assert len(planar) == len(solid)
    last, deep = planar[-1].record, solid[-1].record
    assert all(step.record.certified for step in (*planar, *solid))
    assert 0.01 < last.bonded_share < 0.99
    for name in ("energy", "plate_force_x", "plate_force_y", "contact_force", "separation_energy"):
        assert getattr(deep, name) == pytest.approx(HEIGHT * getattr(last, name), rel=1e-7), name
    for name in ("largest_gap", "mean_gap", "bonded_share"):
        assert getattr(deep, name) == pytest.approx(getattr(last, name), rel=1e-6), name
