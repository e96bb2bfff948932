"""Steps that are judged by forces, where differences of energies are round-off."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.trials import Trials

#: A displacement that is next to nothing beside an energy of 1.
SMALL = 1e-9
NOWHERE = ProximalTerm(0.0, np.zeros(1))


@dataclass(frozen=True)
class Point:
    displacement: np.ndarray
    energy: float = 1.0


def force(state: Any, _: ProximalTerm) -> np.ndarray:
    """A bond that is pulled by a stiffness of 1 and pressed by one of 3."""
    return np.where(state.displacement > 0, state.displacement, 3 * state.displacement)


def trials(begin: float) -> Trials:
    problem = SimpleNamespace(move=lambda place, step: place + step, metric=None)
    nowhere = SimpleNamespace(value=lambda *_: 0.0)
    kept = SimpleNamespace(of=lambda place: place)
    return Trials(problem, Point, Point(np.array([begin])), nowhere, kept, 1.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(("begin", "step"), [(-SMALL, 4 * SMALL), (SMALL, -3 * SMALL)])
def test_a_step_too_far_ends_where_forces_along_it_vanish(begin: float, step: float):
    start, after = Point(np.array([begin])), Point(np.array([begin + step]))
    found = trials(begin).balanced(np.array([step]), step * float(force(start, NOWHERE)[0]), after, force)
    ended, far = (float(abs(force(state, NOWHERE)[0])) for state in (found, start))
    assert ended < far / 4
    assert abs(found.displacement[0]) < abs(begin + step)


@pytest.mark.parametrize("step", [0.8 * SMALL, SMALL, 1.2 * SMALL])
def test_other_steps_are_kept(step: float):
    after = Point(np.array([step - SMALL]))
    assert trials(-SMALL).balanced(np.array([step]), -3 * SMALL * step, after, force) is after
