"""Load stepping: what it does with predictions that run ahead of the supports."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from ngcell.solve.options import LoadSteppingOptions
from ngcell.solve.strategies.load_stepping import _Path


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
