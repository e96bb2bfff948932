"""Runs that are asked for an accuracy: what is reported is as good as is told, or refused."""

from __future__ import annotations

from functools import cache
from math import isfinite, isnan

import numpy as np
import pytest

import ngcell
from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.results.error import ERROR_NAMES

SMALL = ("tissue.rows=1", "tissue.cols=2", "load.displacement=[0.2, 0.0]", "load.levels=1")


@cache
def steps(*sets: str, case: str = "shear-empty-3x3") -> list[Step]:
    return ngcell.simulate(ngcell.read_case(case, [*SMALL, *sets]))


def failures(step: Step) -> tuple[str, ...]:
    return step.measurement.certificate.failures


def test_a_shipped_tissue_is_certified_and_as_far_from_a_finer_one_as_it_says_at_most():
    *_, found = steps()
    *_, finer = steps("accuracy=0.003")
    assert found.record.certified and finer.record.certified
    assert all(isfinite(getattr(found.record, f"{name}_error")) for name in ERROR_NAMES)
    assert found.record.energy_error < 0.01 * found.record.energy
    assert found.record.plate_force_error < 0.01 * np.hypot(found.record.plate_force_x, found.record.plate_force_y)
    (check,) = (check for check in found.measurement.certificate.checks if check.name == "estimated_error")
    assert 0 < check.value <= check.limit == 0.01
    assert abs(found.record.energy - finer.record.energy) <= found.record.energy_error
    assert finer.record.energy_error < found.record.energy_error


def test_a_low_accuracy_takes_a_coarser_mesh():
    rough, usual = steps("accuracy=0.1")[-1], steps()[-1]
    assert rough.record.certified
    assert rough.mesh.unknowns < usual.mesh.unknowns
    assert rough.record.energy_error < 0.1 * rough.record.energy


def test_a_mesh_that_is_too_coarse_is_refused_for_its_estimated_error_alone():
    *_, step = steps("mesh.order=1")
    assert (step.mesh.order, step.mesh.grading) == (1, 0)
    assert failures(step) == ("estimated_error",)
    assert not step.record.certified
    *_, plain = steps("mesh.order=1", "accuracy=inf")
    assert plain.record.certified and isnan(plain.record.energy_error)
    assert step.record.energy == pytest.approx(plain.record.energy, rel=1e-5)  # its numbers are those of its mesh


def test_tied_steps_are_not_held_to_the_accuracy():
    tied, released = steps()
    assert (tied.record.phase, released.record.phase) == ("tied", "released")
    assert "estimated_error" not in {check.name for check in tied.measurement.certificate.checks}
    assert isfinite(tied.record.energy_error)


def test_fluids_keep_the_areas_of_their_lumens_on_the_finer_mesh():
    simulation = Simulation(ngcell.read_case("shear-empty-3x3", FLUID))
    *_, step = simulation.accepted_steps()
    assert step.record.phase == "released" and failures(step) == ()
    assert step.mesh.unknowns > simulation.space.unknowns
    (check,) = (check for check in step.measurement.certificate.checks if "area" in check.name)
    assert check.passed
    assert np.ptp([row.pressure for row in step.cells]) > 0


@pytest.mark.parametrize("strategy", ["sddp", "single-step"])
def test_the_mortar_is_refined_as_well(strategy: str):
    mortar, penalty = (steps(f"contact.kind={kind}", f"strategy.kind={strategy}")[-1] for kind in ("mortar", "penalty"))
    assert failures(mortar) == ()
    assert mortar.mesh.order > 2
    told = mortar.record.energy_error + penalty.record.energy_error
    assert mortar.record.energy == pytest.approx(penalty.record.energy, abs=told)


def test_bonds_are_not_estimated_and_say_so():
    *_, step = steps("cohesion.strength=0.01", "cohesion.energy=0.0001", "strategy.kind=load-stepping")
    assert all(isnan(getattr(step.record, f"{name}_error")) for name in ERROR_NAMES)
    assert "estimated_error" not in {check.name for check in step.measurement.certificate.checks}
    assert (step.mesh.order, step.mesh.grading) == (3, 0)
    assert step.record.certified


def test_bodies_that_a_script_draws_are_refined():
    usual, plain = (ngcell.simulate(ngcell.read_case("stacked-blocks", sets))[-1] for sets in ([], ["accuracy=inf"]))
    assert "estimated_error" not in failures(usual) and plain.mesh.order == 2
