"""Multipliers that a model foresees, against the conditions of the quadratic program that they solve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from ngcell.solve.foreseen import foreseen_multipliers
from ngcell.solve.growing import GrowingMatrix
from ngcell.solve.one_sided import OneSidedModel
from ngcell.solve.options import InnerOptions
from ngcell.solve.stiffness import Stiffness

UNKNOWNS, TERMS = 12, 7
OPTIONS = InnerOptions(most_updates=2000)


def pressed(seed: int, stiff: float) -> tuple[OneSidedModel, GrowingMatrix, np.ndarray]:
    """A model pressed against walls, its matrix, and the same as an array."""
    random = np.random.default_rng(seed)
    root = random.standard_normal((UNKNOWNS, UNKNOWNS))
    full = root @ root.T + 0.5 * np.eye(UNKNOWNS)
    rows, columns = np.tril_indices(UNKNOWNS)
    free = np.ones(UNKNOWNS, dtype=bool)
    jacobian = random.standard_normal((TERMS, UNKNOWNS))
    pressure = random.uniform(-1, 1, TERMS)  # some walls press, others are left
    gradient = jacobian.T @ pressure + 0.1 * random.standard_normal(UNKNOWNS)
    gap, penalty = random.uniform(-0.05, 0.1, TERMS), stiff * random.uniform(0.5, 2, TERMS)
    matrix = GrowingMatrix(UNKNOWNS, free, rows, columns)
    model = OneSidedModel(gradient, Stiffness(full[rows, columns]), gap, sparse.csr_array(jacobian), penalty, free)
    return model, matrix, full


@pytest.mark.parametrize("stiff", [1.0, 30.0])
@pytest.mark.parametrize("seed", range(10))
def test_the_conditions_of_the_model_hold_with_the_multipliers_that_are_foreseen(seed, stiff):
    model, matrix, full = pressed(seed, stiff)
    lowered = np.random.default_rng(seed).uniform(0, 0.1, TERMS)
    begun = replace(model, gap=model.gap - lowered)
    found = foreseen_multipliers(begun, lowered, matrix, 1e-12, OPTIONS)
    gap, pressure = model.gap + model.jacobian @ found.step, model.penalty * found.lowered
    assert found.missed <= 1e-12 and (pressure >= 0).all() and (pressure > 0).any()
    np.testing.assert_allclose(model.gradient + full @ found.step, model.jacobian.T @ pressure, atol=1e-9)
    assert gap.min() > -1e-10
    assert np.abs(pressure * gap).max() < 1e-9


def test_a_constraint_without_a_multiplier_stays_a_penalty_term():
    model, matrix, full = pressed(2, 5.0)
    lowered = np.full(TERMS, 0.01)
    lowered[::2] = np.nan
    begun = replace(model, gap=model.gap - np.nan_to_num(lowered))
    found = foreseen_multipliers(begun, lowered, matrix, 1e-12, OPTIONS)
    gap = model.gap + model.jacobian @ found.step
    soft = np.isnan(lowered)
    force = model.penalty * np.where(soft, np.maximum(-gap, 0), found.lowered)
    assert (found.lowered[soft] == 0).all() and gap[soft].min() < -1e-3 and gap[~soft].min() > -1e-10
    np.testing.assert_allclose(model.gradient + full @ found.step, model.jacobian.T @ force, atol=1e-9)


def test_walls_that_are_stiff_beside_their_penalty_terms_take_a_factorisation_and_few_updates():
    """One by one, updates would leave 99 % of the gap each time."""
    one = np.zeros(1, dtype=np.int64)
    matrix, free = GrowingMatrix(1, np.ones(1, dtype=bool), one, one), np.ones(1, dtype=bool)
    jacobian = sparse.csr_array(np.array([[1.0]]))
    model = OneSidedModel(np.array([99.0]), Stiffness(np.array([99.0])), np.zeros(1), jacobian, np.ones(1), free)
    found = foreseen_multipliers(model, np.zeros(1), matrix, 1e-4, InnerOptions(most_updates=100))
    assert found.factorisations == 2  # once open, once closed
    assert found.missed <= 1e-4
    assert found.lowered[0] == pytest.approx(99.0, rel=0.01)
