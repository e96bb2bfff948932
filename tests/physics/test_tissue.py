"""The sheared tissue: T1, T2 and T3, and what a rigid motion must not do."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import ngcell
from ngcell.run import Step

BASE = ["load.displacement=[0.5, 0.0]", "tissue.cols=2"]


@cache
def contact_steps(strategy: str, levels: int) -> list[Step]:
    sets = [*BASE, f"strategy.kind={strategy}", f"load.levels={levels}"]
    steps = ngcell.simulate(ngcell.read_case("shear-empty-3x3", [*sets, "accuracy=inf"]))
    return [step for step in steps if step.record.phase == "released"]


def test_t1_both_strategies_end_at_the_same_equilibrium_at_every_level():
    for one, two in zip(contact_steps("sddp", 3), contact_steps("single-step", 3), strict=True):
        for column in ("energy", "plate_force_x", "mean_gap", "largest_gap"):
            assert getattr(one.record, column) == pytest.approx(getattr(two.record, column), rel=1e-4)


@pytest.mark.parametrize("strategy", ["sddp", "single-step"])
def test_the_result_is_the_same_from_few_and_many_load_steps(strategy: str):
    few, many = (contact_steps(strategy, levels)[-1] for levels in (1, 3))
    assert few.record.energy == pytest.approx(many.record.energy, rel=1e-8)
    # The places of floating cells included.
    assert np.abs(few.displacement - many.displacement).max() < 1e-4


def test_t2_every_accepted_step_is_complementary():
    for step in contact_steps("sddp", 3):
        checks = {check.name: check for check in step.measurement.certificate.checks}
        assert step.record.certified
        assert checks["tension"].value == 0
        assert checks["penetration_over_wall"].value < 0.01
        assert checks["complementarity"].value < 0.01


def test_t3_no_step_stores_more_than_the_supports_put_in():
    steps = contact_steps("sddp", 3)
    work = load = rate = 0.0
    for step in steps:
        measured = step.measurement
        advance = measured.load_factor - load
        work += advance * (measured.work.support_work_rate + rate) / 2
        slack = advance * abs(measured.work.support_work_rate - rate) / 2
        load, rate = measured.load_factor, measured.work.support_work_rate
        assert measured.energy <= work + slack
    assert work > 0


def test_t3_the_work_on_the_tied_solid_is_its_energy():
    sets = [*BASE, "load.levels=[1.0]", "strategy.steps=16"]
    steps = ngcell.simulate(ngcell.read_case("shear-empty-3x3", [*sets, "accuracy=inf"]))
    tied = [step.measurement for step in steps if step.record.phase == "tied"]
    load = np.array([0.0, *(one.load_factor for one in tied)])
    rate = np.array([0.0, *(one.work.support_work_rate for one in tied)])
    # Fourth-order differences: the trapezoidal error of 16 steps is removed by extrapolation from 8.
    fine, coarse = np.trapezoid(rate, load), np.trapezoid(rate[::2], load[::2])
    assert (4 * fine - coarse) / 3 == pytest.approx(tied[-1].energy, rel=1e-5)


def test_a_turned_frame_leaves_no_stress_and_no_gap():
    cosine, sine = np.cos(0.4), np.sin(0.4)
    load = ngcell.Frame(deformation_gradient=((cosine, -sine), (sine, cosine)), levels=(1.0,))
    case = ngcell.read_case("frame-shear", ["tissue.rows=3", "tissue.cols=3", "accuracy=inf"]).model_copy(
        update={"load": load}
    )
    step = ngcell.simulate(case)[-1]
    assert step.record.energy < 1e-16
    assert abs(step.record.largest_gap) < 1e-9 and abs(step.record.smallest_gap) < 1e-9
    assert step.record.contact_force < 1e-9
