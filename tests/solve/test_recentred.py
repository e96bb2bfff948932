"""The proximal point method on a bowl whose minimum is known: how many centres it takes, and where it ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy import sparse

from ngcell.solve.conditions import until_conditions_hold
from ngcell.solve.continuation import Continuation
from ngcell.solve.continuation_options import ContinuationOptions
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.options import SolverOptions
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.recentred import at_rest, force_through, pull_over_felt, recentred
from ngcell.solve.refined import settled
from ngcell.solve.rested import rested
from tests.solve.test_minimise import NOWHERE, Landscape, Model, Point

#: Weight of the proximal term, and that beside which the bowl is soft.
WEIGHT, FAR = 1.0, 0.4


@dataclass
class Bowl(Landscape):
    """Soft along x, with its bottom at `FAR`: ``curvature (x - FAR)^2 / 2 - 1``; what presses on it is a unit force."""

    curvature: float = 0.1
    stored: float = 0.0
    has_multipliers: bool = False

    def at(self, displacement: np.ndarray) -> Point:
        self.visited.append(displacement)
        return Point(displacement, self.curvature / 2 * (displacement[0] - FAR) ** 2 - 1)

    def magnitude(self, state: Point) -> float:
        return max(abs(state.energy), self.stored)

    def linearise(self, state: Point) -> Model:
        gradient = np.array([self.curvature * (state.displacement[0] - FAR), 0.0, 0.0])
        return replace(super().linearise(state), gradient=gradient, stiffness=np.array([self.curvature, 1.0, 1.0]))

    def gradient_of_constraints(self, state: Point) -> np.ndarray:
        return np.array([1.0, 0.0, 0.0])

    def resultants(self, force: np.ndarray) -> np.ndarray:
        return force[None]

    def update_multipliers(self, state: Point) -> tuple[float, float]:
        return 0.0, 0.0

    def take_finer_rule(self, state: Point) -> bool:
        return False


@pytest.mark.parametrize("longest_step", [1.0, 0.1])
def test_the_next_centre_is_ahead_where_bodies_creep_on(longest_step):
    """One after the other, 30 minima as centres would leave ten elevenths of the way each, and come within 0.023."""
    options = ContinuationOptions(felt=1e-3, sufficient=1e-4, recentred=1.0)
    minimiser = Minimiser(Bowl(), longest_step, energy_scale=1.0)
    minimum = recentred(minimiser, np.zeros(3), WEIGHT, options)
    assert minimum.is_found
    pull = minimum.proximal.weight * abs(minimum.proximal.centre[0] - minimum.state.displacement[0])
    assert pull <= options.felt  # what balances the slope of the bowl
    assert abs(minimum.state.displacement[0] - FAR) == pytest.approx(pull / 0.1, rel=1e-6, abs=1e-9)
    assert minimiser.effort.iterations <= 20  # 57 if centres were not ahead


def test_minima_are_as_sure_as_what_bodies_store_asks_for():
    """Where loads take nearly all of it away, energies that are nothing beside it are not followed."""
    options = ContinuationOptions(felt=1.0, sufficient=1e-2, recentred=1.0)
    spent = []
    for stored in (0.0, 100.0):
        minimiser = Minimiser(Bowl(stored=stored), 0.1, energy_scale=1.0)
        minimum = recentred(minimiser, np.zeros(3), WEIGHT, options)
        assert minimum.is_found
        assert minimum.to_fall <= options.sufficient * max(abs(minimum.state.energy), stored)
        spent.append(minimiser.effort.iterations)
    assert spent[1] < spent[0]


def test_it_ends_without_an_equilibrium_once_the_energy_is_too_low():
    options = ContinuationOptions(felt=1e-3, sufficient=1e-4, recentred=1.0)
    bowl = Bowl()
    begin = bowl.at(np.zeros(3)).energy
    for lowest, ending in ((-np.inf, Ending.CONVERGED), (-1.1, Ending.CONVERGED), ((begin - 1) / 2, Ending.SLID)):
        minimiser = Minimiser(bowl, 0.1, energy_scale=1.0)
        minimum = recentred(minimiser, np.zeros(3), WEIGHT, options, lowest)
        assert minimum.ending is ending
        assert minimum.is_found is (ending is Ending.CONVERGED)


@dataclass
class Overlapping(Bowl):
    """A bowl whose penalty terms are made stiffer again and again, and leave a share of their overlap each time. Their
    energy grows by as much each time."""

    left: float = 0.1
    deepest: float = 1e-3
    updates: int = 0
    grows: float = 0.0

    def at(self, displacement: np.ndarray) -> Point:
        found = super().at(displacement)
        return replace(found, energy=found.energy + self.grows * self.updates)

    def update_multipliers(self, state: Point) -> tuple[float, float]:
        self.updates += 1
        self.deepest *= self.left
        return self.deepest, 0.0


@pytest.mark.parametrize(
    ("left", "grows", "has_multipliers", "is_found"),
    [(0.1, 1.0, False, True), (0.5, 1.0, False, False), (0.5, 0.0, False, True), (0.5, 1.0, True, True)],
)
def test_overlaps_that_stiffer_penalty_terms_leave_are_given_up(left, grows, has_multipliers, is_found):
    """Where walls press each other a tenth is left; on wrong sides of each other they stay, and the energy grows. As
    long as it falls, walls slide on. Multipliers are no penalty.
    """
    options = ContinuationOptions(felt=1e-3, sufficient=1e-4, recentred=1.0)
    bowl = Overlapping(left=left, has_multipliers=has_multipliers, grows=grows)
    minimum = recentred(Minimiser(bowl, 0.1, energy_scale=1.0), np.zeros(3), WEIGHT, options)
    assert minimum.is_found is is_found
    if not is_found:
        assert minimum.ending is Ending.CONDITIONS_MISSED
        assert bowl.updates == 1 + options.most_in_vain


@pytest.mark.parametrize(("has_multipliers", "updates"), [(False, 0), (True, 1)])
def test_where_it_ends_penalty_terms_are_judged_once_it_is_at_rest(has_multipliers, updates):
    """There the energy may still fall by more than they store; multipliers are updated each time."""
    options = ContinuationOptions(felt=1e3, sufficient=1.0, recentred=1.0)
    bowl = Overlapping(has_multipliers=has_multipliers)
    assert recentred(Minimiser(bowl, 0.1, energy_scale=1.0), np.zeros(3), WEIGHT, options).is_found
    assert bowl.updates == updates


def test_last_digits_are_found_under_a_firm_hold_and_the_pull_that_is_left_is_taken_away():
    """A firm term stops the bowl after a hundredth of the way, and pulls as much as the slope does."""
    options = ContinuationOptions(felt=1.0, sufficient=1.0, recentred=0.1, resting=10.0, allowed=1e-3)
    minimiser, path = Minimiser(Bowl(), 1.0, energy_scale=1.0), Continuation(1.0, options)
    begin = recentred(minimiser, np.zeros(3), 1e6, options)
    firm = at_rest(minimiser, begin, path.scale, options.resting, options, 1e-12)
    assert firm.state.displacement[0] == pytest.approx(0.01 * FAR, rel=0.02)
    assert pull_over_felt(minimiser, firm, options.allowed) == pytest.approx(0.04 / options.allowed, rel=0.02)
    free = rested(minimiser, firm, path.scale, path.options)
    assert free.is_found
    assert pull_over_felt(minimiser, free, options.allowed) <= 1
    assert free.state.displacement[0] == pytest.approx(FAR, rel=0.05)


def test_the_path_sets_out_from_its_centre_where_that_is_lower():
    """A start that is far away would take a step of the longest length after the other."""
    path, centre, far = Continuation(1.0, ContinuationOptions(first=10.0)), np.zeros(3), np.array([0.0, 7.0, 0.0])
    begun = []
    for start in (centre, far):
        minimiser = Minimiser(Bowl(), 0.5, energy_scale=1.0)
        begun.append((path.begin(minimiser, start, centre), minimiser.effort.iterations))
    (near, few), (found, many) = begun
    assert many == few
    np.testing.assert_array_equal(found.state.displacement, near.state.displacement)


def test_conditions_are_met_once_the_pull_that_is_left_is_taken_away(monkeypatch):
    """Where walls go on, multipliers that were updated to the end would be so for nothing."""
    options = ContinuationOptions(felt=1.0, sufficient=1.0, recentred=0.1, resting=10.0, allowed=1e-3)
    minimiser, path = Minimiser(Bowl(has_multipliers=True), 1.0, energy_scale=1.0), Continuation(1.0, options)
    begin = recentred(minimiser, np.zeros(3), 1e6, options)
    firm = at_rest(minimiser, begin, path.scale, options.resting, options, 1e-12)
    pulls = []

    def noted(minimiser, minimum, *rest, **more):
        pulls.append(pull_over_felt(minimiser, minimum, options.allowed))
        return until_conditions_hold(minimiser, minimum, *rest, **more)

    monkeypatch.setattr("ngcell.solve.rested.until_conditions_hold", noted)
    assert rested(minimiser, firm, path.scale, path.options).is_found
    assert pulls and max(pulls) <= 1


def test_the_pull_on_all_bodies_is_felt_beside_what_goes_through_the_supports():
    """Ten bodies on either plate, each pressed by one: together they are pressed by ten."""
    on_plates = np.repeat([[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0]], 10, axis=0)
    assert force_through(on_plates) == pytest.approx(10.0)
    assert force_through(np.zeros((3, 2))) == 0.0

    class Row(Bowl):
        free = np.array([True, True, False])

        def gradient(self, state: Point) -> np.ndarray:
            return np.zeros(3)

        def resultants(self, force: np.ndarray) -> np.ndarray:
            return on_plates if not force.any() else np.repeat(force[None, :2], len(on_plates), axis=0)

        def gradient_of_constraints(self, state: Point) -> np.ndarray:
            return np.zeros(3)

    minimiser, weight = Minimiser(Row(), 1.0, energy_scale=1.0), 1e-3
    minimum = replace(recentred(Minimiser(Bowl(), 1.0, energy_scale=1.0), np.zeros(3), WEIGHT, ContinuationOptions()),
                      proximal=ProximalTerm(weight, np.array([-1.0, 0.0, 0.0])))
    way = minimum.state.displacement[0] + 1.0
    assert pull_over_felt(minimiser, minimum, 0.1) == pytest.approx(30 * weight * way / 10 / 0.1)


def test_what_supports_bear_is_told_without_the_proximal_term():
    """The last unknown is a support: a term that acts on it, too, makes no force that its pull is nothing beside."""

    class Held(Bowl):
        metric = sparse.csr_array(np.array([[1.0, 0.0, -1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]))

        def gradient(self, state: Point) -> np.ndarray:
            pulled = -weight * self.metric @ (state.displacement - centre)
            return pulled + np.array([0.0, 1.0, 1e-3])  # forces within the body, and what another one presses with

        def resultants(self, force: np.ndarray) -> np.ndarray:
            return np.array([[force[0] + force[2], force[1]]])

        def gradient_of_constraints(self, state: Point) -> np.ndarray:
            return np.zeros(3)

    weight, centre = 0.5, np.array([-3e-3, -1e-3, 0.0])
    held, state = Held(free=np.array([True, True, False])), Point(np.zeros(3), -1.0)
    minimum = Minimum(state, Ending.CONVERGED, 0.0, ProximalTerm(weight, centre))
    nodal = minimum.proximal.gradient(state.displacement, held.metric)
    on_body = np.linalg.norm(held.resultants(nodal))
    assert on_body == pytest.approx(weight * 1e-3)
    pressed = 1e-3  # with the term it would be 2.5e-3
    found = pull_over_felt(Minimiser(held, 1.0, energy_scale=1.0), minimum, 0.1)
    assert found == pytest.approx(on_body / pressed / 0.1)


def test_meshes_that_lead_end_early_and_last_digits_are_found_where_they_are_reported():
    """A well that is not quadratic, whose digits take a few iterations: 1e-8 at 0.1, and round-off without accuracy."""

    class Well(Bowl):
        def at(self, displacement: np.ndarray) -> Point:
            way = displacement[0] - FAR
            return Point(displacement, way**2 / 2 + way**4 - 1)

        def linearise(self, state: Point) -> Model:
            way = state.displacement[0] - FAR
            stiffness = np.array([1 + 12 * way**2, 1.0, 1.0])
            return replace(super().linearise(state), gradient=np.array([way + 4 * way**3, 0, 0]), stiffness=stiffness)

    options = ContinuationOptions().within(0.1)
    assert options.of_leading == pytest.approx(1e-8)
    assert ContinuationOptions().within(0.01).of_leading == pytest.approx(1e-10)
    assert ContinuationOptions().of_leading == options.refined
    minimiser, path = Minimiser(Well(), 1.0, energy_scale=1.0), Continuation(1e-9, options)
    begin = Minimum(Well().at(np.zeros(3)), Ending.CONVERGED, 1.0, ProximalTerm(0.0, np.zeros(3)))
    led = at_rest(minimiser, begin, path.scale, 1.0, options, 1e-3)
    assert options.refined < led.decrement <= 1e-3
    found = rested(minimiser, led, path.scale, path.options)
    assert found.is_found and found.decrement <= options.refined
    spent = minimiser.effort.iterations
    assert rested(minimiser, found, path.scale, path.options).state is found.state
    assert minimiser.effort.iterations == spent


def test_a_path_that_only_leads_ends_at_falls_that_its_own_mesh_exceeds_by_far():
    """The bottom is far, and each centre goes an eleventh of the way that is left."""

    def centres(accuracy: float, *, only_leads: bool) -> int:
        options = replace(ContinuationOptions(only_leads=only_leads), first=1.0, recentred=1.0).within(accuracy)
        minimiser, held = Minimiser(Bowl(), 1.0, energy_scale=1.0), ProximalTerm(1.0, np.zeros(3))
        begin = Minimum(minimiser.problem.at(np.zeros(3)), Ending.CONVERGED, 0.0, held)
        found = Continuation(1.0, options).select(begin.state, (minimiser,), np.zeros(3))
        assert found.is_found
        return minimiser.effort.iterations

    assert centres(0.001, only_leads=True) < centres(0.001, only_leads=False)
    assert ContinuationOptions(only_leads=True).within(0.8).at_path_end == ContinuationOptions().within(0.8).at_path_end


def stuck(minimiser: Minimiser, start: np.ndarray, proximal: ProximalTerm, *_: object, **__: object) -> tuple:
    """A minimisation that finds no step down, as at a kink."""
    return Minimum(minimiser.problem.at(start), Ending.NO_DESCENT, 1.0, proximal), minimiser.effort


@pytest.mark.parametrize(
    ("energy", "accuracy", "ending"),
    [(1e-13, np.inf, Ending.CONVERGED), (1e-13, 0.01, Ending.STALLED), (1e-3, 0.01, Ending.NO_DESCENT)],
)
def test_conditions_that_miss_nothing_to_speak_of_may_end_at_a_kink(monkeypatch, energy, accuracy, ending):
    class Kinked(Bowl):
        def update_multipliers(self, state: Point) -> tuple[float, float]:
            return 1e-6, energy

    minimiser = Minimiser(Kinked(), 1.0, energy_scale=1.0)
    minimum = Minimum(minimiser.problem.at(np.zeros(3)), Ending.CONVERGED, 1e-13, NOWHERE)
    monkeypatch.setattr("ngcell.solve.conditions.minimised", stuck)
    options = ContinuationOptions() if np.isinf(accuracy) else ContinuationOptions().within(accuracy)
    found = until_conditions_hold(minimiser, minimum, 1.0, options)
    assert found.ending is ending
    np.testing.assert_array_equal(found.state.displacement, minimum.state.displacement)
    assert found.decrement == 1.0  # multipliers have changed since that of the minimum before


def test_at_a_kink_no_last_digits_are_looked_for_once_more(monkeypatch):
    options, minimiser = ContinuationOptions().within(0.01), Minimiser(Bowl(), 1.0, energy_scale=1.0)
    state = minimiser.problem.at(np.array([1.0, 0.0, 0.0]))
    stalled = Minimum(state, Ending.STALLED, options.nothing * abs(state.energy) / 2, NOWHERE)
    assert rested(minimiser, stalled, 1e-9, options).state is state
    assert minimiser.effort.iterations == 0
    for other in (replace(stalled, ending=Ending.CONVERGED), replace(stalled, decrement=1e-3)):
        assert rested(minimiser, other, 1e-9, options).decrement < stalled.decrement
    assert minimiser.effort.iterations > 0


def test_what_misses_nothing_to_speak_of_is_followed_no_further(monkeypatch):
    asked = []

    class Missing(Bowl):
        def update_multipliers(self, state: Point) -> tuple[float, float]:
            return (0.0, 0.0) if asked else (1e-6, 1e-20)

    def noting(minimiser: Minimiser, start: np.ndarray, proximal: ProximalTerm, *given: object) -> tuple:
        asked.append(given[2])
        return Minimum(minimiser.problem.at(start), Ending.CONVERGED, 0.0, proximal), minimiser.effort

    minimiser, options = Minimiser(Missing(), 1.0, energy_scale=1.0), ContinuationOptions().within(0.01)
    minimum = Minimum(minimiser.problem.at(np.zeros(3)), Ending.CONVERGED, 1e-13, NOWHERE)
    monkeypatch.setattr("ngcell.solve.conditions.minimised", noting)
    until_conditions_hold(minimiser, minimum, 1.0, options)
    assert asked == [options.update * options.nothing * minimiser.problem.magnitude(minimum.state)]


@pytest.mark.parametrize(("force", "updates"), [(1.0, 4), (1e3, 5)])
def test_the_larger_pressures_are_beside_the_energy_the_less_multipliers_may_miss(force, updates):
    asked = []

    class Pressed(Bowl):
        def gradient_of_constraints(self, state: Point) -> np.ndarray:
            return np.array([force, 0.0, 0.0])

        def update_multipliers(self, state: Point) -> tuple[float, float]:
            asked.append(10.0 ** -(3 + 2 * len(asked)))
            return asked[-1], 1e-3

    options = ContinuationOptions(condition=1e-8)
    minimiser = Minimiser(Pressed(has_multipliers=True), 1.0, energy_scale=1.0)
    start = Minimum(minimiser.problem.at(np.ones(3)), Ending.CONVERGED, 0.0, NOWHERE)
    found = until_conditions_hold(minimiser, start, 1.0, options)
    assert found.is_found and len(asked) == updates
    magnitude = minimiser.problem.magnitude(found.state)
    assert asked[-1] * force <= options.missed_work * magnitude < asked[-2] * force or asked[-1] <= 1e-8 < asked[-2]


def test_states_that_multipliers_take_over_from_need_no_last_digits():
    path, spent = Continuation(1.0, ContinuationOptions().within(0.1)), []
    for share in (path.options.of_leading, np.inf):
        minimiser = Minimiser(Bowl(), 0.1, energy_scale=1.0)
        found = settled((minimiser,), np.zeros(3), length=1.0, options=SolverOptions(), path=path, share=share)
        assert found.is_found and found.to_fall <= path.options.sufficient
        spent.append(minimiser.effort.iterations)
    assert spent[1] < spent[0]


@pytest.mark.parametrize("is_finer", [True, False])
def test_where_a_finer_rule_finds_elements_folded_it_is_tried_once_more_from_the_start(is_finer):
    """The first minimum is beyond the place up to which the energy is known once the rule is finer, and the next not.
    """

    class Folding(Bowl):
        edge = np.inf

        def at(self, displacement: np.ndarray) -> Point:
            found = super().at(displacement)
            return replace(found, energy=np.nan) if displacement[0] > self.edge else found

        def take_finer_rule(self, state: Point) -> bool:
            if np.isfinite(self.edge) or not is_finer:
                return False
            self.edge = state.displacement[0] / 2.1  # between two digits
            return True

    minimiser = Minimiser(Folding(), 1.0, energy_scale=1.0)
    found = settled((minimiser,), np.zeros(3), length=1.0, options=SolverOptions())
    assert minimiser.effort.iterations > 0
    assert (found.ending is Ending.NO_DESCENT) is is_finer  # the rim is no minimum
    assert not is_finer or found.state.displacement[0] <= minimiser.problem.edge


def test_where_elements_fold_between_the_points_of_a_rule_and_nothing_is_found_a_finer_one_is_tried():
    """By the coarse rule there is no energy short of the bottom, and no way down to it."""

    class Folded(Bowl):
        edge = FAR / 2

        def at(self, displacement: np.ndarray) -> Point:
            found = super().at(displacement)
            return replace(found, energy=np.nan) if displacement[0] > self.edge else found

        def take_finer_rule(self, state: Point) -> bool:
            was_coarse, self.edge = bool(np.isfinite(self.edge)), np.inf
            return was_coarse

    minimiser = Minimiser(Folded(), 1.0, energy_scale=1.0)
    found = settled((minimiser,), np.zeros(3), length=1.0, options=SolverOptions())
    assert found.is_found and found.state.displacement[0] == pytest.approx(FAR)


@pytest.mark.parametrize("deepest", [0.5, 2.0])
def test_a_path_on_which_walls_sink_past_the_middle_of_others_is_not_followed_on(deepest):
    """The longest step is half of the thinnest wall; contact that is stiffer would find points on wrong sides."""

    class Sunk(Bowl):
        def gaps(self, state: Point) -> tuple[np.ndarray, np.ndarray]:
            return np.arange(1), np.array([-deepest * 0.1])

        def start_from(self, before: Bowl, state: Point) -> None:
            pass

    soft, meant = (Minimiser(Sunk(), 0.1, energy_scale=1.0) for _ in range(2))
    path, centre = Continuation(1.0, ContinuationOptions().within(0.1)), np.zeros(3)
    begin = path.begin(soft, centre, centre)
    found = path.select(begin.state, (soft, meant), centre)
    assert found.is_found is (deepest < 1)
    assert (meant.effort.iterations > 0) is (deepest < 1)


@pytest.mark.parametrize(("decrement", "ending"), [(1e-13, Ending.CONVERGED), (1e-9, Ending.NO_DESCENT)])
def test_last_digits_that_are_round_off_may_be_missing_at_a_kink(monkeypatch, decrement, ending):
    options = ContinuationOptions().within(0.1)
    minimiser, path = Minimiser(Bowl(), 1.0, energy_scale=1.0), Continuation(1.0, options)
    held = ProximalTerm(options.resting, np.zeros(3))
    minimum = Minimum(minimiser.problem.at(np.zeros(3)), Ending.CONVERGED, decrement, held)
    monkeypatch.setattr("ngcell.solve.rested.minimised", stuck)
    monkeypatch.setattr("ngcell.solve.rested.at_rest", lambda *about: pytest.fail("held firmly already"))
    assert rested(minimiser, minimum, path.scale, path.options).ending is ending
