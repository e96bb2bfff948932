"""Fibres in walls of prisms: where they run, derivatives, and homogeneous deformations."""

from __future__ import annotations

import ngsolve
import numpy as np
import pytest

from ngcell.geometry.bodies import BodyMesh
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.prisms import along_and_up, prism_mesh
from ngcell.geometry.sections import ring_section
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.fibres import ExponentialFibres, QuadraticFibres
from ngcell.mechanics.laws.law import FibreLaw
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.symbolic import EnergyForm

C1, C2, KAPPA, WALL, HEIGHT = 0.7, 0.3, 20.0, 0.3, 0.8
LATTICE = hexagonal_lattice(1, 1, side=1.0, pointy=True)
STEPS = np.array([4e-3, 2e-3, 1e-3])
LAWS = {
    "exponential": ExponentialFibres(stiffness=1.3, exponent=2.5, angles=np.degrees((0.6,)).tolist()),
    "two families": ExponentialFibres(stiffness=1.3, exponent=2.5, angles=np.degrees((0.5, -0.9)).tolist()),
    "quadratic": QuadraticFibres(stiffness=1.3, angles=np.degrees((0.0, 0.7)).tolist()),
}
#: Stretched in all directions, and sheared: no fibre is slack.
STRAIN = np.array([[0.2, 0.05, 0.1], [-0.04, 0.15, 0.03], [0.06, 0.02, 0.25]])


def cell(end_wall: float | None = None, layers: int = 1) -> BodyMesh:
    choices = {"wall": WALL, "radius": 0.0, "edges": 1, "layers": 1, "supports": {}, "closed": end_wall is not None}
    return prism_mesh(*[ring_section(LATTICE.outlines, **choices)] * layers, height=HEIGHT, slices=1, end_wall=end_wall)


def reinforced(space: DisplacementSpace, fibres: FibreLaw | None) -> EnergyForm:
    law = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=KAPPA, fibres=fibres)
    return BodyEnergy(space, [law] * space.body_count, along_and_up(space.bodies)).form


def energy_density(law: FibreLaw, gradient: np.ndarray, fibre: np.ndarray) -> float:
    """W of one family, from its definition."""
    strain = max(0.0, ((gradient @ fibre) ** 2).sum() - 1)
    if law.exponent_or_zero == 0:
        return law.stiffness / 2 * strain**2
    return law.stiffness / (2 * law.exponent_or_zero) * (np.exp(law.exponent_or_zero * strain**2) - 1)


@pytest.mark.parametrize("end_wall", [None, 0.2])
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_taylor_remainders_of_energy_and_forces_vanish_at_their_rates(law, end_wall):
    space = DisplacementSpace(cell(end_wall), 2)
    bulk, random = reinforced(space, law), np.random.default_rng(3)
    at = space.affine(STRAIN, np.zeros(3)).ravel() + 2e-3 * random.standard_normal(space.unknowns)
    way = 0.02 * random.standard_normal(space.unknowns)
    energy, force, bent = bulk.energy(at), bulk.gradient(at), bulk.tangent(at) @ way
    first = [abs(bulk.energy(at + h * way) - energy - h * force @ way) for h in STEPS]
    second = [abs(bulk.energy(at + h * way) - energy - h * force @ way - h * h / 2 * way @ bent) for h in STEPS]
    forces = [np.linalg.norm(bulk.gradient(at + h * way) - force - h * bent) for h in STEPS]
    for remainders, rate in ((first, 2), (second, 3), (forces, 2)):
        np.testing.assert_allclose(np.log2(np.array(remainders[:-1]) / remainders[1:]), rate, atol=0.15)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("layers", [1, 2])
def test_a_homogeneous_deformation_stores_the_energy_of_six_plane_walls(law, layers):
    """Each wall of a hollow cell is a sixth of its volume and has fibres of its own."""
    space = DisplacementSpace(cell(layers=layers), 1)
    at = space.affine(STRAIN, np.zeros(3)).ravel()
    found = reinforced(space, law).energy(at) - reinforced(space, None).energy(at)
    along = np.column_stack([np.roll(LATTICE.corners, -1, axis=0) - LATTICE.corners, np.zeros(6)])
    volume = 1.5 * np.sqrt(3) * (1 - (1 - WALL / (np.sqrt(3) / 2)) ** 2) * HEIGHT * layers
    meant = [
        energy_density(law, np.eye(3) + STRAIN, np.cos(angle) * one + np.sin(angle) * np.array([0.0, 0.0, 1.0]))
        for one in along
        for angle in law.radians
    ]
    assert found == pytest.approx(volume * np.mean(meant) * len(law.radians), rel=1e-12)


@pytest.mark.parametrize("stretch", [1.3, 0.8])
def test_fibres_along_the_axis_pull_on_its_ends_by_the_force_of_the_closed_form(stretch):
    """They leave stress across the axis as it is: the solid alone is in balance there."""
    law, space = ExponentialFibres(stiffness=1.5, exponent=2.0, angles=(90.0,)), DisplacementSpace(cell(), 2)
    at = space.affine(np.diag([0.9, 0.9, stretch]) - np.eye(3), np.zeros(3)).ravel()
    pull = (reinforced(space, law).gradient(at) - reinforced(space, None).gradient(at)).reshape(3, -1)
    area = 1.5 * np.sqrt(3) * (1 - (1 - WALL / (np.sqrt(3) / 2)) ** 2)
    strain = max(0.0, stretch**2 - 1)
    meant = 2 * law.stiffness * strain * np.exp(law.exponent_or_zero * strain**2) * stretch * area
    np.testing.assert_allclose(pull[:2], 0, atol=1e-12)
    upper_end = space.region_unknowns("upper-end")
    assert (pull[2] * space.one)[upper_end].sum() == pytest.approx(meant, rel=1e-12, abs=1e-14)
    assert (pull[2] * space.one).sum() == pytest.approx(0, abs=1e-12)


def test_stress_is_the_derivative_of_the_energy():
    law, gradient = LAWS["two families"], np.eye(3) + STRAIN
    frames = np.linalg.qr(np.random.default_rng(1).standard_normal((4, 3, 3)))[0][:, :, :2]
    frames = frames.transpose(0, 2, 1).reshape(4, 6)
    found = law.cauchy_stress(np.tile(gradient, (4, 1, 1)), frames)
    for stress, frame in zip(found, frames, strict=True):
        fibres = [np.cos(angle) * frame[:3] + np.sin(angle) * frame[3:] for angle in law.radians]
        nominal = np.zeros((3, 3))
        for place in np.ndindex(3, 3):
            step = np.zeros((3, 3))
            step[place] = 1e-6
            rise = [sum(energy_density(law, gradient + s * step, fibre) for fibre in fibres) for s in (1, -1)]
            nominal[place] = (rise[0] - rise[1]) / 2e-6
        np.testing.assert_allclose(stress, nominal @ gradient.T / np.linalg.det(gradient), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("layers", [1, 2])
def test_a_helix_goes_on_as_a_spiral_in_end_walls(layers):
    bodies = cell(0.2, layers)
    points = np.array([vertex.point for vertex in bodies.mesh.vertices])
    frames = along_and_up(bodies).reshape(-1, 2, 3)
    products = np.einsum("nad,nbd->nab", frames, frames)
    np.testing.assert_allclose(products, np.tile(np.eye(2), (len(frames), 1, 1)), atol=1e-12)
    ends = 0
    for element, (along, up) in zip(bodies.mesh.Elements(ngsolve.VOL), frames, strict=True):
        corners = points[[vertex.nr for vertex in element.vertices]]
        middle = corners.mean(0)
        middle[2] %= HEIGHT
        is_end = np.linalg.norm(corners[:, :2], axis=1).min() < 1e-9
        assert is_end == bodies.is_end_wall[element.nr]
        outward = np.append(middle[:2] / np.linalg.norm(middle[:2]), 0)
        np.testing.assert_allclose(np.cross([0, 0, 1.0], outward) @ along, 1, atol=1e-12)
        rising = outward * (1 if middle[2] < HEIGHT / 2 else -1) if is_end else [0, 0, 1]
        np.testing.assert_allclose(up, rising, atol=1e-12)
        ends += is_end
    assert ends == 6 * layers
