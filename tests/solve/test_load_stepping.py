"""Load stepping: what it does with predictions that run ahead of the supports, and how far it cuts a step."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from ngcell.solve.effort import Effort
from ngcell.solve.options import LoadSteppingOptions
from ngcell.solve.step import MOST_HALVINGS, Accepted, Account, StepFailed
from ngcell.solve.strategies.load_stepping import _Path, _Place
from ngcell.solve.strategies.strategy import Progress


def path_with(way_of_weight, weight=1e-9):
    """Return a path whose supports move by 0.01, and whose prediction moves bodies as the proximal weight says."""
    path = object.__new__(_Path)
    path._options = LoadSteppingOptions()
    path._motion = SimpleNamespace(imposed=lambda displacement, goal: displacement + 0.01)
    path._minimiser = SimpleNamespace(
        longest_step=0.1, predict=lambda displacement, imposed, weight: displacement + way_of_weight(weight)
    )
    proximal = SimpleNamespace(weight=weight)
    path._released = SimpleNamespace(path=SimpleNamespace(last_proximal=lambda displacement: proximal))
    return path


def test_a_prediction_that_a_heavier_proximal_term_holds_back_is_taken():
    found = path_with(lambda weight: 1 / (1 + weight))._followed(np.zeros(3), 0.5)
    assert found is not None and 0 < np.abs(found).max() <= 0.2


@pytest.mark.parametrize("way", [lambda weight: 0.5 + weight, lambda weight: np.nan], ids=["further", "not a number"])
def test_a_prediction_that_nothing_holds_back_is_none(way):
    assert path_with(way)._followed(np.zeros(3), 0.5) is None


def first_step(levels: list[float], longest: float) -> Accepted:
    """Return the first step of a path to these load factors on which no step longer than `longest` can be made."""
    minimum = SimpleNamespace(state=SimpleNamespace(displacement=np.zeros(1)))

    def tried(place, goal, *, is_shortest):
        if abs(goal - place.load) > longest:
            return None
        return _Place(goal, minimum, 0.0), Account(0.0, 0.0)

    path = object.__new__(_Path)
    path._task, path._options = SimpleNamespace(steps=levels), LoadSteppingOptions()
    path._start, path._pieces, path._tried = lambda progress: _Place(0.0, minimum, 0.0), lambda place, target: 1, tried
    path._minimiser = SimpleNamespace(forget_matrix=lambda: None)
    path._released = SimpleNamespace(effort=Effort(), apart=SimpleNamespace(effort=Effort()))
    path._problem = SimpleNamespace(accept=lambda displacement: None)
    return next(path.steps(Progress()))


def test_a_path_of_one_level_is_cut_as_finely_as_one_of_ten():
    longest = 0.1 / 2**MOST_HALVINGS
    one, ten = first_step([1.0], longest), first_step([0.1 * level for level in range(1, 11)], longest)
    assert 0 < one.load_factor <= longest and 0 < ten.load_factor <= longest


def test_a_step_whose_balance_does_not_close_is_cut_further_and_then_refused():
    levels = [0.1 * level for level in range(1, 11)]
    shortest = 0.1 / 2**MOST_HALVINGS
    assert first_step(levels, shortest / 10).load_factor == pytest.approx(shortest / 16)
    with pytest.raises(StepFailed):
        first_step(levels, shortest / 1000)
