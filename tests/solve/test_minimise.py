"""Descent on small energies whose minima are known."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from scipy import sparse

from ngcell.solve.effort import Budget, Effort, OutOfIterations
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Advance, Ending, Minimum
from ngcell.solve.options import MinimiserOptions
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.stall import Progress

NOWHERE = ProximalTerm(0.0, np.zeros(3))


@dataclass(frozen=True)
class Point:
    displacement: np.ndarray
    energy: float


@dataclass(frozen=True)
class Model:
    gradient: np.ndarray
    stiffness: np.ndarray
    curvature: sparse.coo_array | None
    gap: np.ndarray
    jacobian: sparse.csr_array
    penalty: np.ndarray
    keys: np.ndarray


@dataclass
class Landscape:
    """A ball in a double well along x, a bowl along y, and nothing along z; no energy left of x = -3.

        E = (x^2 - 1)^2 + tilt x + y^2 / 2 + penalty term / 2 min(0, stop - x)^2

    In a `trap` the energy is 1 at first and 2 wherever one goes from there.
    """

    tilt: float = 0.0
    stop: float = np.inf
    penalty: float = 0.0
    trap: bool = False
    free: np.ndarray = field(default_factory=lambda: np.ones(3, dtype=bool))
    visited: list[np.ndarray] = field(default_factory=list)

    mass, part = sparse.csr_array(np.eye(3)), np.zeros(3, dtype=int)
    solid = part
    metric = mass
    pattern = (np.arange(3), np.arange(3))

    def folded(self, state: Point) -> np.ndarray:
        return np.array([not np.isfinite(state.energy)])

    def at(self, displacement: np.ndarray) -> Point:
        x, y, _ = displacement
        self.visited.append(displacement)
        if self.trap:
            return Point(displacement, 1.0 + float(len(self.visited) > 1))
        overlap = min(0.0, self.stop - x)
        energy = (x * x - 1) ** 2 + self.tilt * x + y * y / 2 + self.penalty / 2 * overlap**2
        return Point(displacement, energy if x > -3 else float("nan"))

    def move(self, displacement: np.ndarray, step: np.ndarray) -> np.ndarray:
        return displacement + step

    def linearise(self, state: Point) -> Model:
        x, y, _ = state.displacement
        gradient = np.array([4 * x * (x * x - 1) + self.tilt, y, 0.0])
        gap = np.array([self.stop - x] if np.isfinite(self.stop) else [])
        jacobian = sparse.csr_array(np.array([[-1.0, 0, 0]] * len(gap)).reshape(-1, 3))
        stiffness = np.array([12 * x * x - 4, 1.0, 0.0])
        return Model(gradient, stiffness, None, gap, jacobian, np.full(len(gap), self.penalty), np.arange(len(gap)))

    def gradient(self, state: Point) -> np.ndarray:
        line = self.linearise(state)
        return line.gradient + line.jacobian.T @ (line.penalty * np.minimum(line.gap, 0))

    def gaps(self, state: Point) -> tuple[np.ndarray, np.ndarray]:
        gap = np.array([self.stop - state.displacement[0]] if np.isfinite(self.stop) else [])
        return np.arange(len(gap)), gap

    def kinks(self, state: Point, after: Point) -> None:
        return None

    def note_kinks(self, state: Point) -> bool:
        return False

    def couplings(self, state: Point, margin: float) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)


class Crease(Landscape):
    """A bowl along y that is folded along x = 0, of which its models see one side.

    E = 10 |x| + y^2 / 2
    """

    def at(self, displacement: np.ndarray) -> Point:
        x, y, _ = displacement
        return Point(displacement, 10 * abs(x) + y * y / 2)

    def linearise(self, state: Point) -> Model:
        x, y, _ = state.displacement
        return replace(
            super().linearise(state), gradient=np.array([10 * np.sign(x), y, 0.0]), stiffness=np.array([1.0, 1.0, 0.0])
        )


@dataclass(frozen=True)
class Kink:
    gap: np.ndarray
    jacobian: sparse.csr_array
    penalty: np.ndarray
    keys: np.ndarray


@dataclass
class Notch(Landscape):
    """A slope down along x to a narrow notch, of which models from before and from behind see nothing.

    E = -x + slack x^2 / 2 + stiff / 2 min(max(0, x), width)^2, beyond the notch with a slope of 1
    """

    slack, stiff, width = 0.1, 1e3, 2e-3
    is_told: bool = True

    def at(self, displacement: np.ndarray) -> Point:
        x, y, z = displacement
        inside = min(max(0.0, x), self.width)
        energy = -x + self.slack * x * x / 2 + self.stiff * inside * (inside / 2 + max(0.0, x - self.width))
        return Point(displacement, energy + y * y / 2 + z * z / 2)

    def linearise(self, state: Point) -> Model:
        x, y, z = state.displacement
        inside = min(max(0.0, x), self.width)
        slope, bend = -1 + self.slack * x + self.stiff * inside, self.slack + self.stiff * (0 < x < self.width)
        found = super().linearise(state)
        return replace(found, gradient=np.array([slope, y, z]), stiffness=np.array([bend, 1.0, 1.0]))

    def kinks(self, state: Point, after: Point) -> Kink | None:
        way = np.sign(after.displacement[0] - state.displacement[0])
        edge = 0.0 if way > 0 else self.width
        gap, left = (way * (edge - place.displacement[0]) for place in (state, after))
        if not self.is_told or gap <= 0 or left >= 0:
            return None
        jacobian = sparse.csr_array([[-way, 0, 0]])
        return Kink(np.array([gap]), jacobian, np.array([self.stiff]), np.zeros(1, dtype=int))


class Overhang(Landscape):
    """A bowl that a force of contact bends downwards along x, until it has gone.

    E = x^2 / 2 + y^2 / 2 + z^2 / 2 - force x + force / 2 cos(5 x) / 25, of which the last term is the curvature of gaps
    """

    has_multipliers = True
    part = solid = np.arange(3)
    force = 10.0

    def at(self, displacement: np.ndarray) -> Point:
        x = displacement[0]
        self.visited.append(displacement)
        bent = self.force / 50 * np.cos(5 * x)
        return Point(displacement, float(displacement @ displacement / 2 - self.force * x + bent))

    def linearise(self, state: Point) -> Model:
        x = state.displacement[0]
        gradient = state.displacement - np.array([self.force + self.force / 10 * np.sin(5 * x), 0.0, 0.0])
        one = (np.array([-self.force / 2 * np.cos(5 * x)]), (np.array([0]), np.array([0])))
        curvature = sparse.coo_array(one, shape=(3, 3))
        return replace(super().linearise(state), gradient=gradient, stiffness=np.ones(3), curvature=curvature)

    def convex_curvature(self, state: Point) -> None:
        return None


class Ridge(Overhang):
    """A double well whose ridge is due to the curvature of gaps alone.

    E = x^2 / 2 + y^2 / 2 + z^2 / 2 - x^2 + x^4 / 4, of which the last two terms are those of gaps
    """

    def at(self, displacement: np.ndarray) -> Point:
        x = displacement[0]
        return Point(displacement, float(displacement @ displacement / 2 - x**2 + x**4 / 4))

    def linearise(self, state: Point) -> Model:
        x, y, z = state.displacement
        curvature = sparse.coo_array((np.array([3 * x**2 - 2]), (np.array([0]), np.array([0]))), shape=(3, 3))
        return replace(super().linearise(state), gradient=np.array([x**3 - x, y, z]), curvature=curvature)


def descend(
    problem: Landscape,
    start: tuple,
    proximal: ProximalTerm = NOWHERE,
    *,
    longest_step: float = 0.5,
    budget: Budget | None = None,
    tolerance: float = 0.0,
    **numbers: int,
) -> Minimum:
    # Digits that are cut from a place may be all that tells one side of a saddle from the other.
    options, most = MinimiserOptions(last_digit=1e-12, **numbers), budget or Budget()
    minimiser = Minimiser(problem, longest_step, energy_scale=1.0, options=options, budget=most)
    return minimiser.minimise(np.array(start, dtype=float), proximal, tolerance)


@pytest.mark.parametrize("longest_step", [0.5, np.inf])
@pytest.mark.parametrize("start", [-2.9, -1.1, -0.58, -0.3, -1e-3, 1e-3, 0.2, 0.57, 2.5])
def test_a_minimum_is_found_from_slopes_and_from_beside_the_saddle(start, longest_step):
    held = Landscape(free=np.array([True, True, False]))
    minimum = descend(held, (start, 2.0, 0.7), longest_step=longest_step)
    assert minimum.ending is Ending.CONVERGED
    np.testing.assert_allclose(np.abs(minimum.state.displacement), [1, 0, 0.7], atol=1e-9)
    assert minimum.state.energy < 1e-17
    if abs(start) > 1:
        assert minimum.state.displacement[0] * start > 0


@pytest.mark.parametrize("weight", [1e-3, 1e-9])
def test_what_floats_goes_where_the_proximal_term_pulls_and_nothing_else_is_felt(weight):
    centre = np.array([0.3, 0.4, 5.0])
    minimum = descend(Landscape(), (0.5, 1.0, -1.0), ProximalTerm(weight, centre), longest_step=np.inf)
    assert minimum.ending is Ending.CONVERGED
    x, y, z = minimum.state.displacement
    assert z == pytest.approx(5.0, abs=1e-6)
    assert abs(x - 1) < weight and abs(y) < weight


def test_from_beside_a_ridge_of_gaps_steps_go_on_while_the_energy_falls_straight_on():
    """A model without the curvature that makes the ridge has steps that only double the distance from it."""

    def left(straight: float) -> int:
        minimiser = Minimiser(Ridge(), 0.5, energy_scale=1.0, options=MinimiserOptions(straight=straight))
        minimum = minimiser.minimise(np.array([1e-4, 0.0, 0.0]), NOWHERE)
        assert minimum.ending is Ending.CONVERGED
        np.testing.assert_allclose(minimum.state.displacement, [1, 0, 0], atol=1e-9)
        return minimiser.effort.iterations

    assert left(np.inf) >= 12
    assert left(1.5) <= 8


def test_one_sided_penalty_terms_are_found_closed_and_left_open():
    pressed = descend(Landscape(tilt=-2.0, stop=0.5, penalty=1e4), (-0.2, 0.0, 0.0), ProximalTerm(1e-9, np.zeros(3)))
    assert pressed.ending is Ending.CONVERGED
    x = pressed.state.displacement[0]
    force = 4 * x * (x * x - 1) - 2.0 + 1e4 * (x - 0.5)
    assert 0.5 < x < 0.501 and abs(force) < 1e-8
    loose = descend(Landscape(tilt=0.1, stop=0.5, penalty=1e4), (-0.2, 0.0, 0.0), ProximalTerm(1e-9, np.zeros(3)))
    assert loose.state.displacement[0] < -1


def test_no_step_is_longer_than_allowed():
    problem = Landscape(free=np.array([True, True, False]))
    descend(problem, (2.9, 30.0, 0.0), longest_step=0.25)
    moves = np.abs(np.diff(problem.visited, axis=0)).max(1)
    assert moves.max() <= 0.25 * (1 + 1e-12)


def test_a_step_that_was_cut_does_not_count_as_the_last_for_being_short():
    """The bowl's minimum is far away: a cut step changes its energy by 7.5, the whole one by half of 900."""
    problem = Landscape(free=np.array([False, True, False]))
    minimum = descend(problem, (1.0, 30.0, 0.0), longest_step=0.25, tolerance=10.0)
    assert minimum.ending is Ending.CONVERGED
    assert minimum.decrement <= 10.0 and minimum.state.displacement[1] < np.sqrt(10.0)


def test_states_without_energy_are_never_accepted():
    problem = Landscape(tilt=0.0, free=np.array([True, True, False]))
    steep = descend(problem, (-0.58, 0.0, 0.0), longest_step=np.inf)  # the first Newton step would fly off
    assert steep.ending is Ending.CONVERGED
    assert abs(steep.state.displacement[0]) == pytest.approx(1.0)
    assert min(place[0] for place in problem.visited) < -3


def test_every_ending_has_its_cause():
    held = np.array([True, True, False])
    assert descend(Landscape(free=held), (0.9, 0.0, 0.0)).ending is Ending.CONVERGED
    assert descend(Landscape(free=held), (-3.5, 0.0, 0.0)).ending is Ending.NO_ENERGY
    assert descend(Landscape(free=held, trap=True), (0.9, 0.0, 0.0)).ending is Ending.NO_DESCENT
    assert descend(Landscape(free=held, trap=True), (1 + 1e-7, 0.0, 0.0)).ending is Ending.STALLED  # forces: round-off
    short = descend(Landscape(free=held), (2.5, 0.0, 0.0), most_iterations=2)
    assert short.ending is Ending.TOO_MANY_ITERATIONS
    assert short.state.energy < Landscape().at(np.array([2.5, 0, 0])).energy


def test_where_steps_creep_along_a_kink_a_minimisation_ends_as_exact_as_it_is_to_be():
    crease = Crease(free=np.array([True, True, False]))
    rough, exact = (descend(crease, (0.01, 1.0, 0.0), tolerance=tolerance) for tolerance in (1e-2, 1e-9))
    assert rough.ending is Ending.STALLED
    assert exact.state.energy < rough.state.energy < 1


@pytest.mark.parametrize(("length", "gained", "creeps"), [(0.01, 0.1, True), (0.25, 0.1, False), (0.01, 0.3, False)])
def test_damped_iterations_creep_where_they_gain_little_and_are_not_as_long_as_allowed(length, gained, creeps):
    progress, step = Progress(5), np.array([0.0, -length])
    advance = Advance(Point(np.zeros(3), 0.0), np.ones(1), 1.0, True, step=step)
    for number in range(5):
        progress.note(1.0, -number * gained, advance.was_held(0.25))
    assert progress.creeps(-5 * gained, 1.0) == creeps


def test_held_unknowns_keep_their_values():
    minimum = descend(Landscape(free=np.array([True, False, False])), (0.4, 3.0, -2.0))
    np.testing.assert_array_equal(minimum.state.displacement[1:], [3.0, -2.0])


def test_the_energy_falls_with_every_accepted_step():
    energies = []
    for iterations in range(1, 8):
        minimum = descend(Landscape(free=np.array([True, True, False])), (2.9, 3.0, 0.0), most_iterations=iterations)
        energies.append(minimum.state.energy)
    assert (np.diff(energies) <= 0).all()


def test_effort_is_counted():
    minimiser = Minimiser(Landscape(free=np.array([True, True, False])), 0.5, energy_scale=1.0)
    before = minimiser.effort.copy()
    minimiser.minimise(np.array([1.5, 0.2, 0.0]), NOWHERE)
    spent = minimiser.effort - before
    assert spent.iterations <= spent.factorisations
    assert spent.evaluations == len(minimiser.problem.visited)
    assert before.iterations == 0


def test_a_refused_step_is_corrected_for_gaps_only_where_they_are_to_blame():
    """The well refuses steps here; the gap is straight, and nothing is to be won back from its penalty term."""
    problem = Landscape(stop=5.0, penalty=1.0, free=np.array([True, True, False]))
    minimiser = Minimiser(problem, np.inf, energy_scale=1.0)
    assert minimiser.minimise(np.array([0.58, 0.0, 0.0]), NOWHERE).ending is Ending.CONVERGED
    spent = minimiser.effort
    assert spent.refusals > 0
    # One evaluation a try, and that of the start: a correction would be one more.
    assert spent.evaluations <= 1 + spent.iterations + spent.refusals


def test_a_notch_that_a_step_went_over_is_in_its_model():
    start = np.array([-0.5, 1.0, 0.5])

    def found(*, is_told: bool) -> tuple[Minimum, Effort]:
        minimiser = Minimiser(Notch(stop=10.0, is_told=is_told), longest_step=1.0, energy_scale=1.0)
        return minimiser.minimise(start, NOWHERE), minimiser.effort

    (told, effort), (_, untold) = found(is_told=True), found(is_told=False)
    assert told.ending is Ending.CONVERGED
    np.testing.assert_allclose(told.state.displacement, [1e-3, 0, 0], atol=2e-6)
    assert effort.refusals <= 1 < 5 < untold.refusals


def test_a_step_has_a_budget_of_factorisations_and_refusals():
    """Iterations would bound no time: one may refuse many trial steps, each with factorisations of its own."""
    budget, problem = Budget(most=4), Landscape(free=np.array([True, True, False]))
    with pytest.raises(OutOfIterations):
        for _ in range(5):
            descend(problem, (2.9, 3.0, 0.0), budget=budget)
    budget.renew()
    one, other = Effort(factorisations=2), Effort(refusals=1)
    for effort in (one, other):
        budget.charge(effort)
    one.factorisations += 1
    with pytest.raises(OutOfIterations):
        budget.charge(other)


def test_with_multipliers_a_model_that_gaps_bend_downwards_is_taken_without_their_curvature():
    """At the start the model falls without end along x. Without the curvature a step goes as far as the bowl says."""
    found = descend(Overhang(), (0.0, 1.0, 1.0), longest_step=1.0)
    assert found.is_found
    x = found.state.displacement[0]
    assert abs(x - 10 - np.sin(5 * x)) < 1e-8
    problem = Overhang()
    minimiser = Minimiser(problem, 20.0, energy_scale=1.0)
    minimiser.minimise(np.array([0.0, 1.0, 1.0]), NOWHERE, most=1)
    assert minimiser.effort.refusals == 1
    np.testing.assert_allclose(problem.visited[-1], [10.0, 0.0, 0.0], atol=1e-12)


class Walls(Landscape):
    """A bowl among stiff walls, of which its models are right everywhere."""

    def __init__(self, count: int = 40, walls: int = 120) -> None:
        random = np.random.default_rng(1)
        root = random.standard_normal((count, count))
        self.pull, self.full = random.standard_normal(count), root @ root.T / count + 0.01 * np.eye(count)
        self.slopes = sparse.csr_array(random.standard_normal((walls, count)) / np.sqrt(count))
        self.offset, self.firm = random.uniform(0.0, 0.5, walls), np.full(walls, 1e3)
        self.free, self.part = np.ones(count, dtype=bool), np.zeros(count, dtype=int)
        self.solid = self.part
        self.metric = self.mass = sparse.csr_array(np.eye(count))
        self.pattern = np.tril_indices(count)

    def gap(self, place: np.ndarray) -> np.ndarray:
        return self.offset + self.slopes @ place

    def at(self, displacement: np.ndarray) -> Point:
        overlap = np.minimum(self.gap(displacement), 0)
        bowl = displacement @ self.full @ displacement / 2 + self.pull @ displacement
        return Point(displacement, float(bowl + (self.firm * overlap**2).sum() / 2))

    def linearise(self, state: Point) -> Model:
        x = state.displacement
        values = self.full[self.pattern]
        keys = np.arange(len(self.firm))
        return Model(self.full @ x + self.pull, values, None, self.gap(x), self.slopes, self.firm, keys)

    def gradient(self, state: Point) -> np.ndarray:
        overlap = np.minimum(self.gap(state.displacement), 0)
        return self.full @ state.displacement + self.pull + self.slopes.T @ (self.firm * overlap)

    def gaps(self, state: Point) -> tuple[np.ndarray, np.ndarray]:
        return np.arange(len(self.firm)), self.gap(state.displacement)


def test_models_of_settled_walls_are_minimised_as_far_as_the_one_before_was_right():
    """Rounds within a model are cheaper than models, of which last digits take three fifths."""
    start, held = np.zeros(40), ProximalTerm(0.0, np.zeros(40))
    minima, efforts = [], []
    for is_settled in (False, True):
        minimiser = Minimiser(Walls(), longest_step=10.0, energy_scale=1.0)
        minima.append(minimiser.minimise(start, held, 1e-14, is_settled=is_settled))
        efforts.append(minimiser.effort)
    assert [minimum.ending for minimum in minima] == [Ending.CONVERGED] * 2
    assert minima[1].state.displacement == pytest.approx(minima[0].state.displacement, abs=1e-6)
    assert efforts[1].iterations <= 0.7 * efforts[0].iterations
    assert efforts[1].factorisations <= efforts[0].factorisations


@pytest.mark.parametrize("start", [1.4, 1.2, 0.9])
def test_where_walls_have_settled_the_last_decrement_is_foreseen_from_the_forces_left(start: float):
    """It spares the last iteration, and is told no smaller than the one that is found there."""
    tolerance, found = 1e-10, []
    held = Landscape(free=np.array([True, True, False]))
    for is_settled in (False, True):
        minimiser = Minimiser(held, 0.5, energy_scale=1.0, options=MinimiserOptions(last_digit=1e-12))
        minimum = minimiser.minimise(np.array([start, 0.3, 0.0]), NOWHERE, tolerance, is_settled=is_settled)
        spent = minimiser.effort.iterations
        again = minimiser.minimise(minimum.state.displacement, NOWHERE, tolerance)
        found.append((spent, minimum.decrement, again.decrement))
    assert found[1][0] == found[0][0] - 1
    assert found[1][2] <= found[1][1] <= tolerance


def test_where_energies_are_lost_in_round_off_forces_still_tell_the_last_decrement():
    """Beside an energy of 1e6 no step of this size is seen to lower it; nothing converges for that reason alone."""

    class High(Landscape):
        def at(self, displacement: np.ndarray) -> Point:
            return replace(super().at(displacement), energy=super().at(displacement).energy + 1e6)

    held = High(free=np.array([True, True, False]))
    minimiser = Minimiser(held, 0.5, energy_scale=1.0, options=MinimiserOptions(last_digit=1e-12, no_decrement=1e-30))
    start = np.array([1.0 + 1e-5, 1e-5, 0.0])
    minimum = minimiser.minimise(start, NOWHERE, 1e-18, is_settled=True)
    again = minimiser.minimise(minimum.state.displacement, NOWHERE, 1e-18)
    assert minimum.ending is Ending.CONVERGED
    assert 0 <= again.decrement <= minimum.decrement <= 1e-18
    assert np.abs(minimum.state.displacement - [1, 0, 0]).max() < 1e-8
