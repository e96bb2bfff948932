"""Scenes from Python are recorded like cases, and resumed when they are handed over again."""

from __future__ import annotations

import tomllib
from math import inf
from pathlib import Path

import pytest
from netgen import occ

import ngcell
from ngcell.cli import ngcell as command
from ngcell.errors import OutputError
from ngcell.export import folder as folder_module
from ngcell.export import read_summary
from ngcell.scene.written_bodies import written_bodies
from tests.run.test_resume import assert_same_numbers, rows

RUBBER = ngcell.MooneyRivlin(c1=0.8, c2=0.2, bulk_modulus=50.0)


def scene(width: float = 0.6) -> ngcell.BodyScene:
    """Return a block that is pressed onto a wider one, in two levels."""
    table = occ.Rectangle(1, 0.5).Face()
    block = occ.MoveTo(0.2, 0.5).Rectangle(width, 0.5).Face()
    table.edges.Min(occ.Y).name, block.edges.Max(occ.Y).name = "floor", "top"
    return ngcell.BodyScene(
        (ngcell.Body(table, RUBBER, "table"), ngcell.Body(block, RUBBER, "block")),
        (ngcell.BodySupport("floor"), ngcell.BodySupport("top", translation=(0.0, -0.05))),
        size=0.25,
        levels=2,
        title="A block on a block",
        accuracy=inf,
    )


def test_a_scene_from_python_is_recorded_and_its_text_says_what_it_cannot_hold(tmp_path):
    recording = ngcell.record(scene(), tmp_path / "out")
    assert [step.certified for step in recording] == [True, True] and recording.certified
    text = (tmp_path / "out" / "case.toml").read_text()
    told = tomllib.loads(text)
    assert told["title"] == "A block on a block" and "cannot be read back" in text.splitlines()[0]
    assert told["bodies"][1]["shape"]["not_written"] == "Face"
    assert told["bodies"][1]["shape"]["measure"] == pytest.approx(0.3)
    assert told["bodies"][1]["material"]["c1"] == 0.8 and "top" in told["bodies"][1]["shape"]["sides"]
    walls = rows(tmp_path / "out" / "walls.csv")
    assert float(walls[-1]["contact_pressure"]) == pytest.approx(float(walls[-1]["normal_force"]) / 0.6, rel=0.1)


def test_it_is_resumed_with_the_scene_and_refused_without_it_or_with_another(tmp_path):
    for _ in ngcell.record(scene(), tmp_path / "whole"):
        pass
    stopped = iter(ngcell.record(scene(), tmp_path / "out"))
    next(stopped)
    stopped.close()
    with pytest.raises(OutputError, match=r"made from Python; hand it over again: ngcell.resume\(.*, scene="):
        ngcell.resume(tmp_path / "out")
    with pytest.raises(OutputError, match="made from another scene"):
        ngcell.resume(tmp_path / "out", scene=scene(width=0.5))
    assert ngcell.resume(tmp_path / "out", scene=scene()) is not None
    rest = list(ngcell.resume(tmp_path / "out", scene=scene()))
    assert [step.load_factor for step in rest] == [1.0]
    assert_same_numbers(rows(tmp_path / "out" / "history.csv"), rows(tmp_path / "whole" / "history.csv"))


def test_the_command_line_says_in_one_line_that_the_scene_is_needed(tmp_path: Path):
    from click.testing import CliRunner

    stopped = iter(ngcell.record(scene(), tmp_path / "out"))
    next(stopped)
    stopped.close()
    found = CliRunner().invoke(command, ["solve", "--resume", str(tmp_path / "out")])
    assert found.exit_code and isinstance(found.exception, (OutputError, SystemExit))


def test_solids_are_recorded_without_a_picture_from_above(tmp_path):
    table, block = occ.Box((0, 0, 0), (1, 1, 0.5)), occ.Box((0.2, 0.2, 0.5), (0.7, 0.8, 1))
    table.faces.Min(occ.Z).name, block.faces.Max(occ.Z).name = "floor", "top"
    bodies = ngcell.Body(table, RUBBER, "table"), ngcell.Body(block, RUBBER, "block")
    supports = ngcell.BodySupport("floor"), ngcell.BodySupport("top", translation=(0.0, 0.0, -0.01))
    contact = ngcell.Penalty(stiffness=10.0)
    solids = ngcell.BodyScene(bodies, supports, size=0.6, order=1, accuracy=inf, contact=contact)
    recording = ngcell.record(solids, tmp_path / "out")
    assert all(step.phase == "released" for step in recording)
    summary = read_summary(tmp_path / "out")
    assert summary["status"] == "finished" and summary["certified"] == recording.certified
    assert (tmp_path / "out" / "gap.png").is_file() and not (tmp_path / "out" / "tissue.png").exists()


def test_a_scene_that_has_been_meshed_is_the_same_scene(tmp_path):
    same = scene()
    stopped = iter(ngcell.record(same, tmp_path / "out"))
    next(stopped)
    stopped.close()
    rest = list(ngcell.resume(tmp_path / "out", scene=same))
    assert [step.load_factor for step in rest] == [1.0]
    assert list(ngcell.record(scene(), tmp_path / "again")) and written_bodies(same) == written_bodies(scene())


def test_a_picture_that_fails_leaves_the_verdict(tmp_path, monkeypatch):
    def fails(*_: object, **__: object) -> None:
        raise ValueError("no colours")

    monkeypatch.setattr(folder_module, "draw_tissue", fails)
    recording = ngcell.record(scene(), tmp_path / "out")
    with pytest.raises(ValueError, match="no colours"):
        list(recording)
    summary = read_summary(tmp_path / "out")
    assert recording.certified and summary["status"] == "finished" and summary["certified"]
