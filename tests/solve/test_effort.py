"""The work of a step: the same up to the usual ratio of bulk to shear modulus, more where volumes are kept."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from ngcell.solve.effort import USUAL_BULK, Budget, Effort, OutOfIterations, share_of_work


@pytest.mark.parametrize("bulk", [0.0, 1.0, USUAL_BULK])
def test_the_usual_work_is_given_up_to_the_usual_ratio(bulk):
    assert share_of_work(bulk) == 1.0


@pytest.mark.parametrize("stiffer", [8.0, 1000.0])
def test_more_work_is_given_as_steps_along_a_curved_valley_get_shorter(stiffer):
    """The best straight step along a circular valley, by its energy: a slope along it, a stiffness across it."""

    def best(kappa: float) -> float:
        def energy(step: float) -> float:
            return -1e-3 * np.arctan(step) + kappa / 2 * (np.hypot(1, step) - 1) ** 2

        return float(minimize_scalar(energy, bounds=(0, 0.2), method="bounded", options={"xatol": 1e-10}).x)

    assert share_of_work(stiffer * USUAL_BULK) == pytest.approx(best(10.0) / best(10.0 * stiffer), rel=0.01)


def test_a_budget_counts_all_efforts_of_a_step():
    budget, one, two = Budget(5), Effort(), Effort()
    budget.charge(one)
    budget.charge(two)
    one.factorisations, two.refusals = 2, 3
    with pytest.raises(OutOfIterations):
        budget.charge(one)
    budget.renew()
    budget.charge(one)


def test_a_step_that_goes_on_to_a_finer_mesh_may_take_more():
    budget, effort = Budget(5), Effort()
    budget.charge(effort)
    budget.renew(3.0)
    effort.factorisations = 14
    budget.charge(effort)
    effort.refusals = 1
    with pytest.raises(OutOfIterations):
        budget.charge(effort)
