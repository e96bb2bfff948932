"""Steps of models that are not convex: what is sound of them is taken, where the fault is in a few bodies."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from scipy import sparse

from ngcell.clock import Clock
from ngcell.solve.damping import Damper
from ngcell.solve.effort import Effort
from ngcell.solve.growing import GrowingMatrix
from ngcell.solve.newton import Newton, NewtonStep
from ngcell.solve.one_sided import OneSidedModel
from ngcell.solve.options import MinimiserOptions
from ngcell.solve.stiffness import Stiffness


def step_of(
    bodies: int, unstable: int, gap: float = -0.1, longest_step: float = inf, pull: float = 1.0
) -> tuple[NewtonStep, Effort]:
    """Bodies with one unknown each that are pulled; some are unstable and held by a stop that opens along the step.

    Others have a stop that is open, and stays so; it couples each body with the next.
    """
    numbers, free = np.arange(bodies), np.ones(bodies, dtype=bool)
    is_unstable = numbers < unstable
    open_stops = np.eye(bodies)[:-1] + np.eye(bodies, k=1)[:-1]
    model = OneSidedModel(
        np.where(is_unstable, -0.5, -pull),
        Stiffness(np.where(is_unstable, -1.0, 1.0)),
        np.append(np.full(unstable, gap), np.full(bodies - 1, 1e3)),
        sparse.csr_array(np.vstack([np.eye(bodies)[:unstable], open_stops])),
        np.full(unstable + bodies - 1, 3.0),
        free,
    )
    effort, options = Effort(), MinimiserOptions()
    newton = Newton(Damper(sparse.csr_array(np.eye(bodies)), numbers, options), longest_step, options, Clock(), effort)
    return newton.step(model, GrowingMatrix(bodies, free, numbers, numbers)), effort


def test_where_a_few_bodies_are_at_fault_the_step_is_what_was_gained_before():
    found, effort = step_of(bodies=4, unstable=1)
    np.testing.assert_allclose(found.step, [0.4, 1.0, 1.0, 1.0], rtol=1e-12)
    assert found.change < 0 and found.slope < 0 and found.share == 1
    assert found.decrement == pytest.approx(0.5 * 0.4 + 0.3 * 0.4 + 3.0)
    assert found.not_convex is not None
    way, lacking = found.not_convex
    assert lacking[0] == pytest.approx(way[0] ** 2)
    assert lacking[1:].max() <= 1e-12
    assert effort.factorisations >= 1


def test_it_is_no_longer_than_any_other():
    found, _ = step_of(bodies=4, unstable=1, longest_step=0.5)
    np.testing.assert_allclose(found.step, [0.2, 0.5, 0.5, 0.5], rtol=1e-12)
    assert found.share == 0.5
    assert found.decrement == pytest.approx(0.5 * 0.4 + 0.3 * 0.4 + 3.0)


def test_where_most_bodies_are_at_fault_the_model_is_refused():
    found, _ = step_of(bodies=3, unstable=2)
    assert found.not_convex is None
    assert found.change > 0


def test_where_the_first_round_goes_up_nothing_is_taken_and_the_fault_is_told():
    found, _ = step_of(bodies=4, unstable=1, gap=1.0, pull=0.1)
    assert found.change > 0
    assert found.not_convex is not None and found.not_convex[1][0] > 0


def test_a_convex_model_has_no_fault():
    found, _ = step_of(bodies=4, unstable=0)
    assert found.not_convex is None
    np.testing.assert_allclose(found.step, 1.0)


@pytest.mark.parametrize(("bodies", "gain"), [(2, 0.3), (35, 0.3), (100, 0.105), (500, 0.021)])
def test_among_many_bodies_a_small_share_of_the_decrease_is_worth_another_round(bodies, gain):
    damper = Damper(sparse.csr_array(np.eye(bodies)), np.arange(bodies), MinimiserOptions())
    newton = Newton(damper, inf, damper.options, Clock(), Effort())
    assert newton._inner.worthwhile_gain == pytest.approx(gain)
