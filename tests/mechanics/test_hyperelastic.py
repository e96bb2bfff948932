"""Mooney-Rivlin at a material point: energy against stress, symmetries, the limit of small strains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from tests.tissues import rotation

LAWS = [MooneyRivlin(c1=0.8, c2=0.2, bulk_modulus=50.0), MooneyRivlin(c1=1.0, c2=0.0, bulk_modulus=10.0)]


@dataclass(frozen=True)
class Gradient:
    """Numbers in place of a coefficient function: the same formulas accept both."""

    values: np.ndarray

    @property
    def shape(self) -> tuple[int, ...]:
        return self.values.shape

    def __getitem__(self, index: tuple[int, int]) -> float:
        return float(self.values[index])


def stored_energy(law: MooneyRivlin, gradient: np.ndarray) -> float:
    return float(law.stored_energy(Gradient(gradient)))


def solid_energy(law: MooneyRivlin, gradient: np.ndarray) -> float:
    """The energy in three dimensions, from the invariants of the right Cauchy-Green tensor."""
    jacobian = np.linalg.det(gradient)
    right = gradient.T @ gradient * jacobian ** (-2 / 3)
    first = np.trace(right)
    second = (first**2 - np.trace(right @ right)) / 2
    return law.c1 / 2 * (first - 3) + law.c2 / 2 * (second - 3) + law.bulk_modulus / 2 * np.log(jacobian) ** 2


def derivative(function, at: np.ndarray, size: float = 1e-4) -> np.ndarray:
    """Central differences of fourth order by every entry."""
    result = np.zeros(at.shape)
    for index in np.ndindex(at.shape):
        step = np.zeros(at.shape)
        step[index] = size
        near = function(at + step) - function(at - step)
        far = function(at + 2 * step) - function(at - 2 * step)
        result[index] = (8 * near - far) / (12 * size)
    return result


def random_gradient(seed: int, dimension: int = 2) -> np.ndarray:
    return np.eye(dimension) + 0.3 * np.random.default_rng(seed).uniform(-1, 1, (dimension, dimension))


def solid(gradient: np.ndarray) -> np.ndarray:
    """Plane strain: no stretch out of the plane."""
    full = np.eye(3)
    full[:2, :2] = gradient
    return full


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seed", range(4))
def test_plane_strain_energy_is_the_solid_one_without_stretch_out_of_the_plane(law, seed):
    gradient = random_gradient(seed)
    assert stored_energy(law, gradient) == pytest.approx(solid_energy(law, solid(gradient)), rel=1e-12)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seed", range(4))
def test_energy_of_a_solid_is_that_of_the_invariants(law, seed):
    gradient = random_gradient(seed, 3)
    assert stored_energy(law, gradient) == pytest.approx(solid_energy(law, gradient), rel=1e-12)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seed", range(4))
def test_cauchy_stress_is_the_derivative_of_the_energy(law, seed):
    gradient = random_gradient(seed, 3)
    first_piola = derivative(lambda at: solid_energy(law, at), gradient)
    expected = first_piola @ gradient.T / np.linalg.det(gradient)
    np.testing.assert_allclose(law.cauchy_stress(gradient[None])[0], expected, atol=1e-8)


@pytest.mark.parametrize("law", LAWS)
def test_in_plane_stress_is_the_derivative_of_the_plane_strain_energy(law):
    gradient = random_gradient(7)
    first_piola = derivative(lambda at: stored_energy(law, at), gradient)
    expected = first_piola @ gradient.T / np.linalg.det(gradient)
    np.testing.assert_allclose(law.cauchy_stress(solid(gradient)[None])[0, :2, :2], expected, atol=1e-8)


@pytest.mark.parametrize("law", LAWS)
def test_energy_sees_neither_a_rotation_of_the_frame_nor_one_of_the_isotropic_material(law):
    gradient = random_gradient(3)
    energy = stored_energy(law, gradient)
    assert stored_energy(law, rotation(1.1) @ gradient) == pytest.approx(energy, rel=1e-12)
    assert stored_energy(law, gradient @ rotation(0.4)) == pytest.approx(energy, rel=1e-12)
    turned = law.cauchy_stress((solid(rotation(1.1)) @ solid(gradient))[None])[0]
    stress = law.cauchy_stress(solid(gradient)[None])[0]
    np.testing.assert_allclose(turned, solid(rotation(1.1)) @ stress @ solid(rotation(1.1)).T, atol=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_simple_shear_has_the_shear_stress_mu_gamma_whatever_the_split(law):
    gamma = 0.5
    stress = law.cauchy_stress(solid(np.array([[1, gamma], [0, 1]]))[None])[0]
    assert stress[0, 1] == pytest.approx(law.shear_modulus * gamma, rel=1e-12)
    assert stress[0, 0] - stress[1, 1] == pytest.approx(law.shear_modulus * gamma**2, rel=1e-12)
    # Beyond the stress out of the plane, these are the classical values: c1 gamma^2 and -c2 gamma^2.
    assert stress[0, 0] - stress[2, 2] == pytest.approx(law.c1 * gamma**2, rel=1e-12)
    assert stress[1, 1] - stress[2, 2] == pytest.approx(-law.c2 * gamma**2, abs=1e-12)
    assert np.trace(stress) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_moduli_are_those_of_small_strains(law):
    size = 1e-4

    def curvature(strain: np.ndarray) -> float:
        way = size * strain
        return (stored_energy(law, np.eye(2) + way) + stored_energy(law, np.eye(2) - way)) / size**2

    confined = curvature(np.diag([1.0, 0.0]))
    coupling = curvature(np.eye(2)) / 2 - confined
    assert curvature(np.array([[0.0, 1.0], [1.0, 0.0]])) / 4 == pytest.approx(law.shear_modulus, rel=1e-5)
    # Free to give way sideways in the plane, held out of it.
    assert confined - coupling**2 / confined == pytest.approx(law.plane_strain_modulus, rel=1e-4)
    assert coupling + law.shear_modulus * 2 / 3 == pytest.approx(law.bulk_modulus, rel=1e-4)


def test_nothing_is_stored_at_rest_and_infinitely_much_towards_collapse():
    law = LAWS[0]
    assert stored_energy(law, np.eye(2)) == pytest.approx(0, abs=1e-15)
    flat = [stored_energy(law, np.diag([1, height])) for height in (0.5, 0.1, 1e-3, 1e-6)]
    assert (np.diff(flat) > 0).all()
    assert (law.cauchy_stress(np.eye(3)[None]) == 0).all()
