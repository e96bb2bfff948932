"""A law that a script gives as an expression of F: the same as the closed form wherever there is one."""

from __future__ import annotations

from math import inf

import ngsolve
import numpy as np
import pytest
from netgen import occ

from ngcell import Body, BodyScene, BodySupport, CustomLaw, MooneyRivlin, simulate
from ngcell.errors import CaseError

C1, KAPPA = 0.7, 20.0
CLOSED = MooneyRivlin(c1=C1, c2=0.0, bulk_modulus=KAPPA)


def isochoric(f: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
    return C1 / 2 * (ngsolve.Det(f) ** (-2 / 3) * ngsolve.Trace(f.trans * f) - 3)


def volumetric(j: ngsolve.CoefficientFunction) -> ngsolve.CoefficientFunction:
    return KAPPA / 2 * ngsolve.log(j) ** 2


LAWS = {
    "one expression": CustomLaw(lambda f: isochoric(f) + volumetric(ngsolve.Det(f))),
    "two parts": CustomLaw(isochoric, volumetric),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_moduli_and_stress_are_those_of_the_closed_form(law):
    assert law.shear_modulus == pytest.approx(C1, rel=1e-8)
    assert law.bulk_modulus == pytest.approx(KAPPA, rel=1e-8)
    assert law.plane_strain_modulus == pytest.approx(CLOSED.plane_strain_modulus, rel=1e-8)
    gradients = np.eye(3) + 0.3 * np.random.default_rng(1).uniform(-1, 1, (40, 3, 3))
    np.testing.assert_allclose(law.cauchy_stress(gradients), CLOSED.cauchy_stress(gradients), rtol=1e-11, atol=1e-12)
    assert law.softened(1.0) is law


def test_stress_of_an_energy_without_closed_form_here_is_its_derivative():
    """Saint Venant-Kirchhoff: P = F (lambda tr(E) I + 2 mu E), with moduli mu and lambda + 2 mu / 3 at rest."""
    mu, first = 0.8, 1.3

    def energy(f):
        strain = (f.trans * f - ngsolve.Id(3)) / 2
        return first / 2 * ngsolve.Trace(strain) ** 2 + mu * ngsolve.InnerProduct(strain, strain)

    law = CustomLaw(energy)
    assert law.shear_modulus == pytest.approx(mu, rel=1e-7)
    assert law.bulk_modulus == pytest.approx(first + 2 * mu / 3, rel=1e-7)
    (gradient,) = np.eye(3) + 0.2 * np.random.default_rng(2).uniform(-1, 1, (1, 3, 3))
    strain = (gradient.T @ gradient - np.eye(3)) / 2
    meant = gradient @ (first * np.trace(strain) * np.eye(3) + 2 * mu * strain) @ gradient.T / np.linalg.det(gradient)
    np.testing.assert_allclose(law.cauchy_stress(gradient[None])[0], meant, rtol=1e-12)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_sheared_block_does_not_tell_the_two_laws_apart(law):
    """Plane strain: the same energy, forces and stresses as with the law of the package."""

    def sheared(material):
        block = Body(occ.MoveTo(0, 0).Rectangle(1, 0.5).Face(), material, "block")
        block.shape.edges.Min(occ.Y).name, block.shape.edges.Max(occ.Y).name = "floor", "lid"
        moved = [BodySupport("floor"), BodySupport("lid", translation=(0.2, -0.05))]
        (step,) = simulate(BodyScene([block], moved, levels=1, size=0.5, accuracy=inf))
        return step

    mine, theirs = sheared(law), sheared(CLOSED)
    assert mine.record.energy == pytest.approx(theirs.record.energy, rel=1e-10)
    assert mine.record.plate_force_x == pytest.approx(theirs.record.plate_force_x, rel=1e-8)
    stress = [step.snapshot.bulk.point_data["cauchy_stress"] for step in (mine, theirs)]
    np.testing.assert_allclose(*stress, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize(
    ("energy", "says"),
    [
        (3.0, "energy of a law is 3.0; allowed: a function of the deformation gradient"),
        (lambda f: ngsolve.Trace(f.trans * f) - 3, "at rest; allowed: none where"),
        (lambda f: -1.0 * isochoric(f), "shear modulus -0.7.*; allowed: finite numbers > 0"),
        (lambda f: isochoric(f) + 7 + ngsolve.log(ngsolve.Det(f)) ** 2, "7 at rest; allowed: 0 where F is the iden"),
        (
            lambda f: ngsolve.InnerProduct(f - ngsolve.Id(3), f - ngsolve.Id(3)) + ngsolve.log(ngsolve.Det(f)) ** 2,
            "after a rotation; allowed: none, as at rest",
        ),
        (lambda f: None, "returns None; allowed: an NGSolve expression of one number"),
        (lambda f: f, "allowed: an NGSolve expression of one number"),
    ],
    ids=["no function", "stressed", "no stiffness", "stored at rest", "stressed by turns", "nothing", "a matrix"],
)
def test_what_is_no_law_is_refused(energy, says):
    with pytest.raises(CaseError, match=says):
        CustomLaw(energy)
