"""The study of error against run time: what is compared, what it says, and that it goes on where it stopped."""

from __future__ import annotations

import csv
import json

import pytest
from click.testing import CliRunner

from tools.studies.work_precision import rings, study
from tools.studies.work_precision.calculix import deck_of
from tools.studies.work_precision.grid import Setting, grid
from tools.studies.work_precision.naive import naive
from tools.studies.work_precision.report import (
    against_own_finest,
    choices,
    rates,
    sentences,
    strategy_table,
    upper_end,
)
from tools.studies.work_precision.solve import solved

COARSE = Setting("rings", "press-fit", "mortar", 2, 0.25)


@pytest.fixture(scope="module")
def found():
    return solved(COARSE)


def test_a_run_is_held_to_the_radial_solution(found):
    assert found["error_gap"] < 5e-3 and found["error_pressure"] < 5e-3 and found["error_force"] < 5e-3
    assert found["certified"] and found["factorisations"] > 0
    assert set(json.loads(found["phases"])) >= {"meshing", "assembly", "factorisation"}


def test_the_naive_script_solves_the_same_problem(found):
    other = naive(Setting("naive", "press-fit", "naive", 2, 0.25))
    assert other["unknowns"] == found["unknowns"]
    assert other["error_gap"] == pytest.approx(found["error_gap"], rel=0.3)


def test_exact_values_are_those_of_the_references():
    assert rings.exact("press-fit")["interface"] == pytest.approx(0.984409, abs=1e-6)
    assert rings.exact("above")["pressure"] == pytest.approx(0.094045, abs=1e-6)
    assert rings.exact("touch")["inner_pressure"] == pytest.approx(0.350737, abs=1e-6)


def test_settings_have_keys_of_their_own_and_the_quick_ones_are_among_all():
    every, quick = ([setting.label for setting in grid(form)] for form in (False, True))
    assert len(set(every)) == len(every)
    assert len(quick) < len(every) / 3


def test_a_study_goes_on_where_it_stopped_and_tells_versions_apart(tmp_path, monkeypatch):
    asked = []

    def row(setting, timeout):
        asked.append(setting.label)
        return {**setting.row(), "code": study.sources(), "commit": "abc", "outcome": "timeout"}

    monkeypatch.setattr(study, "row", row)
    monkeypatch.setattr(study, "RESULTS", tmp_path)
    arguments = ["--quick", "--only", "rings, press-fit, mortar"]
    assert CliRunner().invoke(study.command, arguments).exit_code == 0
    assert len(asked) == 6
    assert CliRunner().invoke(study.command, arguments).exit_code == 0
    assert len(asked) == 6
    monkeypatch.setattr(study, "sources", lambda: "another")
    assert CliRunner().invoke(study.command, arguments).exit_code == 0
    assert len(asked) == 12
    assert len(list(csv.DictReader((tmp_path / "study.csv").open()))) == 12


def line(size: float, seconds: float, error: float, method: str = "mortar", problem: str = "above") -> dict:
    names = {"kind": "rings", "problem": problem, "method": method, "order": "2", "size": str(size)}
    return {**names, "seconds": str(seconds), "gap": error, "pressure": error / 2}


def test_rates_the_front_and_sentences_follow_from_errors_and_seconds():
    rows = [line(0.2, 1.0, 4e-2), line(0.1, 3.0, 1e-2), line(0.1, 9.0, 2e-2, "penalty")]
    assert [entry["rate"] for entry in rates(rows)] == ["2.0", "2.0", "", ""]
    assert [entry["seconds"] for entry in upper_end(choices(rows))] == [1.0, 3.0]
    said = sentences(rows, [])
    assert "below 10.0% take 1 s, with mortar, order 2, h = 0.2" in said
    assert "below 1.0% take 3 s" in said
    assert "no setting of this study has all errors below 0.1%" in said


def test_tissues_are_compared_with_the_finest_of_the_mortar_and_both_methods_with_each_other():
    ones = dict.fromkeys(("gap", "pressure", "force", "parted"), "1")
    rows = [
        {**line(size, 1.0, 0.0, method, "3x3"), **ones, "energy": energy}
        for size, method, energy in ((0.5, "mortar", "1.1"), (0.25, "mortar", "1.0"), (0.25, "penalty", "1.02"))
    ]
    compared, references = against_own_finest(rows)
    assert [round(row["energy"], 6) for row in compared] == [0.1, 0.02]
    assert [entry["energy"] for entry in references] == ["2.0e-02"]


def test_strategies_are_compared_scene_by_scene_failures_included():
    base = {"iterations": "9", "factorisations": "20", "energy": "1.0", "problem": "3x3 empty, shear 1"}
    rows = [
        {**base, "strategy": "sddp", "outcome": "converged", "seconds": "2"},
        {**base, "strategy": "single-step", "outcome": "converged", "seconds": "5"},
        {**base, "problem": "3x3 full, shear 1", "strategy": "sddp", "outcome": "converged", "seconds": "2"},
        {**base, "problem": "3x3 full, shear 1", "strategy": "single-step", "outcome": "timeout", "seconds": ""},
    ]
    both, failed = strategy_table(rows)
    assert both["seconds, single-step / sddp"] == "2.50"
    assert failed["single-step: outcome"] == "timeout" and "energy apart" not in failed


def test_the_deck_has_every_element_once_and_holds_the_planes_of_symmetry():
    deck, places = deck_of(Setting("calculix", "above", "calculix", 1, 0.25))
    elements = deck.partition("*ELEMENT")[2].partition("*NSET")[0].splitlines()[1:]
    assert len(elements) == len({entry.partition(",")[0] for entry in elements})
    assert "INNER-X-ALL, 2, 2" in deck and "OUTER-Y-ALL, 1, 1" in deck
    assert max(x * x + y * y for x, y in places.values()) == pytest.approx(1.6**2)
