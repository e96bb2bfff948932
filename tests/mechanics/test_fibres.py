"""Fibres in walls: closed forms, tension only, derivatives, and where they run."""

from __future__ import annotations

from math import inf

import ngsolve
import numpy as np
import pytest
from scipy.optimize import brentq

from ngcell import BodyCase, simulate
from ngcell.geometry.sections import along_walls
from ngcell.mechanics.bulk import BodyEnergy
from ngcell.mechanics.laws.fibres import ExponentialFibres, QuadraticFibres
from ngcell.mechanics.laws.law import FibreLaw
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.symbolic import EnergyForm
from tests.tissues import SmallTissue, small_tissue

C1, C2, KAPPA = 0.7, 0.3, 20.0
LAWS = {
    "exponential": ExponentialFibres(stiffness=1.3, exponent=2.5, angles=np.degrees((0.6,)).tolist()),
    "two families": ExponentialFibres(stiffness=1.3, exponent=2.5, angles=np.degrees((0.5, -0.9)).tolist()),
    "quadratic": QuadraticFibres(stiffness=1.3, angles=np.degrees((0.0, 0.7)).tolist()),
}
STEPS = np.array([4e-3, 2e-3, 1e-3])


def reinforced(tissue: SmallTissue, fibres: FibreLaw | None, direction: np.ndarray | None = None) -> EnergyForm:
    count = len(tissue.bodies.body_of_element)
    everywhere = along_walls(tissue.bodies.mesh) if direction is None else np.tile(direction, (count, 1))
    law = MooneyRivlin(c1=C1, c2=C2, bulk_modulus=KAPPA, fibres=fibres)
    return BodyEnergy(tissue.space, [law] * tissue.bodies.body_count, everywhere).form


def first_piola(tissue: SmallTissue, bulk: EnergyForm, gradient: np.ndarray) -> np.ndarray:
    """Mean nominal stress under an affine deformation, by virtual work."""
    force = bulk.gradient(tissue.space.affine(gradient - np.eye(2), np.zeros(2)).ravel())
    basis = np.eye(4).reshape(4, 2, 2)
    work = [force @ tissue.space.affine(part, np.zeros(2)).ravel() for part in basis]
    return np.reshape(work, (2, 2)) / tissue.volume


def pull(law: FibreLaw, angle: float, stretch_square: float) -> float:
    """2 dW/dI4, from W = k1/(2 k2) (exp(k2 E^2) - 1): 2 k1 E exp(k2 E^2), with E = cos^2 (|F d|^2 - 1) in tension."""
    strain = max(0.0, np.cos(angle) ** 2 * (stretch_square - 1))
    return 2 * law.stiffness * strain * np.exp(law.exponent_or_zero * strain**2)


def matrix_stress(along: float, across: float) -> float:
    """Nominal stress of the solid itself at the stretches (along, across, 1), along the first."""
    first = along**2 + across**2 + 1
    second = along**2 * across**2 + along**2 + across**2
    jacobian = along * across
    one = jacobian ** (-2 / 3) * (along - first / (3 * along))
    two = jacobian ** (-4 / 3) * (along * (across**2 + 1) - 2 * second / (3 * along))
    return C1 * one + C2 * two + KAPPA * np.log(jacobian) / along


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("shear", [0.4, -0.4])
def test_simple_shear_has_the_stress_of_the_closed_form(law, shear):
    """With F a = cos(a) (gamma, 1) for fibres that stand across the shear, each adds pull cos^2 (gamma, 1) x (gamma, 1)
    to the Cauchy stress of the solid, dev(c1 B + c2 (I1 B - B^2)), since J = 1."""
    tissue = small_tissue(1, 1, order=2, wall=0.3)
    gradient = np.array([[1.0, shear], [0.0, 1.0]])
    found = first_piola(tissue, reinforced(tissue, law, np.array([0.0, 1.0])), gradient) @ gradient.T
    square = 1 + shear**2
    trace = 2 + square
    left = np.array([[square, shear, 0], [shear, 1, 0], [0, 0, 1]])
    whole = C1 * left + C2 * (trace * left - left @ left)
    meant = whole[:2, :2] - np.trace(whole) / 3 * np.eye(2)
    for angle in law.radians:
        moved = np.cos(angle) * np.array([shear, 1.0])
        meant = meant + pull(law, angle, square) * np.outer(moved, moved)
    np.testing.assert_allclose(found, meant, rtol=1e-8, atol=1e-10)
    assert meant[0, 1] == pytest.approx(
        (C1 + C2) * shear + sum(pull(law, a, square) * np.cos(a) ** 2 for a in law.radians) * shear, rel=1e-12
    )


@pytest.mark.parametrize("kind", ["exponential", "quadratic"])
@pytest.mark.parametrize("stretch", [1.3, 0.8])
def test_a_reinforced_block_is_pulled_by_the_force_of_the_closed_form(kind, stretch):
    """Free sides: across the fibres the solid alone is in balance; along them a pair of families adds its pull."""
    angle, chosen = 40.0, {"stiffness": 1.5, "angles": (40.0, -40.0)}
    law = ExponentialFibres(exponent=2.0, **chosen) if kind == "exponential" else QuadraticFibres(**chosen)
    fibres = {"kind": kind, "stiffness": 1.5, "angles": [angle, -angle], "direction": [2.0, 0.0]}
    case = BodyCase.model_validate(
        {
            "levels": 1,
            "bodies": [
                {
                    "name": "block",
                    "kind": "block",
                    "low": [0.0, 0.0],
                    "high": [1.0, 0.5],
                    "material": {
                        "kind": "mooney-rivlin",
                        "c1": C1,
                        "c2": C2,
                        "bulk_modulus": KAPPA,
                        "fibres": fibres | ({"exponent": 2.0} if kind == "exponential" else {}),
                    },
                }
            ],
            "supports": [
                {"boundary": "block_left", "components": "x"},
                {"boundary": "block_bottom", "components": "y"},
                {"boundary": "block_right", "components": "x", "translation": [stretch - 1, 0.0]},
            ],
            "mesh": {"size": 0.5, "order": 2},
            "accuracy": inf,
        }
    )
    (step,) = simulate(case)
    across = brentq(lambda width: matrix_stress(width, stretch), 0.3, 2.0, xtol=1e-15, rtol=1e-14)
    cosine = np.cos(np.radians(angle)) ** 2
    meant = matrix_stress(stretch, across) + 2 * pull(law, law.radians[0], stretch**2) * cosine * stretch
    assert step.record.plate_force_x == pytest.approx(0.5 * meant, rel=1e-8)
    stress = step.snapshot.bulk.point_data["cauchy_stress"].reshape(-1, 3, 3)
    np.testing.assert_allclose(stress[:, 0, 0], meant / across, rtol=1e-8)
    np.testing.assert_allclose(stress[:, 1, 1], 0, atol=1e-8)
    np.testing.assert_allclose(stress[:, 0, 2], 0, atol=1e-12)
    assert (stretch > 1) == (meant > matrix_stress(stretch, across))


def test_slack_fibres_and_those_along_the_axis_do_nothing():
    tissue = small_tissue(1, 1, order=2)
    squeezed = np.diag([0.8, 1.1])
    bare = first_piola(tissue, reinforced(tissue, None), squeezed)
    slack = ExponentialFibres(stiffness=5.0, exponent=2.0, angles=np.degrees((0.3,)).tolist())
    np.testing.assert_allclose(first_piola(tissue, reinforced(tissue, slack, np.array([1.0, 0.0])), squeezed), bare)
    upright = ExponentialFibres(stiffness=5.0, exponent=2.0, angles=(90.0,))
    around = reinforced(tissue, upright)
    state = tissue.smooth(0.3, 2)
    np.testing.assert_allclose(around.gradient(state), reinforced(tissue, None).gradient(state), atol=1e-12)
    taut = first_piola(tissue, reinforced(tissue, slack, np.array([0.0, 1.0])), squeezed)
    assert taut[1, 1] > bare[1, 1] + 0.1


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_taylor_remainders_of_energy_and_forces_vanish_at_their_rates(law):
    tissue = small_tissue(1, 1, order=2, edges=1)
    bulk = reinforced(tissue, law)
    # Blown up, so that no fibre turns slack along the way: the energy has a second derivative on either side only.
    blown = tissue.space.affine(np.diag([0.2, 0.15]), np.zeros(2)).ravel()
    at, way = blown + tissue.smooth(0.05, 1), tissue.smooth(0.5, 2)
    energy, force, bent = bulk.energy(at), bulk.gradient(at), bulk.tangent(at) @ way
    first = [abs(bulk.energy(at + h * way) - energy - h * force @ way) for h in STEPS]
    second = [abs(bulk.energy(at + h * way) - energy - h * force @ way - h * h / 2 * way @ bent) for h in STEPS]
    forces = [np.linalg.norm(bulk.gradient(at + h * way) - force - h * bent) for h in STEPS]
    for remainders, rate in ((first, 2), (second, 3), (forces, 2)):
        np.testing.assert_allclose(np.log2(np.array(remainders[:-1]) / remainders[1:]), rate, atol=0.15)


def test_forces_are_continuous_where_a_fibre_goes_slack():
    tissue = small_tissue(1, 1, order=1)
    bulk = reinforced(
        tissue, ExponentialFibres(stiffness=5.0, exponent=2.0, angles=np.degrees((0.0,)).tolist()), np.array([1.0, 0.0])
    )
    tight, slack = (first_piola(tissue, bulk, np.diag([1 + e, 1.0]))[0, 0] for e in (1e-7, -1e-7))
    taut = first_piola(tissue, bulk, np.diag([1.01, 1.0]))[0, 0]
    assert abs(tight - slack) < 1e-4 * taut


@pytest.mark.parametrize("radius", [0.0, 0.1])
@pytest.mark.parametrize("pointy", [True, False])
def test_fibres_run_along_the_wall_and_not_round_its_corners(radius, pointy):
    tissue = small_tissue(1, 2, edges=3, radius=radius, pointy=pointy)
    mesh, lattice = tissue.bodies.mesh, tissue.lattice
    points = np.array([vertex.point for vertex in mesh.vertices])
    for element, along in zip(mesh.Elements(ngsolve.VOL), along_walls(mesh), strict=True):
        body = tissue.bodies.body_of_element[element.nr]
        middle = points[[vertex.nr for vertex in element.vertices]].mean(0) - lattice.centres[body]
        wall = np.argmax(lattice.normals @ middle)
        slope = abs(along @ lattice.normals[wall])
        assert slope < (1e-12 if radius == 0 else 0.35)
        assert middle[0] * along[1] > middle[1] * along[0]  # counter-clockwise
