"""Where walls come to rest: from which decrement on a firm proximal term hardly pulls, how long they are followed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from ngcell.solve.continuation_options import ContinuationOptions
from ngcell.solve.effort import Budget
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.recentred import at_rest, decrement_of_pull, pull_over_felt
from ngcell.solve.rested import led_to_rest, rested
from tests.solve.test_minimise import Model, Point
from tests.solve.test_recentred import FAR, Bowl

OPTIONS = ContinuationOptions().within(0.1)


def at(bowl: Bowl, place: float) -> Minimum:
    state = bowl.at(np.array([place, 0.0, 0.0]))
    return Minimum(state, Ending.CONVERGED, 1.0, ProximalTerm(OPTIONS.resting, state.displacement))


@pytest.mark.parametrize("curvature", [1e-6, 1e-4, 1e-3, 1e-2, 1.0])
def test_a_state_with_that_decrement_is_hardly_pulled_by_a_firm_proximal_term(curvature):
    """A unit force presses the one body of unit mass. Where the bowl is as stiff as the term, half of what may be."""
    share, weight = 1e-3, 1e-3
    bowl = Bowl(curvature=curvature)
    minimiser = Minimiser(bowl, 1e3, energy_scale=1.0)
    decrement = decrement_of_pull(minimiser, at(bowl, 0.0), weight, share)
    assert decrement == pytest.approx(share**2 / (2 * weight))
    begin = at(bowl, FAR - np.sqrt(2 * decrement / curvature))
    held = at_rest(minimiser, begin, 1.0, weight, OPTIONS, 1e-16)
    pull = pull_over_felt(minimiser, held, share)
    stiff = curvature / weight
    assert pull == pytest.approx(np.sqrt(stiff) / (1 + stiff), rel=1e-4)
    assert pull <= 0.5 * (1 + 1e-4)


@dataclass
class Valley(Bowl):
    """A long bent valley, steep across: its bottom falls evenly until `FAR`, and each step along it is short."""

    slope: float = 0.02
    width: float = 0.01

    def at(self, displacement: np.ndarray) -> Point:
        x, y = displacement[0] - FAR, displacement[1]
        across = y - self.width * np.sin(displacement[0] / self.width)
        return Point(displacement, self.slope * (np.sqrt(x**2 + 1e-4) - 1) + across**2 / 2)

    def linearise(self, state: Point) -> Model:
        x, y = state.displacement[0] - FAR, state.displacement[1]
        wave = state.displacement[0] / self.width
        across, bend = y - self.width * np.sin(wave), -np.cos(wave)
        gradient = np.array([self.slope * x / np.sqrt(x**2 + 1e-4) + across * bend, across, 0.0])
        return replace(super().linearise(state), gradient=gradient, stiffness=np.array([1.0, 1.0, 1.0]))


@pytest.mark.parametrize(("stored", "times"), [(0.0, 10), (1e3, 1)])
def test_a_mesh_that_leads_is_followed_as_long_as_the_path_took_and_on_while_the_energy_falls(stored, times):
    """Beside what is stored, a fall may be nothing."""
    valley = Valley(stored=stored)
    minimiser, way = Minimiser(valley, 2e-3, energy_scale=1.0), 20
    found = led_to_rest(minimiser, at(valley, 0.0), 1.0, replace(OPTIONS, resting=1.0), way)
    assert found.is_found
    assert times * way <= minimiser.effort.iterations < (times + 2) * way
    assert 0 < found.state.displacement[0] < FAR
    assert found.slid_from is not None and found.slid_from[0] < found.state.displacement[0]


def test_walls_are_followed_for_no_more_than_half_of_the_work_of_a_step():
    """What is left is for finer meshes, and for what makes the step out of it."""
    valley = Valley()
    budget = Budget(most=100)
    minimiser = Minimiser(valley, 2e-3, energy_scale=1.0, budget=budget)
    found = led_to_rest(minimiser, at(valley, 0.0), 1.0, replace(OPTIONS, resting=1.0), 20)
    assert found.is_found and 0.5 < budget.used < 1


@pytest.mark.parametrize("ending", [Ending.NO_DESCENT, Ending.CONDITIONS_MISSED])
def test_walls_that_cannot_be_followed_stay_where_they_have_come_to_rest(monkeypatch, ending):
    bowl = Bowl(curvature=0.01)
    minimiser = Minimiser(bowl, 10.0, energy_scale=1.0)
    begin = at(bowl, FAR - 5.0)
    lost = replace(begin, ending=ending, state=bowl.at(np.array([3.0, 0.0, 0.0])))
    monkeypatch.setattr("ngcell.solve.rested.recentred", lambda *where, **how: lost)
    found = led_to_rest(minimiser, begin, 1.0, OPTIONS, 1000)
    rest = at_rest(minimiser, begin, 1.0, OPTIONS.resting, OPTIONS, OPTIONS.of_leading)
    assert found.is_found
    np.testing.assert_array_equal(found.state.displacement, rest.state.displacement)
    assert found.slid_from is None


def test_a_mesh_that_leads_comes_to_rest_with_less_pull_than_is_allowed_where_it_is_reported():
    bowl = Bowl(curvature=0.01)
    minimiser = Minimiser(bowl, 10.0, energy_scale=1.0)
    begin = at_rest(minimiser, at(bowl, FAR - 5.0), 1.0, OPTIONS.resting, OPTIONS, 1e-16)
    assert OPTIONS.allowed_to_lead < pull_over_felt(minimiser, begin, 1.0) < OPTIONS.allowed
    where_it_is = rested(minimiser, begin, 1.0, OPTIONS)
    np.testing.assert_allclose(where_it_is.state.displacement, begin.state.displacement, atol=1e-9)
    led = led_to_rest(minimiser, begin, 1.0, OPTIONS, 1000)
    assert pull_over_felt(minimiser, led, OPTIONS.allowed_to_lead) <= 1


def test_slides_whose_falls_suffice_are_followed_to_their_end_where_they_are_reported():
    """Each iteration gains less than minimisations end at elsewhere; a hundred of them do not."""
    valley = Valley(stored=10.0)
    minimiser = Minimiser(valley, 0.05, energy_scale=1.0)
    found = rested(minimiser, at_rest(minimiser, at(valley, 0.0), 1.0, OPTIONS.resting, OPTIONS, 1e-9), 1.0, OPTIONS)
    assert found.is_found
    assert found.state.displacement[0] == pytest.approx(FAR, abs=5e-3)
