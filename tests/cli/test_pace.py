"""How far a run is, and how long the rest may take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from ngcell.cli.pace import Pace, duration
from tests.cli.conftest import accepted_step


def after(times: Sequence[float], levels: int, members: int = 1) -> Pace:
    """Return the pace after levels that took these times, a tenth of each while the walls were tied."""
    pace = Pace([(n + 1) / levels for n in range(levels)], members)
    for number, time in enumerate(times):
        member, level = divmod(number, levels)
        step = accepted_step(0, (level + 1) / levels)
        pace.accept(replace(step, phase="tied", seconds=0.1 * time), member)
        pace.accept(replace(step, seconds=0.9 * time), member)
    return pace


def test_nothing_is_foreseen_before_a_level_has_ended() -> None:
    pace = after([], 4)
    pace.accept(replace(accepted_step(0, 0.25), phase="tied"))
    assert pace.seconds_left is None and str(pace) == "0 of 4 levels"


def test_after_one_level_the_others_are_said_to_be_assumed_alike() -> None:
    assert str(after([20.0], 4)) == "1 of 4 levels, about 60 s left if the others take as long"


def test_a_trend_is_continued() -> None:
    assert after([10.0, 12.0, 14.0], 5).seconds_left == pytest.approx(16 + 18)
    assert after([10.0, 8.0], 4).seconds_left == pytest.approx(8 + 8), "not below the quickest so far"


def test_an_estimate_of_a_run_that_was_timed_is_not_far_off() -> None:
    """The 5x7 tissue under shear: harder from level to level, and hardest at the last."""
    times = [19.7, 20.4, 24.1, 26.4, 32.1, 31.9, 39.4, 50.2]
    for done in range(3, len(times)):
        left = after(times[:done], len(times)).seconds_left
        assert left == pytest.approx(sum(times[done:]), rel=0.3)


def test_steps_between_levels_count_for_the_level_that_follows() -> None:
    pace = Pace([0.5, 1.0])
    for factor in (0.25, 0.5):
        pace.accept(replace(accepted_step(0, factor), seconds=3.0))
    assert str(pace) == "1 of 2 levels, about 6 s left if the others take as long"


def test_what_a_level_has_taken_so_far_is_no_longer_left() -> None:
    pace = after([20.0], 4)
    pace.accept(replace(accepted_step(0, 0.5), phase="tied", seconds=5.0))
    assert pace.seconds_left == pytest.approx(55.0) and not pace.has_ended
    assert after([1.0], 1).has_ended


def test_load_factors_may_come_back() -> None:
    pace = Pace([1.0, 0.5, 0.0])
    for factor in (1.0, 0.5, 0.0):
        pace.accept(accepted_step(0, factor))
    assert str(pace) == "3 of 3 levels"


def test_members_are_expected_to_take_their_mean() -> None:
    assert after([10.0, 20.0, 30.0], 2, members=3).seconds_left == pytest.approx(3 * 20.0)


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.4, "0 s"), (89, "89 s"), (150, "2.5 min"), (5400, "1.5 h"), (200000, "2.3 days")]
)
def test_times_are_told_in_two_digits(seconds: float, words: str) -> None:
    assert duration(seconds) == words
