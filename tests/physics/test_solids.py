"""M1 to M3: what only solids can tell apart, the two constants of Mooney-Rivlin."""

from __future__ import annotations

from math import inf, pi

import numpy as np
import pytest
from netgen import occ
from scipy.integrate import quad

import ngcell
from ngcell.build.simulation import Simulation
from ngcell.scene import Body, BodyScene, BodySupport, MooneyRivlin, Pressure
from tools.references.radial import RadialSolid, inflated_radius, ring_with_free_rim

C1, C2, KAPPA = 0.8, 0.2, 1e4
STIFF = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=KAPPA)


def box() -> occ.Solid:
    """A unit cube with names x0, x1, ... on its sides."""
    solid = occ.Box((0, 0, 0), (1, 1, 1))
    for axis in "xyz":
        solid.faces.Min(getattr(occ, axis.upper())).name = f"{axis}0"
        solid.faces.Max(getattr(occ, axis.upper())).name = f"{axis}1"
    return solid


def mirror(boundary: str) -> BodySupport:
    """A plane of symmetry, normal to the axis that its name begins with."""
    return BodySupport(boundary, components=tuple(axis == boundary[0] for axis in "xyz"))


def stress_of(scene: BodyScene) -> np.ndarray:
    """Uniform Cauchy stress at the last level."""
    step = ngcell.simulate(scene)[-1]
    assert step.record.certified
    stress = step.snapshot.bulk.point_data["cauchy_stress"].reshape(-1, 3, 3)
    assert np.ptp(stress, axis=0).max() < 1e-6
    return stress.mean(0)


@pytest.mark.parametrize("order", [1, 2])
def test_simple_shear_between_free_faces(order):
    gamma = 0.5
    shear = ((0.0, gamma, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    sides = [BodySupport(side, shear, components=(True, True, False)) for side in ("x0", "x1", "y0", "y1")]
    scene = BodyScene(
        [Body(box(), STIFF, "cube")], [*sides, mirror("z0")], size=0.6, order=order, levels=1, accuracy=inf
    )
    stress = stress_of(scene)
    assert stress[0, 1] == pytest.approx((C1 + C2) * gamma, rel=1e-3)
    assert stress[0, 0] == pytest.approx(C1 * gamma**2, rel=1e-3)
    assert stress[1, 1] == pytest.approx(-C2 * gamma**2, rel=2e-3)
    assert stress[2] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("stretch", [0.8, 1.3])
def test_uniaxial_stretch_between_free_faces(stretch):
    pull = BodySupport("z1", translation=(0.0, 0.0, stretch - 1), components=(False, False, True))
    supports = [mirror("x0"), mirror("y0"), mirror("z0"), pull]
    scene = BodyScene([Body(box(), STIFF, "cube")], supports, size=0.6, order=2, levels=1, accuracy=inf)
    expected = (C1 + C2 / stretch) * (stretch**2 - 1 / stretch)
    assert stress_of(scene)[2, 2] == pytest.approx(expected, rel=1e-4)


def incompressible_inflation(bore: float, rim: float, radius: float) -> float:
    """M3: pressure in a shell whose bore is brought to a radius."""
    swelling = radius**3 - bore**3

    def drop(place: float) -> float:
        stretch = place / (place**3 - swelling) ** (1 / 3)
        stress = C1 * (stretch**2 - stretch**-4) + C2 * (stretch**4 - stretch**-2)
        return 2 * stress / place

    return quad(drop, radius, (rim**3 + swelling) ** (1 / 3))[0]


def test_radial_shells_have_the_listed_numbers():
    pressure = incompressible_inflation(1.0, 1.5, 1.5)
    assert pressure == pytest.approx(0.564118, abs=5e-7)
    shell = ring_with_free_rim(RadialSolid(C1, C2, 1e6, around=2), 1.0, 1.5, 1.5)
    assert shell.inner_pressure == pytest.approx(pressure, rel=1e-5)
    assert shell.outer == pytest.approx(1.791524, abs=5e-6)


def test_shell_under_inner_pressure_swells_as_the_radial_solution():
    """An octant; planes of symmetry bear the resultant of the pressure on the deformed bore."""
    kappa, load = 100.0, 0.5
    solid = RadialSolid(C1, C2, kappa, around=2)
    bore = inflated_radius(solid, 1.0, 1.5, load)
    sphere = occ.Sphere((0, 0, 0), 1.5) - occ.Sphere((0, 0, 0), 1.0)
    octant = (sphere * occ.Box((0, 0, 0), (2, 2, 2))).solids[0]
    for face in octant.faces:
        at = face.center
        flat = [axis for axis, value in zip("xyz", (at.x, at.y, at.z), strict=True) if abs(value) < 1e-9]
        face.name = f"{flat[0]}0" if flat else "bore" if at.x**2 + at.y**2 + at.z**2 < 1 else "rim"
    material = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=kappa)
    scene = BodyScene(
        [Body(octant, material, "shell", untouched=("x0", "y0", "z0", "bore"))],
        [mirror(plane) for plane in ("x0", "y0", "z0")],
        size=0.4,
        order=3,
        levels=1,
        loads=[Pressure(boundary="bore", value=load)],
        accuracy=inf,
    )
    simulation = Simulation(scene)
    step = list(simulation.accepted_steps())[-1]
    assert step.record.certified
    grid = step.snapshot.bulk
    inner = np.abs(np.linalg.norm(grid.points, axis=1) - 1.0) < 1e-3
    radius = np.linalg.norm((grid.points + grid.point_data["displacement"])[inner], axis=1)
    assert radius.mean() == pytest.approx(bore, rel=2e-3)
    normal_force = simulation.motion.resultant(step.measurement.reaction, "z0")[2]
    assert normal_force == pytest.approx(-load * pi / 4 * radius.mean() ** 2, rel=2e-3)
