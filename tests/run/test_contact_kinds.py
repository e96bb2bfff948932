"""The study of kinds of contact: what is left to run, and errors against the mortar method's last setting."""

from __future__ import annotations

import pytest

from tools.runs import sources
from tools.studies import contact_kinds as study

SCENE, (*SETTINGS, FINEST) = "press-fit", study.SCENES["press-fit"][2]


def row(setting: str, kind: str, energy: float, **more: object) -> study.Row:
    blank = dict.fromkeys(study.COLUMNS, "")
    return blank | {
        "scene": SCENE, "setting": setting, "contact": kind, "energy": str(energy), "energy_error": "0.1",
        "mean_gap": "1e-12", "mean_gap_error": "1e-12", "seconds": 1.0, "code": sources(), **more,
    }  # fmt: skip


def test_errors_are_those_against_the_last_setting_by_the_mortar_method():
    rows = [row(SETTINGS[0], "penalty", 2.2), row(FINEST, "mortar", 2.0), row(FINEST, "penalty", 1.0)]
    assert study.found(rows, rows[0], "energy") == pytest.approx(0.1)
    assert study.told(rows[0], "energy") == pytest.approx(0.1 / 2.2)
    assert study.found(rows[:1], rows[0], "energy") is None  # there is no reference yet
    assert study.found(rows, rows[0], "mean_gap") is None and study.told(rows[0], "plate_force_x") is None
    assert "4.5 / 10 |" in study.report(rows)


def test_runs_of_the_present_sources_are_not_repeated_and_the_reference_is_by_the_mortar_method_alone():
    known = [row(SETTINGS[0], "penalty", 1.0), row(SETTINGS[0], "mortar", 1.0, code="older")]
    left = study.missing(known, [SCENE])
    assert (SCENE, SETTINGS[0], "penalty") not in left and (SCENE, SETTINGS[0], "mortar") in left
    assert [run for run in left if run[1] == FINEST] == [(SCENE, FINEST, "mortar")]
    assert len(left) == 3 * len(SETTINGS)


def test_of_two_runs_the_cheaper_one_counts():
    cheap, dear = row(FINEST, "mortar", 1.0), row(FINEST, "mortar", 1.0, seconds=2.0)
    assert study.cheaper(cheap, dear) is study.cheaper(dear, cheap) is cheap
