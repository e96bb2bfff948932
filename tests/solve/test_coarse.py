"""Low modes of bodies, and the inner problem among them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import linalg, sparse

from ngcell.solve.coarse import Bodies
from ngcell.solve.condensed import CondensedMatrix
from ngcell.solve.inner import minimise_one_sided
from ngcell.solve.linear import SymmetricMatrix
from ngcell.solve.low_modes import LowModes
from ngcell.solve.one_sided import OneSidedModel
from ngcell.solve.options import CoarseOptions, InnerOptions
from ngcell.solve.stiffness import Stiffness

OPTIONS = CoarseOptions(fewest=2, modes=2)


class Rows:
    """Rows of masses that are coupled, and each held softly: walls stand between a row and the next."""

    def __init__(self, bodies: int, masses: int = 16, soft: float = 1e-4) -> None:
        self.bodies, self.masses, self.size = bodies, masses, bodies * masses
        coupled = 2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
        coupled[0, 0] = coupled[-1, -1] = 1.0
        self.full = np.kron(np.eye(bodies), coupled + soft * np.eye(masses))
        self.part = np.repeat(np.arange(bodies), masses)
        self.free = np.ones(self.size, dtype=bool)
        self.free[0] = False
        self.rows, self.columns = np.nonzero(np.tril(self.full))
        self.values = self.full[self.rows, self.columns]

    @property
    def matrix(self) -> SymmetricMatrix:
        return SymmetricMatrix(self.size, self.free, self.rows, self.columns)

    def walls(self) -> sparse.csr_array:
        """What gaps between each mass and the same one of the next row depend on."""
        between = (self.bodies - 1) * self.masses
        shape = between, self.size
        return sparse.csr_array(sparse.eye_array(*shape, k=self.masses) - sparse.eye_array(*shape))

    def pushed(self, force: float) -> OneSidedModel:
        """The first row is pushed against the others, which stand apart."""
        gradient = np.zeros(self.size)
        gradient[1 : self.masses] = -force
        gap = 0.01 * (1 + np.random.default_rng(0).random((self.bodies - 1) * self.masses))
        penalty = np.full(len(gap), 1e3)
        return OneSidedModel(gradient, Stiffness(self.values), gap, self.walls(), penalty, self.free)

    def condensed(self, bodies: Bodies | None) -> CondensedMatrix:
        touched = np.arange(self.size)
        return CondensedMatrix(self.size, self.free, self.rows, self.columns, touched, 0.1, bodies)


def test_modes_are_the_lowest_of_each_body():
    rows = Rows(3)
    modes = LowModes(rows.free, rows.part, rows.free, 3)
    modes.iterate(rows.matrix, rows.values, 30)
    for body in range(3):
        mine = np.flatnonzero((rows.part == body) & rows.free)
        lowest = linalg.eigvalsh(rows.full[np.ix_(mine, mine)])[:3]
        np.testing.assert_allclose(modes.energies[body], lowest, rtol=1e-8)
    basis = modes.basis.toarray()
    np.testing.assert_allclose(basis.T @ basis, np.eye(9), atol=1e-12)
    np.testing.assert_allclose(basis.T @ rows.full @ basis, np.diag(modes.energies.ravel()), atol=1e-8)
    assert not basis[~rows.free].any()


def test_modes_of_a_matrix_that_changes_take_a_step_each():
    rows = Rows(2)
    modes = LowModes(rows.free, rows.part, rows.free, 4)
    modes.iterate(rows.matrix, rows.values, 10)
    for grown in np.linspace(1, 2, 5):
        modes.iterate(rows.matrix, grown * rows.values, 1)
    mine = np.flatnonzero((rows.part == 1) & rows.free)
    lowest = 2 * linalg.eigvalsh(rows.full[np.ix_(mine, mine)])[:4]
    np.testing.assert_allclose(modes.energies[1], lowest, rtol=1e-6)


def test_bodies_of_few_unknowns_have_no_modes():
    rows = Rows(3)
    rows.free[rows.part == 1] = False
    modes = LowModes(rows.free, rows.part, rows.free, 2)
    modes.iterate(rows.matrix, rows.values, 3)
    np.testing.assert_array_equal(modes.is_mode, np.repeat([True, False, True], 2))
    assert np.isfinite(modes.basis.data).all()
    assert not modes.basis.toarray()[rows.part == 1].any()


@pytest.mark.parametrize("times", [np.nan, 1e-200, 1e200])
def test_modes_of_a_matrix_without_an_inverse_or_next_to_none_are_none_and_begin_anew(times: float):
    """What a matrix next to none makes of a mode has no size, or one that is no number."""
    rows = Rows(2)
    modes = LowModes(rows.free, rows.part, rows.free, 2)
    before = modes.basis.data
    assert not modes.iterate(rows.matrix, times * rows.values, 1)
    np.testing.assert_array_equal(modes.basis.data, before)
    assert modes.iterate(rows.matrix, rows.values, 1)


def test_modes_are_forgotten():
    """What is found afterwards is the same to the last bit."""
    rows = Rows(3)
    modes = LowModes(rows.free, rows.part, rows.free, 2)
    found = []
    for _ in range(2):
        modes.forget()
        modes.iterate(rows.matrix, rows.values, 3)
        found.append(modes.basis.data)
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("force", [0.001, 0.1, 10.0])
def test_modes_change_what_the_minimum_takes_and_not_the_minimum(force):
    rows, exact = Rows(6), InnerOptions(most_rounds=200, worthwhile_gain=0.0, coarse=OPTIONS)
    model = rows.pushed(force)
    without = minimise_one_sided(model, rows.condensed(None), exact)
    within = minimise_one_sided(model, rows.condensed(Bodies(rows.part, OPTIONS)), exact)
    np.testing.assert_allclose(within.step, without.step, rtol=1e-6, atol=1e-9 * np.abs(without.step).max())
    assert within.change == pytest.approx(without.change, rel=1e-9)
    assert within.factorisations <= without.factorisations


def test_rows_that_hit_each_other_one_after_the_other_take_few_factorisations():
    rows, usual = Rows(12), InnerOptions(coarse=OPTIONS)
    model = rows.pushed(1.0)
    exact = minimise_one_sided(model, rows.condensed(None), replace(usual, most_rounds=500, worthwhile_gain=0.0))
    within = minimise_one_sided(model, rows.condensed(Bodies(rows.part, OPTIONS)), usual)
    without = minimise_one_sided(model, rows.condensed(None), usual)
    assert exact.change <= within.change < 0.5 * exact.change
    assert within.factorisations < without.factorisations


def test_a_model_that_is_not_convex_among_modes_is_told():
    rows = Rows(4)
    model = rows.pushed(1.0)
    bent = replace(model, stiffness=Stiffness(rows.values, sparse.csr_array(-0.5 * np.eye(rows.size))))
    found = minimise_one_sided(bent, rows.condensed(Bodies(rows.part, OPTIONS)), InnerOptions(coarse=OPTIONS))
    assert found.uphill is not None
    step = found.uphill.step
    assert found.uphill.change == pytest.approx(
        bent.change(step, rows.full @ step - 0.5 * step, bent.jacobian @ step), rel=1e-9, abs=1e-12
    )


def test_a_model_that_goes_up_at_once_is_minimised_as_without_modes():
    rows = Rows(4)
    model = rows.pushed(1.0)
    bent = replace(model, stiffness=Stiffness(rows.values, sparse.csr_array(-2.0 * np.eye(rows.size))))
    without = minimise_one_sided(bent, rows.condensed(None), InnerOptions(coarse=OPTIONS))
    within = minimise_one_sided(bent, rows.condensed(Bodies(rows.part, OPTIONS)), InnerOptions(coarse=OPTIONS))
    assert within.uphill is not None and without.uphill is not None
    assert within.uphill.change == without.uphill.change == 0.0
    np.testing.assert_allclose(within.step, without.step, rtol=1e-9, atol=1e-12)
    assert within.factorisations > without.factorisations


@pytest.mark.parametrize(
    ("bodies", "dimension", "is_bonded", "has_modes"),
    [(3, 2, False, False), (4, 2, False, True), (4, 2, True, False), (4, 3, False, False)],
)
def test_modes_are_of_many_planar_bodies_that_are_not_bonded(bodies, dimension, is_bonded, has_modes):
    problem = SimpleNamespace(part=np.repeat(np.arange(bodies), 5), dimension=dimension, has_history=is_bonded)
    assert (Bodies.of(problem, CoarseOptions(fewest=4)) is not None) == has_modes
