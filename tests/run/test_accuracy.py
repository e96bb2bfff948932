"""Runs that are asked for an accuracy: what is reported is as good as is told, or refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import inf, isfinite, isnan, nan
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

import ngcell
from ngcell.build import mesh_level, meshed
from ngcell.build.options import Options
from ngcell.build.refinement import Refinement
from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.build.stages import Stage
from ngcell.cli.summary import summary_lines
from ngcell.errors import CaseError
from ngcell.export import read_summary
from ngcell.results.equilibrium import numbers_of
from ngcell.results.error import ERROR_NAMES, Numbers
from ngcell.results.finding import compare
from ngcell.results.quantities import View
from ngcell.scene import Expected
from ngcell.solve.continuation_options import ContinuationOptions
from ngcell.solve.effort import OutOfIterations
from ngcell.solve.minimum import Minimum
from ngcell.solve.options import SolverOptions
from ngcell.solve.refined import settled

SMALL = ("tissue.rows=2", "tissue.cols=2", "load.displacement=[0.3, 0.0]", "load.levels=1")
PAIR = ("tissue.rows=1", "tissue.cols=2", "load.displacement=[0.2, 0.0]", "load.levels=1")


@cache
def steps(*sets: str) -> list[Step]:
    return ngcell.simulate(ngcell.read_case("shear-empty-3x3", [*SMALL, *sets]))


def failures(step: Step) -> tuple[str, ...]:
    return step.measurement.certificate.failures


def test_a_shipped_tissue_is_certified_and_no_further_from_a_finer_one_than_it_says():
    *_, found = steps("accuracy=0.1")
    *_, finer = steps()
    assert found.record.certified and finer.record.certified
    assert all(isfinite(getattr(found.record, f"{name}_error")) for name in ERROR_NAMES)
    for step, accuracy in ((found, 0.1), (finer, 0.01)):
        record = step.record
        assert record.energy_error < accuracy * record.energy
        assert record.plate_force_error < accuracy * np.hypot(record.plate_force_x, record.plate_force_y)
        assert record.mean_gap_error < accuracy * record.mean_gap
        (check,) = (check for check in step.measurement.certificate.checks if check.name == "estimated_error")
        assert 0 < check.value <= check.limit == accuracy
    assert finer.mesh.unknowns > found.mesh.unknowns
    assert 0 < abs(found.record.energy - finer.record.energy) <= found.record.energy_error


def share_that_holds_bodies(step: Step) -> float:
    (check,) = (check for check in step.measurement.certificate.checks if check.name == "stabilisation")
    return check.value


def test_the_proximal_term_holds_bodies_where_they_are_and_leaves_no_force():
    *_, found = steps()
    *_, of_one_centre = steps("accuracy=inf")
    assert share_that_holds_bodies(found) < 1e-6
    assert share_that_holds_bodies(found) < share_that_holds_bodies(of_one_centre)


def test_the_weight_with_which_it_does_changes_nothing_that_was_asked_for():
    *_, usual = steps()
    continuation = ContinuationOptions(recentred=1e-3)
    case = ngcell.read_case("shear-empty-3x3", SMALL)
    *_, other = ngcell.simulate(case, options=Options(solver=SolverOptions(continuation=continuation)))
    assert other.record.certified
    assert other.record.energy == pytest.approx(usual.record.energy, rel=1e-3)
    assert other.record.plate_force_x == pytest.approx(usual.record.plate_force_x, rel=5e-3)
    assert other.record.mean_gap == pytest.approx(usual.record.mean_gap, rel=5e-3)


def test_what_the_energy_may_still_fall_counts_in_its_error(monkeypatch: pytest.MonkeyPatch):
    """Too few centres for a large weight: what may still fall is told by them, though bodies come to rest later."""
    falls = list[float]()

    def without_falls(*given: Any) -> Numbers:
        falls.append(given[-1])
        return numbers_of(*given[:-1], 0.0)

    continuation = ContinuationOptions(recentred=0.1, most_recentred=2)
    case = ngcell.read_case("shear-empty-3x3", [*SMALL, "accuracy=0.1"])
    *_, rushed = ngcell.simulate(case, options=Options(solver=SolverOptions(continuation=continuation)))
    *_, usual = steps("accuracy=0.1")
    # It goes on to a finer mesh, on which energies are lower, and so is what the mesh errs by.
    assert rushed.record.energy_error > abs(rushed.record.energy - usual.record.energy)
    assert rushed.record.energy_error > usual.record.energy_error
    monkeypatch.setattr(meshed, "numbers_of", without_falls)
    *_, untold = ngcell.simulate(case, options=Options(solver=SolverOptions(continuation=continuation)))
    assert falls[-1] > 0.02 * rushed.record.energy_error
    assert rushed.record.energy_error - untold.record.energy_error == pytest.approx(falls[-1], rel=1e-6)
    # No body is held: as long as one is, there are more centres, under smaller weights, and it comes to rest.
    assert not failures(rushed)


def test_how_far_the_mean_gap_changed_as_walls_slid_to_rest_is_told():
    *_, slid = ngcell.simulate(
        ngcell.read_case("shear-empty-3x3", ["load.displacement=[0.4, 0.0]", "load.levels=1", "accuracy=0.1"])
    )
    assert 0 < slid.record.mean_gap_slid < 0.1 * slid.record.mean_gap
    *_, of_one_centre = steps("accuracy=inf")
    assert of_one_centre.record.mean_gap_slid == 0


def test_where_walls_have_slid_far_as_they_came_to_rest_a_finer_mesh_tells_the_error(monkeypatch: pytest.MonkeyPatch):
    """Meshes before tell nothing of where walls have come to: the error is told by what the finer one changes."""
    *_, usual = steps("accuracy=0.1")
    slid, asked = Refinement._slid, list[Numbers]()

    def slid_once(refinement: Refinement[Simulation], led: Numbers, times: float) -> float:
        asked.append(led)
        return inf if len(asked) == 1 else slid(refinement, led, times)

    monkeypatch.setattr(Refinement, "_slid", slid_once)
    *_, step = ngcell.simulate(ngcell.read_case("shear-empty-3x3", [*SMALL, "accuracy=0.1"]))
    assert step.record.certified and len(step.meshes) == len(usual.meshes) + 1
    changed = abs(step.record.energy - asked[0].energy)
    assert 0 < step.record.energy_error < usual.record.energy_error
    assert step.record.energy_error < changed  # a finer mesh errs by a share of what it has changed


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
    *_, plain = steps("mesh.order=1", "accuracy=inf", "contact.stiffness=10.0")  # as stiff as the accuracy asks
    assert plain.record.certified and isnan(plain.record.energy_error)
    assert step.record.energy == pytest.approx(plain.record.energy, rel=1e-5)  # its numbers are those of its mesh


def test_tied_steps_are_not_held_to_the_accuracy():
    tied, released = steps()
    assert (tied.record.phase, released.record.phase) == ("tied", "released")
    assert "estimated_error" not in {check.name for check in tied.measurement.certificate.checks}
    assert isfinite(tied.record.energy_error)


def test_fluids_keep_the_areas_of_their_lumens_on_the_finer_mesh():
    fluid = "lumen.kind=fluid", "lumen.fill=1.0", "accuracy=0.05"
    simulation = Simulation(ngcell.read_case("shear-empty-3x3", [*PAIR, *fluid]))
    tied, step = simulation.accepted_steps()
    assert (tied.record.phase, step.record.phase) == ("tied", "released")
    assert step.mesh.unknowns > simulation.space.unknowns
    assert failures(step) == failures(tied) == ()
    (area,) = (check for check in step.measurement.certificate.checks if check.name == "lumen_area")
    assert area.value < 1e-10
    assert all(row.pressure != 0 for row in step.cells)


def test_walls_are_balanced_with_the_last_pressures_of_fluids():
    """Where they store little, the last update alone pushed them out of balance by 1.3e-6 of the forces."""
    fluid = "lumen.kind=fluid", "lumen.fill=1.0", "accuracy=0.1", "load.displacement=[0.03, 0.0]", "load.levels=1"
    *_, step = ngcell.simulate(ngcell.read_case("shear-empty-3x3", fluid))
    (residual,) = (check for check in step.measurement.certificate.checks if check.name == "residual")
    assert failures(step) == () and residual.value < 1e-7


def test_fillings_find_back_to_their_volume_on_finer_meshes():
    """Their bulk modulus is a thousand times their shear modulus; meshes and path take 80 factorisations together."""
    filled = "lumen={kind='inclusion', material={kind='mooney-rivlin', c1=0.001, c2=0.0, bulk_modulus=1.0}}"
    *_, step = steps(filled, "accuracy=0.03")
    assert step.record.certified and step.record.energy_error < 0.03 * step.record.energy
    assert step.record.factorisations < 120


def test_the_mortar_is_refined_as_well_and_stores_what_the_penalty_does_up_to_the_errors_of_both():
    mortar, penalty = steps("contact.kind=mortar")[-1], steps()[-1]
    assert failures(mortar) == ()
    assert mortar.mesh.order > 2
    told = mortar.record.energy_error + penalty.record.energy_error
    assert mortar.record.energy == pytest.approx(penalty.record.energy, abs=told)


def test_errors_of_bonds_are_not_estimated_and_a_run_says_so(tmp_path: Path):
    bonds = "cohesion.strength=0.01", "cohesion.energy=0.0001", "strategy.kind=load-stepping"
    recording = ngcell.record(ngcell.read_case("shear-empty-3x3", [*PAIR, *bonds]), tmp_path / "out", pictures=False)
    *_, last = recording
    assert all(isnan(getattr(last, f"{name}_error")) for name in ERROR_NAMES)
    assert last.certified and "estimated_error" not in recording.summary["certificate"]
    (mesh,) = recording.summary["meshes"]
    assert (mesh["order"], mesh["grading"]) == (3, 0)
    lines = list(summary_lines(recording, tmp_path))
    assert any(line.endswith("errors not estimated: bonds remember how they were loaded") for line in lines)
    assert not any("±" in line for line in lines)
    for said in (recording.summary, read_summary(tmp_path / "out")):
        assert said["accuracy"] is None
        assert said["error_not_estimated"] == "bonds remember how they were loaded"
        assert not isfinite(said["last_step"]["energy_error"] or nan)


def test_a_run_without_accuracy_says_that_nothing_was_estimated(tmp_path: Path):
    case = ngcell.read_case("shear-empty-3x3", [*PAIR, "accuracy=inf"])
    recording = ngcell.record(case, tmp_path / "out", pictures=False)
    *_, last = recording
    assert all(isnan(getattr(last, f"{name}_error")) for name in ERROR_NAMES)
    assert any(line.endswith("errors not estimated: accuracy = inf") for line in summary_lines(recording, tmp_path))
    assert ngcell.inspect(case)["error_not_estimated"] == "accuracy = inf"


def test_without_an_estimate_the_solver_is_as_exact_as_with_one_and_the_mesh_is_that_of_the_load_path():
    """Contact is as stiff, and the end of the continuation as near, as on the same mesh with an estimate."""
    sets = ("mesh.order=3", "accuracy=0.1")
    *_, told = steps(*sets)
    *_, plain = steps(*sets, "estimate_error=false")
    assert isfinite(told.record.energy_error) and isnan(plain.record.energy_error)
    assert plain.record.certified and plain.mesh == told.mesh and len(plain.meshes) == 1
    for name in ("energy", "plate_force_x", "mean_gap"):
        assert getattr(plain.record, name) == getattr(told.record, name), name
    *_, endless = steps("mesh.order=3", "accuracy=inf")
    assert plain.record.iterations < endless.record.iterations
    found = ngcell.inspect(ngcell.read_case("shear-empty-3x3", [*SMALL, *sets, "estimate_error=false"]))
    assert found["error_not_estimated"] == "estimate_error = false" and found["accuracy"] is None


def test_a_run_with_an_estimate_has_no_such_word(tmp_path: Path):
    case = ngcell.read_case("shear-empty-3x3", [*PAIR, "accuracy=0.05"])
    recording = ngcell.record(case, tmp_path / "out", pictures=False)
    assert [record.certified for record in recording][-1]
    assert next(summary_lines(recording, tmp_path)).startswith("certified    yes: converged; ")
    assert recording.summary["accuracy"] == 0.05 and recording.summary["error_not_estimated"] == ""


def test_where_there_is_no_room_for_a_finer_mesh_nothing_is_certified():
    simulation = Simulation(ngcell.read_case("shear-empty-3x3", PAIR))

    def no_room(stage: Stage) -> Simulation:
        raise CaseError("too large")

    simulation.refinement._build = no_room
    tied, released = simulation.accepted_steps()
    assert isnan(released.record.energy_error)
    assert failures(released) == ("estimated_error",)


def test_where_nothing_is_found_beside_the_coarse_mesh_the_path_is_followed_on_the_next_one(
    monkeypatch: pytest.MonkeyPatch,
):
    usual, refused = mesh_level.settled, []

    def refusing_once(*given: Any, **named: Any) -> Minimum:
        if named["path"] is not None and not refused:
            refused.append(given)
            raise OutOfIterations
        return usual(*given, **named)

    *_, beside = steps("accuracy=0.1")
    monkeypatch.setattr(mesh_level, "settled", refusing_once)
    *_, anew = ngcell.simulate(ngcell.read_case("shear-empty-3x3", [*SMALL, "accuracy=0.1"]))
    assert refused and anew.record.certified
    assert anew.record.iterations > 1.3 * beside.record.iterations
    assert abs(anew.record.energy - beside.record.energy) <= anew.record.energy_error
    assert abs(anew.record.mean_gap - beside.record.mean_gap) <= anew.record.mean_gap_error


def test_no_matrix_of_a_finer_mesh_outlives_its_step():
    scene = Simulation(ngcell.read_case("shear-empty-3x3", [*SMALL, "accuracy=0.1"]))
    for step in scene.accepted_steps():
        used = [minimiser for level in scene.refinement._levels for minimiser in level._used]
        assert len(step.meshes) > 1 and used
        assert not any(minimiser.assembly.has_system for minimiser in used)


def test_bodies_are_refined_as_far_as_their_error_asks_for():
    """A ring in a ring that is too narrow, whose pressure is known."""
    scene = ngcell.read_case("press-fit")
    free = scene.model_copy(update={"mesh": scene.mesh.model_copy(update={"order": None})})
    *_, step = ngcell.simulate(free)
    assert failures(step) == ()
    assert step.mesh.order > 2
    assert [finding.quantity for finding in step.findings if not finding.passed] == []


def test_bodies_of_the_highest_order_have_an_error_by_one_order_more():
    *_, step = ngcell.simulate(ngcell.read_case("press-fit", ["mesh.order=6"]))
    assert failures(step) == () and 0 < step.record.energy_error < 1e-6
    assert step.record.smallest_gap < 0


def test_the_smallest_gap_of_bodies_apart_is_above_zero():
    *_, step = ngcell.simulate(ngcell.read_case("parting-rings", ["accuracy=inf", "levels=1"]))
    assert 0.6 < step.record.smallest_gap < step.record.mean_gap


def test_an_expected_number_holds_where_the_path_comes_to_its_load_factor_for_the_last_time():
    numbers = [
        {"quantity": "contact_pressure", "between": ["lower_top", "upper_bottom"], "value": 0.0} | level
        for level in ({}, {"level": 0.5}, {"level": 1.0})
    ]
    told = [{**number, "tolerance": 1.0, "origin": "nowhere"} for number in numbers]
    case = ngcell.read_case("stacked-blocks", ["accuracy=inf"])
    case = type(case).model_validate(case.model_dump() | {"levels": [0.5, 1.0, 0.5], "expected": told})
    found = [[finding.load_factor for finding in step.findings] for step in ngcell.simulate(case)]
    assert found == [[], [1.0], [0.5, 0.5]]


@pytest.mark.parametrize(("error", "passes"), [(0.0, False), (0.004, False), (0.006, True), (nan, False)])
def test_an_expected_number_is_missed_only_beyond_what_the_measured_one_may_err_by(error: float, passes: bool):
    *_, step = steps("accuracy=inf")
    record = replace(step.record, energy=1.006, energy_error=error)
    expected = Expected(level=1.0, quantity="energy", value=1.0, tolerance=1e-3, origin="nowhere")
    (found,) = compare([expected], record, cast(View, None), [1.0])
    assert found.passed is passes


def test_a_place_has_fewer_digits_on_a_new_mesh(monkeypatch: pytest.MonkeyPatch):
    """Round-off of the mesh before chooses nothing there."""
    shares = list[float]()

    def noting(minimisers: Any, start: Any, **given: Any) -> Minimum:
        minimiser = minimisers[0]
        digits = start[minimiser.problem.free] / (minimiser.options.last_digit * minimiser.longest_step)
        if given["path"] is not None:
            digits = digits / mesh_level._DIGITS
            shares.append(float(np.abs(digits - np.round(digits)).max()))
        return settled(minimisers, start, **given)

    monkeypatch.setattr(mesh_level, "settled", noting)
    ngcell.simulate(ngcell.read_case("shear-empty-3x3", [*SMALL, "accuracy=0.1"]))
    assert len(shares) > 1 and max(shares) < 1e-6
