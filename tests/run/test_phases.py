"""The figure of a run's phases."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from tools.studies import phases

SECONDS = {"on_the_clock": 70.0, "processor": 100.0, "processor_by_phase": {"a": 10.0, "b": 80.0, "c": 0.4}}


def test_bars_are_all_seconds_and_the_short_ones_are_one(tmp_path):
    assert phases.bars(SECONDS) == [("b", 80.0), ("a", 10.0), ("all others", pytest.approx(10.0))]
    about = {"title": "t", "unknowns": 5, "iterations": 2, "factorisations": 3, "outcome": "certified"}
    phases.draw(about | {"seconds": SECONDS}, tmp_path / "phases.png")
    assert (tmp_path / "phases.png").stat().st_size > 1000


def test_a_folder_without_a_run_is_one_line(tmp_path):
    answer = CliRunner().invoke(phases.command, [str(tmp_path)])
    assert answer.exit_code == 1
    assert answer.output.startswith("Error: ") and answer.output.count("\n") == 1
    assert "it holds no run that has ended" in answer.output
