"""What a stiffer penalty moves, as a run reports it."""

from __future__ import annotations

from math import inf
from pathlib import Path

import pytest

from ngcell import BodyCase, Case, record
from ngcell.cli.summary import summary_lines
from ngcell.errors import CaseError


def sheared_pair(contact: str) -> Case:
    return Case.model_validate(
        {
            "tissue": {"rows": 2, "cols": 2, "wall": 0.1},
            "material": {"kind": "mooney-rivlin", "c1": 1.0, "c2": 1.0, "bulk_modulus": 100.0},
            "load": {"kind": "plates", "displacement": [0.4, -0.02], "levels": 2},
            "strategy": {"kind": "single-step"},
            "contact": {"kind": contact},
            "mesh": {"order": 2},
            "accuracy": inf,
        }
    )


def test_a_stiffer_penalty_moves_the_result_a_little_and_halves_the_overlap_at_least(tmp_path: Path) -> None:
    recording = record(sheared_pair("penalty"), tmp_path / "out", verify_penalty=True)
    steps = list(recording)
    table = recording.summary["stiffer_penalty"]
    assert table["stiffness_factor"] == 10
    assert table["energy"]["meant"] == steps[-1].energy
    assert 0 < table["energy"]["change"] < 0.02
    assert table["penetration_over_wall"]["change"] < -0.4
    shown = "\n".join(summary_lines(recording, tmp_path))
    assert "penalty terms 10 times as stiff" in shown and "penetration over wall" in shown


def test_without_being_asked_a_run_solves_each_level_once(tmp_path: Path) -> None:
    recording = record(sheared_pair("penalty"), tmp_path / "out")
    assert len(list(recording)) == 2
    assert "stiffer_penalty" not in recording.summary


def test_the_mortar_method_has_no_penalty_to_verify(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="no penalty to verify"):
        record(sheared_pair("mortar"), tmp_path / "out", verify_penalty=True)


def test_where_penalty_terms_were_raised_the_stiffer_ones_are_stiffer_than_these(tmp_path: Path) -> None:
    """Blocks between walls that hold them: penalty terms yield as well, and the force is low by their share."""
    held = [{"boundary": f"{body}_{side}", "components": "x"} for body in ("base", "top") for side in ("left", "right")]
    material = {"kind": "mooney-rivlin", "c1": 0.5, "c2": 0.5, "bulk_modulus": 20.0}
    blocks = [
        {"name": name, "kind": "block", "low": [0.0, low], "high": [1.0, low + 1], "size": 0.5, "material": material}
        for name, low in (("base", 0.0), ("top", 1.0))
    ]
    ends = [{"boundary": "base_bottom"}, {"boundary": "top_top", "translation": [0.0, -0.05]}]
    case = {"levels": 1, "bodies": blocks, "supports": [*held, *ends], "mesh": {"order": 2}, "accuracy": inf}

    def run(kind: str):
        scene = BodyCase.model_validate({**case, "contact": {"kind": kind}})
        recording = record(scene, tmp_path / kind, verify_penalty=kind == "penalty")
        (step,) = recording
        return step, recording.summary

    (exact, _), (soft, summary) = run("mortar"), run("penalty")
    error = soft.contact_force / exact.contact_force - 1
    assert -0.01 < error < -0.001
    assert summary["stiffer_penalty"]["contact_force"]["change"] == pytest.approx(-0.9 * error, rel=0.03)
