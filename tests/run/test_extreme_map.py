"""The map of extreme scenes: which outcome a run counts as, what must agree, and that it goes on where it stopped."""

from __future__ import annotations

import math
from functools import partial

import pytest

from tools.extreme import outcomes
from tools.extreme.point import Point
from tools.extreme.points import STIFF, points
from tools.extreme.report import report
from tools.extreme.scenes import tissue

HISTORY = [dict.fromkeys(outcomes.COMPARED, "1.0")]


def row(**more) -> outcomes.Row:
    values = {"label": "units: mm", "group": "units", "setting": "mm", "has_solution": True, "perturbed": ""}
    return outcomes.Row(**values | {"outcome": outcomes.WRONG} | more)


def summary(**more) -> dict:
    base = {"certificate": {}, "iterations": 3, "refused": 1, "cut_backs": 0, "seconds": {"processor": 1.0}}
    checks = {"smallest_jacobian": {"worst": 0.9}, "penetration_over_wall": {"worst": 1e-3}}
    ended = {"outcome": "certified", "failed_steps": {}, "accepted_steps": 1, "expected": []}
    return base | {"certificate": checks} | ended | more


MISSED = {"quantity": "contact_force", "deviation": 0.5, "passed": False}


@pytest.mark.parametrize(
    ("found", "history", "code", "outcome", "cause"),
    [
        (summary(), HISTORY, 0, outcomes.CERTIFIED, ""),
        (summary(), [HISTORY[0] | {"energy": "nan"}], 0, outcomes.WRONG, "not a number"),
        (summary(accepted_steps=2), HISTORY, 0, outcomes.WRONG, "accepted steps are not on disk"),
        (summary(failed_steps={"0": ["residual"]}), HISTORY, 4, outcomes.NAMED, "residual"),
        (summary(outcome="no equilibrium; try"), HISTORY, 4, outcomes.NAMED, "no equilibrium"),
        (summary(outcome="not as the case expects", expected=[MISSED]), HISTORY, 4, outcomes.WRONG, "contact_force"),
    ],
)
def test_a_run_counts_as_certified_named_or_wrong(found, history, code, outcome, cause):
    mine = row()
    outcomes.fill(mine, found, history, code)
    assert mine.outcome == outcome and cause in mine.cause
    assert mine.smallest_jacobian == 0.9 and mine.iterations == 3


def test_points_that_must_agree_are_compared_without_units():
    other = Point("units", "m", partial(tissue), units=(1.0, 1.0))
    mine = Point("units", "mm", partial(tissue), same_as="m", units=(1e3, 1e-6))
    values = {name: 2.0 for name in outcomes.COMPARED}
    scaled = {name: 2.0 * 1e3**length * 1e-6**stress for name, (length, stress) in outcomes.COMPARED.items()}
    rows = {other.label: row(label=other.label, outcome=outcomes.CERTIFIED, **values)}
    rows[mine.label] = row(outcome=outcomes.CERTIFIED, **scaled)
    outcomes.compare(mine, rows)
    assert rows[mine.label].outcome == outcomes.CERTIFIED and rows[mine.label].error < 1e-15
    rows[mine.label].energy *= 1 + 1e-6
    outcomes.compare(mine, rows)
    assert rows[mine.label].outcome == outcomes.WRONG


def test_rows_come_back_as_they_were_written_and_only_to_their_sources(tmp_path):
    file = tmp_path / "extreme.csv"
    outcomes.write(file, [row(code="a", energy=0.1 + 0.2, has_solution=False)])
    (back,) = outcomes.known(file, "a").values()
    assert back.energy == 0.1 + 0.2 and back.has_solution is False and math.isnan(back.error)
    assert outcomes.known(file, "b") == {}


def test_each_stiff_point_is_perturbed_and_the_map_says_what_came_of_it(tmp_path):
    every = points()
    assert {point.perturbed_from for point in every} == {"", *STIFF}
    base = row(label=STIFF[0], outcome=outcomes.CERTIFIED, **dict.fromkeys(outcomes.COMPARED, 1.0))
    finer = row(label=f"{STIFF[0]}; mesh", perturbed=STIFF[0], outcome=outcomes.CERTIFIED)
    for name in outcomes.COMPARED:
        setattr(finer, name, 1.02)
    named = row(label="mesh: x", outcome=outcomes.NAMED, cause="residual")
    report([base, finer, named], 9, tmp_path / "map.md", tmp_path / "map.png")
    text = (tmp_path / "map.md").read_text()
    assert "1 of 2 points that have a solution are certified, 50.0%" in text and "2 of 9 points were run" in text
    assert f"| {STIFF[0]} | 0.02 |" in text and "| mesh: x | named: residual |" in text
    assert (tmp_path / "map.png").stat().st_size > 1000
