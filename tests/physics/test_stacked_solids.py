"""K1 in three dimensions: two stacked blocks whose meshes do not match, between free sides, compressed to a stretch."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from netgen import occ

from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin, Mortar, Penalty

C1, C2 = 0.8, 0.2
STRETCH = 0.9


def block(name: str, low: float, high: float, size: float) -> Body:
    """A quarter of a block, cut along x = 0 and y = 0."""
    solid = occ.Box((0, 0, low), (1, 1, high)).solids[0]
    for axis in "xyz":
        solid.faces.Min(getattr(occ, axis.upper())).name = f"{name}_{axis}0"
        solid.faces.Max(getattr(occ, axis.upper())).name = f"{name}_{axis}1"
    solid.maxh = size
    outside = tuple(f"{name}_{side}" for side in ("x0", "x1", "y0", "y1", "z0" if low == 0 else "z1"))
    return Body(solid, MooneyRivlin(c1=C1, c2=C2, bulk_modulus=1000.0), name, outside)


def held(boundary: str, translation: float = 0.0) -> BodySupport:
    """A side that is held along the axis that its name tells, and moved along it."""
    components = tuple(axis == boundary[-2] for axis in "xyz")
    return BodySupport(
        boundary, translation=tuple(translation * component for component in components), components=components
    )


@pytest.mark.parametrize(("size", "order", "stiffness"), [(0.35, 1, 10.0), (0.45, 2, 1.0)])
def test_pressure_of_stacked_blocks_is_uniform_and_that_of_the_free_sides(size, order, stiffness):
    """Walls overlap by the pressure over the stiffness; blocks are compressed less by as much."""
    step = pressed((size, size + 0.15), order, Penalty(stiffness=stiffness))
    assert step.record.certified
    exact = -(C1 + C2 / STRETCH) * (STRETCH**2 - 1 / STRETCH)
    pressure = step.snapshot.walls.point_data["contact_pressure"]
    assert np.ptp(pressure) < 1e-8 * exact
    assert pressure.mean() == pytest.approx(exact, rel=0.01 / stiffness)
    stress = step.snapshot.bulk.point_data["cauchy_stress"]
    np.testing.assert_allclose(stress, np.diag([0, 0, -pressure.mean()]).ravel() + 0 * stress, atol=1e-8)
    assert step.record.plate_force_z == pytest.approx(-step.record.contact_force, rel=1e-8)


def test_pressures_scatter_little_between_meshes_whose_faces_cut_each_other():
    """A rule ignores where the faces of the wall opposite end; a coarser one than that of edges scatters by 5 %."""
    step = pressed((0.28, 0.4), 1, Penalty(stiffness=1.0))
    pressure = step.snapshot.walls.point_data["contact_pressure"]
    assert step.record.certified
    assert pressure.std() < 0.01 * pressure.mean()


def pressed(sizes: tuple[float, float], order: int, contact: Penalty | Mortar) -> Step:
    """Press blocks with elements of these sizes onto each other."""
    bodies = [block("lower", 0.0, 0.5, sizes[0]), block("upper", 0.5, 1.0, sizes[1])]
    mirrors = [held(f"{body.name}_{side}") for body in bodies for side in ("x0", "y0")]
    supports = [*mirrors, held("lower_z0"), held("upper_z1", STRETCH - 1)]
    scene = BodyScene(bodies, supports, size=0.5, order=order, levels=1, contact=contact, accuracy=inf)
    return list(Simulation(scene).accepted_steps())[-1]
