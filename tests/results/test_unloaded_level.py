"""Where curves and the account of work start: at rest if that is an equilibrium, else at the first level."""

from __future__ import annotations

import csv
from math import isfinite

import pytest

import ngcell
from ngcell.build.simulation import Simulation
from ngcell.results.growth import growth_onset
from ngcell.scene.levels import level_factors

SMALL = ["tissue.rows=2", "tissue.cols=2", "mesh.order=2", "load.displacement=[0.4, 0.0]"]
FIRST = [*SMALL, "lumen.kind=pressure", "lumen.pressure=0.02", "lumen.ramp=first"]


def recorded(tmp_path, overrides):
    case = ngcell.read_case("shear-empty-3x3", [*overrides, "accuracy=inf"])
    recording = ngcell.record(case, tmp_path / "out", pictures=False)
    return [row for row in recording if row.phase == "released"], recording.summary


def test_gaps_that_a_pressure_opens_before_the_load_are_not_drawn_from_a_closed_origin():
    assert growth_onset([0.5, 1.0], [0.006, 0.01], 0.1) == pytest.approx(0.5 * 5 / 6)
    assert growth_onset([0.5, 1.0], [0.006, 0.01], 0.1, at_rest=None) == 0.5
    assert growth_onset([0.5, 1.0], [0.004, 0.006], 0.1, at_rest=None) == pytest.approx(0.75)
    assert growth_onset([0.5], [0.006], 0.1, at_rest=0.007) == 0.0


@pytest.mark.parametrize("levels", ["1", "[0.0, 1.0]"])
def test_the_onset_is_within_the_first_interval_however_many_levels_there_are(tmp_path, levels):
    """Corners open under the pressure alone; the truth is an onset of 0."""
    released, summary = recorded(tmp_path, [*FIRST, f"load.levels={levels}"])
    first = released[0]
    assert first.mean_gap > 0.05 * 0.1
    assert summary["onset_of_growth"] == first.plate_displacement
    assert summary["onset_is_a_bound"] == (first.load_factor > 0)


def test_where_no_plate_moves_the_load_factor_tells_when_walls_open(tmp_path):
    overrides = ["tissue.rows=2", "tissue.cols=2", "mesh.order=2", 'load={kind="frame", shear=1.0, levels=2}']
    released, summary = recorded(tmp_path, overrides)
    assert all(row.plate_displacement == 0 for row in released)
    assert 0 < summary["onset_of_growth"] <= 1 and not summary["onset_is_a_bound"]
    with (tmp_path / "out" / "walls.csv").open(newline="", encoding="utf-8") as file:
        onsets = [float(row["onset"]) for row in csv.DictReader(file) if row["load_factor"] == "1.0"]
    opened = [onset for onset in onsets if isfinite(onset)]
    assert opened and all(0 < onset <= 1 for onset in opened)


def test_a_path_may_start_with_a_level_without_load(tmp_path):
    assert ngcell.read_case("shear-empty-3x3", ["load.levels=[0.0, 0.5, 1.0]", "accuracy=inf"]).level_factors == (
        0.0,
        0.5,
        1.0,
    )
    assert level_factors((0.0, 1.0)) == (0.0, 1.0)
    released, summary = recorded(tmp_path, [*SMALL, "load.levels=[0.0, 1.0]"])
    assert [row.load_factor for row in released] == [0.0, 1.0]
    assert summary["certified"] and released[0].energy == pytest.approx(0, abs=1e-15)
    assert not summary["onset_is_a_bound"]


def test_load_stepping_starts_from_the_equilibrium_under_what_acts_in_full(tmp_path):
    bonds = ["cohesion.strength=0.1", "cohesion.energy=0.001", "strategy.kind=load-stepping"]
    released, summary = recorded(tmp_path, [*FIRST, *bonds, "lumen.pressure=0.01", "load.levels=[0.0, 0.1]"])
    assert summary["certified"] and released[0].load_factor == 0.0 and released[0].energy > 0


def test_a_press_fit_starts_from_no_equilibrium_and_its_pair_is_found():
    simulation = Simulation(ngcell.read_case("press-fit-tight", ["accuracy=inf"]))
    assert not simulation.starts_at_rest and simulation.mean_gap_at_rest is None
    (step,) = simulation.accepted_steps()
    assert step.measurement.unstored_work == 0.0
    (row,) = step.walls
    found = {finding.quantity: finding.measured for finding in step.findings}
    assert row.contact_pressure == pytest.approx(found["contact_pressure"], rel=1e-6)
    assert abs(row.mean_gap) < 1e-5 and not row.parted


@pytest.mark.parametrize(("case", "gap", "overlap"), [("press-fit", 0.0, 0.1), ("closing-rings", 0.1, 0.0)])
def test_walls_that_overlap_or_are_apart_at_rest_face_each_other(case, gap, overlap):
    found = ngcell.inspect(ngcell.read_case(case, ["accuracy=inf"]))
    assert found["facing_pairs"] == 1
    assert found["largest_initial_overlap"] == pytest.approx(overlap, abs=1e-4)
    assert found["largest_initial_gap"] == pytest.approx(gap, abs=1e-4)
