"""The studies of what tissues take: names, settings, errors in percent, sums, and one run."""

from __future__ import annotations

import ngcell
from tools.runs import sources
from tools.studies import averaged, growing
from tools.tail import tail_of


def test_tissues_are_sheared_by_a_share_of_their_height_and_small_ones_come_first():
    scenes = growing.scenes()
    assert len(scenes) == len(growing.SIZES) * len(growing.SHARES) * len(growing.CASES)
    assert next(iter(scenes)).startswith("5x7")
    case, sets = scenes["10x10, pressure, 0.1"]
    assert ngcell.read_case(case, sets).load.displacement == (1.55, 0.0)


def test_all_scenes_of_both_studies_are_cases():
    for case, sets in (*growing.scenes().values(), *averaged.SCENES.values()):
        ngcell.read_case(case, sets)
    assert len(averaged.SCENES) == 14


def test_a_run_has_a_row_with_errors_in_percent_and_the_report_shows_it():
    sets = ("tissue.rows=1", "tissue.cols=2", "load.displacement=[0.1, 0.0]", "load.levels=1")
    row = growing.measured("shear-empty-3x3", sets, 0.1, 5)
    assert row["outcome"] == "converged and certified"
    assert row["code"] == sources() and set(row) | {"tissue"} == set(growing.COLUMNS)
    assert 0 < float(row["energy_error"]) < 10
    assert int(row["factorisations"]) >= int(row["iterations"]) > 0
    assert f"{row['energy']} ± {row['energy_error']} %" in growing.report([{"tissue": "2x2"} | row])


def test_a_step_without_force_has_no_share_of_it():
    forces, gaps = (f"plate_force_{axis}" for axis in "xyz"), ("mean_gap", "mean_gap_error", "mean_gap_slid")
    step = dict.fromkeys((*forces, *gaps), "0")
    row = growing.numbers_of(step | {"energy": "2", "energy_error": "0.1", "plate_force_error": "1e-9"})
    assert (row["energy_error"], row["plate_force_error"]) == ("5", "")


def test_sums_count_what_is_certified_and_take_runs_without_numbers():
    rows = [dict.fromkeys(averaged._SUMS, 2) | {"outcome": "converged and certified"}]
    rows.append(dict.fromkeys(averaged._SUMS, "") | {"outcome": "stopped"})
    total = averaged.total(rows)
    assert total["outcome"] == "1 of 2 certified"
    assert total["factorisations"] == 2


def test_the_tail_begins_where_the_energy_of_a_mesh_has_settled():
    line = "proximal weight 1e-03: converged, {} factorisations, 0 refused, energy {:.8e}, decrement 0e+00\n"
    end = "ngcell.build.refinement: mesh 1: energy 1.000000e+00, estimated error 1e-02\n"
    first = [(10, 2.0), (5, 1.0002), (6, 1.1), (20, 1.0001), (4, 1.0)]
    second = [(1, 0.9), (3, 0.9)]
    log = end.join("".join(line.format(*told) for told in mesh) for mesh in (first, second))
    assert tail_of(log) == f"{(4 + 3) / 49:.2f}"
    assert tail_of("nothing") == ""
