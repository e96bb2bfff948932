"""What a result says first: certified or not, why not, what to try, and what came apart."""

from __future__ import annotations

from math import nan
from typing import Any

import pytest

from ngcell.results.certificate import LIMITS
from ngcell.results.verdict import (
    ADVICE,
    came_apart,
    checks_not_passed,
    error_remark,
    headline,
    last_load,
    last_numbers,
    slid_remark,
    with_error,
)

LAST = {
    "plate_displacement": 1.0, "energy": 2.0, "energy_error": 0.1, "plate_force_x": 3.0, "plate_force_y": -4.0,
    "plate_force_z": 0.0, "plate_force_error": None, "mean_gap": 0.1, "mean_gap_error": nan,
}  # fmt: skip


def run(**changes: Any) -> dict[str, Any]:
    return {"certified": True, "outcome": "converged and certified", "accepted_steps": 3, "last_step": LAST} | changes


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"certificate": {"residual": {"passed": True}}}, "certified: converged; 1 check passed at each of 3 accepted"),
        ({"certified": False, "failed_steps": {"2": ["residual"]}}, "not certified: converged, but 1 of 3 accepted"),
        ({"certified": False, "outcome": "no equilibrium; refine"}, "not certified: no equilibrium; refine"),
        ({"certified": False, "status": "stopped", "reason": "Ctrl-C"}, "not certified: the run was stopped (Ctrl-C)"),
        ({"certified": None, "status": "running"}, "not certified: the run has not ended, or was killed, after 3"),
    ],
)
def test_the_first_line_says_whether_a_result_is_certified(changes: dict[str, Any], words: str) -> None:
    assert headline(run(**changes)).startswith(words)


def test_a_run_that_was_stopped_is_not_certified_whatever_its_summary_says() -> None:
    assert headline(run(status="stopped")).startswith("not certified")


def test_each_check_that_failed_comes_with_advice() -> None:
    table = {"residual": {"worst": 0.1, "limit": 1e-6, "passed": False}, "tension": {"worst": 0.0, "passed": True}}
    (failed,) = checks_not_passed(run(certificate=table))
    assert (failed.name, failed.worst, failed.limit) == ("residual", 0.1, 1e-6)
    assert "mesh.size" in failed.advice
    assert set(LIMITS) <= set(ADVICE)


def test_walls_that_are_still_tied_have_no_gaps_and_are_told_to_be_tied() -> None:
    stopped = run(last_step=LAST | {"phase": "tied", "load_factor": 0.5, "mean_gap": 1e-16, "contact_force": 0.0})
    assert list(last_numbers(stopped)) == ["energy", "plate_force"]
    assert last_load(stopped) == "plate displacement 1, load factor 0.5, walls still tied"
    released = run(last_step=LAST | {"phase": "released", "load_factor": 0.5})
    assert "mean_gap" in last_numbers(released) and last_load(released) == "plate displacement 1, load factor 0.5"
    assert last_load({}) == ""


def test_of_a_tissue_that_nothing_strains_no_round_off_is_told() -> None:
    apart = run(nothing_strained=True)
    assert list(last_numbers(apart)) == ["mean_gap"]
    assert last_numbers(apart | {"last_step": LAST | {"mean_gap": 1e-16}}) == {}
    assert "no wall is strained" in error_remark(apart)


def test_numbers_have_errors_where_they_are_known() -> None:
    numbers = last_numbers(run())
    assert numbers["energy"] == (2.0, 0.1)
    assert numbers["plate_force"] == (5.0, None)
    assert numbers["mean_gap"] == (0.1, None)
    assert "largest_gap" not in numbers
    assert error_remark(run()) == ""
    assert error_remark(run(error_not_estimated="accuracy = inf")) == "errors not estimated: accuracy = inf"
    assert "could not" in error_remark(run(last_step=LAST | {"energy_error": None}))


def test_how_far_walls_slid_is_told_where_the_mean_gap_changed_by_more_than_it_errs() -> None:
    slid = LAST | {"mean_gap_error": 0.001, "mean_gap_slid": 0.005}
    assert slid_remark(run(last_step=slid)).startswith("the mean gap changed by 5 % as walls slid to rest")
    assert slid_remark(run(last_step=slid | {"mean_gap_error": 0.01})) == ""
    assert slid_remark(run(last_step=slid, nothing_strained=True)) == slid_remark(run()) == slid_remark({}) == ""


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [(2.0, 0.1, "2 ± 5 %"), (1.0, 0.35, "1 ± 35 %"), (0.1, 0.5, "0.1 ± 0.5"), (1.0, nan, "1"), (1.0, None, "1")],
)
def test_errors_are_relative_where_that_says_something(value: float, error: float | None, words: str) -> None:
    assert with_error(value, error) == words


def test_what_came_apart_is_one_sentence() -> None:
    apart = {"wall_pairs_opened": 7, "wall_pairs_parted": 4, "component_sizes": [8, 1]}
    table = run(debonding=apart, facing_pairs=16, bodies=9, held_by_nothing=[5], onset_of_growth=0.1234)
    assert came_apart(table) == (
        "7 of 16 wall pairs opened and 4 parted; 9 cells in 2 connected components; 1 cell held by nothing; "
        "gaps grow from plate displacement 0.123"
    )
    assert "no later than" in came_apart(table | {"onset_is_a_bound": True})
    frame = LAST | {"plate_displacement": 0.0, "load_factor": 1.0}
    assert came_apart(table | {"last_step": frame}).endswith("from load factor 0.123")
    assert "grow" not in came_apart(table | {"last_step": frame | {"load_factor": 0.0}})
    assert "grow" not in came_apart(table | {"onset_of_growth": None})
    assert came_apart(run()) == ""
