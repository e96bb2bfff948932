"""The same scene gives the same bits with any number of threads."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ngcell import threads as module
from ngcell.build.checkpoint import Checkpoint
from ngcell.build.simulation import Simulation
from ngcell.scene import read_case
from ngcell.threads import at_once, each_on_threads, parts_of, threads

_CASES = Path(__file__).parents[2] / "cases"


def _first_state(count: int) -> np.ndarray:
    """Displacement of the first step of a tissue whose cells choose sides by last digits."""
    with threads(count):
        simulation = Simulation(read_case(_CASES / "shear-empty-3x3.toml", ["accuracy=inf"]))
        return next(simulation.follow(Checkpoint())).minimum.state.displacement


def test_threads_change_no_bit() -> None:
    assert np.array_equal(_first_state(1), _first_state(2))


def _released_state(count: int) -> np.ndarray:
    """Displacement of the second step of a tissue in one level: walls in contact."""
    with threads(count):
        simulation = Simulation(read_case(_CASES / "shear-empty-3x3.toml", ["accuracy=0.1", "load.levels=1"]))
        *_, last = islice(simulation.follow(Checkpoint()), 2)
        return last.minimum.state.displacement


def test_sums_of_numpy_on_threads_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    alone = _released_state(1)
    told = set[str]()
    monkeypatch.setattr(module, "_FEWEST_OF_NUMPY", 0)
    submit = module.ThreadPoolExecutor.submit

    def noted(pool: module.ThreadPoolExecutor, *task: Any) -> Any:
        told.add(getattr(task[1], "func", task[1]).__qualname__)
        return submit(pool, *task)

    monkeypatch.setattr(module.ThreadPoolExecutor, "submit", noted)
    assert np.array_equal(alone, _released_state(3))
    places = {name.partition(".<locals>")[0] for name in told}
    assert places == {"PairSearch._pairs_among", "Eliminated.of", "Eliminated._by_parts", "SymmetricMatrix.multiply"}


def test_tasks_are_found_in_order_and_errors_are_told() -> None:
    with threads(3):
        assert at_once(10**6, [lambda: 1, lambda: 2, lambda: 3]) == [1, 2, 3]
        with pytest.raises(ZeroDivisionError):
            at_once(10**6, [lambda: 1, lambda: 1 // 0])
        with np.errstate(divide="ignore"):
            assert at_once(10**6, 2 * [lambda: float(np.float64(1) / np.float64(0))]) == [np.inf, np.inf]


@pytest.mark.parametrize("count", [0, 1, 2, 7])
def test_parts_hold_everything_once(count: int) -> None:
    with threads(3):
        parts = parts_of(count, 10**6)
    assert [number for part in parts for number in range(count)[part]] == list(range(count))
    assert len(parts_of(count, 10**6)) == 1  # on one thread


def test_runs_that_are_followed_in_turns_do_not_change_each_others_threads() -> None:
    def made() -> Iterator[int]:
        while True:
            yield module._Threads.count

    two, three = each_on_threads(made(), 2), each_on_threads(made(), 3)
    assert [next(two), next(three), next(two)] == [2, 3, 2]
    three.close()
    assert next(two) == 2 and module._Threads.count == 1 and module._Threads.others is None
    assert at_once(10**6, [lambda: 1, lambda: 2]) == [1, 2]
    assert list(each_on_threads(iter(()), 2)) == []
