"""Load paths: both strategies end in the same equilibrium, which does not depend on how it was reached."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from ngcell.problem.problem import Problem
from ngcell.solve.continuation import Continuation
from ngcell.solve.continuation_options import ContinuationOptions
from ngcell.solve.effort import Effort, OutOfIterations
from ngcell.solve.minimum import Ending, Minimum
from ngcell.solve.outcome import Outcome
from ngcell.solve.proximal import ProximalTerm
from ngcell.solve.released import Released
from ngcell.solve.step import MOST_HALVINGS, Accepted, StepFailed
from ngcell.solve.strategies.sddp import Sddp
from ngcell.solve.strategies.single_step import SingleStep
from ngcell.solve.strategies.strategy import Progress, Task
from tests.tissues import LAW, SmallTissue, contact_set, single_step, small_tissue

USUAL = ContinuationOptions()
PATH = Continuation(scale=LAW.shear_modulus, options=USUAL)


def path_with(**numbers: float) -> Continuation:
    """The usual path with other numbers."""
    return replace(PATH, options=replace(USUAL, **numbers))


@cache
def sheared() -> SmallTissue:
    return small_tissue(3, 3, order=2, edges=4, wall=0.2, prescribed_displacement=(0.1, 0.0))


def released(tissue: SmallTissue, path: Continuation = PATH) -> Released:
    apart = tissue.minimiser(Problem(tissue.space, [tissue.bulk], tissue.motion.fixed))
    return Released(apart, (tissue.minimiser(tissue.released),), path)


def by_sddp(tissue: SmallTissue, path: Continuation = PATH, *, steps: int = 1) -> list[Accepted]:
    loads = [step / steps for step in range(1, steps + 1)]
    return list(Sddp().follow(task_of(tissue, path, steps=loads, levels=[1.0]), Progress()))


def task_of(tissue: SmallTissue, path: Continuation = PATH, *, steps: list[float], levels: list[float]) -> Task:
    problems = SimpleNamespace(tied=(tissue.minimiser(tissue.tied),), closing=(), released=released(tissue, path))
    return Task(problems, tissue.motion, steps, levels)


def by_single_step(tissue: SmallTissue, path: Continuation = PATH, *, steps: int = 1) -> list[Accepted]:
    loads = [step / steps for step in range(1, steps + 1)]
    return list(single_step(released(tissue, path), tissue.motion, steps=loads))


@cache
def reference() -> Accepted:
    return by_sddp(sheared())[-1]


def plate_force(tissue: SmallTissue, step: Accepted, plate: str = "high") -> np.ndarray:
    return tissue.motion.resultant(tissue.released.gradient(step.minimum.state), plate)


def assert_same(tissue: SmallTissue, one: Accepted, other: Accepted, tolerance: float = 1e-6) -> None:
    """The same energy, plate force and place of everything, free cells included."""
    assert one.minimum.ending is other.minimum.ending is Ending.CONVERGED
    assert one.minimum.state.energy == pytest.approx(other.minimum.state.energy, rel=tolerance)
    forces = plate_force(tissue, one), plate_force(tissue, other)
    np.testing.assert_allclose(*forces, atol=tolerance * np.linalg.norm(forces[0]) * 10)
    apart = one.minimum.state.displacement - other.minimum.state.displacement
    assert np.abs(apart).max() < tolerance


def test_both_strategies_end_at_the_same_equilibrium():
    assert_same(sheared(), by_single_step(sheared())[-1], reference())


def test_both_strategies_agree_to_the_bit_where_equilibria_are_many():
    tissue = small_tissue(3, 3, order=2, edges=4, wall=0.1, prescribed_displacement=(0.3, 0.0))
    one, other = by_single_step(tissue)[-1], by_sddp(tissue, steps=2)[-1]
    np.testing.assert_array_equal(one.minimum.state.displacement, other.minimum.state.displacement)


@pytest.mark.parametrize("accepted_steps", [by_sddp, by_single_step])
def test_the_result_does_not_depend_on_the_number_of_load_steps(accepted_steps):
    assert_same(sheared(), accepted_steps(sheared(), steps=3)[-1], reference())


@pytest.mark.parametrize("numbers", [{"first": 100.0}, {"narrowest": 0.1}, {"narrowest": 0.25}], ids=str)
def test_the_result_does_not_depend_on_how_finely_the_continuation_path_is_followed(numbers):
    assert_same(sheared(), by_single_step(sheared(), path_with(**numbers))[-1], reference())


def test_what_the_last_proximal_term_holds_is_little_and_shrinks_with_it():
    tissue = sheared()
    weaker = by_single_step(tissue, path_with(last=USUAL.last / 10))[-1]
    minimiser = tissue.minimiser(tissue.released)
    ends = [(step.minimum.state.displacement, step.minimum.proximal) for step in (reference(), weaker)]
    held = [minimiser.proximal_energy(*end) for end in ends]
    assert held[0] < 1e-3 * reference().minimum.state.energy
    assert held[1] < held[0]


def test_the_equilibrium_balances_and_presses_back():
    tissue, step = sheared(), reference()
    state = step.minimum.state
    force = tissue.released.gradient(state)
    proximal = step.minimum.proximal.gradient(state.displacement, tissue.released.metric)
    assert np.abs((force + proximal)[tissue.released.free]).max() < 1e-8
    low, high = (plate_force(tissue, step, name) for name in ("low", "high"))
    assert high[0] > 0
    np.testing.assert_allclose(low, -high, atol=2e-3 * np.linalg.norm(high))
    overlap = -contact_set(tissue.released, state).kinematics.gaps(state.positions).min()
    assert 0 < overlap < 0.05 * tissue.bodies.thickness


def test_tied_states_come_first_and_store_more_energy():
    tied, contact = by_sddp(sheared())
    assert (tied.phase, contact.phase) == ("tied", "released")
    assert tied.load_factor == contact.load_factor == 1.0
    assert tied.minimum.state.energy > 1.5 * contact.minimum.state.energy
    assert tied.effort.iterations > 0 and contact.effort.iterations > 0


def test_levels_are_released_and_the_steps_between_them_are_not():
    tissue = small_tissue(1, 2, edges=1, order=1, prescribed_displacement=(0.02, 0.0))
    accepted_steps = Sddp().follow(task_of(tissue, steps=[0.25, 0.5, 0.75, 1.0], levels=[0.5, 1.0]), Progress())
    assert [(step.phase, step.load_factor) for step in accepted_steps] == [
        ("tied", 0.25),
        ("tied", 0.5),
        ("released", 0.5),
        ("tied", 0.75),
        ("tied", 1.0),
        ("released", 1.0),
    ]


@pytest.mark.parametrize(("first", "last"), [(10.0, 1e-7), (1.0, 1e-3), (5.0, 5.0)])
def test_weights_fall_from_first_to_last(first, last):
    fake = FakeMinimiser(stride=np.inf)
    path = Continuation(3.0, ContinuationOptions(first=first, last=last))
    path.select(path.begin(FakeMinimiser(stride=np.inf), *2 * [np.zeros(1)]).state, (fake,), np.zeros(1))
    weights = np.array(fake.weights)
    assert weights[0] == pytest.approx(3 * first) and weights[-1] == pytest.approx(3 * last)
    decades = -np.diff(np.log10(weights))
    assert (decades >= -1e-12).all() and (decades <= 1 + 1e-9).all()


def test_only_the_last_stretch_is_cut_short_where_it_cycles():
    fake = FakeMinimiser(stride=np.inf)
    path = Continuation(1.0)
    path.select(path.begin(FakeMinimiser(stride=np.inf), *2 * [np.zeros(1)]).state, (fake,), np.zeros(1))
    weights, limits = np.array(fake.weights), np.array(fake.limits)
    assert (limits[weights < USUAL.enough / 2] == USUAL.cycling).all() and (weights < USUAL.enough / 2).any()
    assert (limits[weights > 2 * USUAL.enough] == None).all()  # noqa: E711


@dataclass
class FakeMinimiser:
    """Finds an equilibrium when the load has grown by no more than `stride` since the last one."""

    stride: float
    effort: Effort = field(default_factory=Effort)
    longest_step: float = 1e-3
    energy_scale: float = 1.0
    reached: float = 0.0
    asked: list[float] = field(default_factory=list)
    weights: list[float] = field(default_factory=list)
    limits: list[int | None] = field(default_factory=list)

    problem = SimpleNamespace(
        has_multipliers=False,
        dimension=3,
        free=np.ones(1, dtype=bool),
        expand=lambda displacement: displacement,
        update_multipliers=lambda state: (0.0, 0.0),
        take_finer_rule=lambda state: False,
        start_from=lambda before, state: None,
        apply=lambda load_factor: None,
        has_history=False,
        overlap=lambda state: 0.0,
        part=np.zeros(1, dtype=np.int64),
        at=lambda displacement: None,
        magnitude=lambda state: abs(state.energy),
        couplings=lambda state, margin: (np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64)),
    )
    is_iterative = True

    def rounded(self, place: np.ndarray) -> np.ndarray:
        return place

    def minimise(
        self,
        start: np.ndarray,
        proximal: ProximalTerm,
        tolerance: float = 0.0,
        most: int | None = None,
        lowest: float = -np.inf,
        *,
        is_settled: bool = False,
    ) -> Minimum:
        goal = float(start[0])
        self.asked.append(goal)
        self.weights.append(proximal.weight)
        self.limits.append(most)
        self.effort.iterations += 1
        found = goal - self.reached <= self.stride + 1e-12
        self.reached = goal if found else self.reached
        ending = Ending.CONVERGED if found else Ending.NO_DESCENT
        return Minimum(SimpleNamespace(displacement=start, energy=0.0), ending, 0.0, proximal)

    def total(self, state: object, proximal: ProximalTerm) -> float:
        return 0.0

    def forget_matrix(self) -> None:
        pass

    def make_matrix(self, displacement: np.ndarray) -> None:
        pass

    def adopt_matrix(self, other: object) -> None:
        pass

    def foresee(self, displacement: np.ndarray, imposed: np.ndarray, weight: float) -> np.ndarray:
        return imposed

    def proximal_energy(self, displacement: np.ndarray, proximal: ProximalTerm) -> float:
        return 0.0


@dataclass(frozen=True)
class FakeMotion:
    """The displacement is the load factor."""

    has_lifting: bool = True

    def imposed(self, displacement: np.ndarray, load_factor: float) -> np.ndarray:
        return np.array([load_factor])

    def lifting(self, load_factor: float) -> np.ndarray:
        return np.array([load_factor])


def tied_steps(fake: FakeMinimiser) -> Iterator[Accepted]:
    released = SimpleNamespace(longest_step=1.0, path=SimpleNamespace(scale=1.0))
    problems = SimpleNamespace(tied=(fake,), closing=(), released=released)
    return Sddp().follow(Task(problems, FakeMotion(), [0.5, 1.0], []), Progress())


def incremental_steps(fake: FakeMinimiser) -> Iterator[Accepted]:
    apart = FakeMinimiser(stride=np.inf)
    path = Released(apart, (fake,), Continuation(1.0, ContinuationOptions(first=1.0, last=1.0)))
    return single_step(path, FakeMotion(has_lifting=False), steps=[0.5, 1.0])


@pytest.mark.parametrize(
    ("accepted_steps", "outcome"),
    [(tied_steps, Outcome.TIED_FAILED), (incremental_steps, Outcome.RELEASE_FAILED)],
)
class TestHalving:
    """Both follows meet a step that is too long in the same way."""

    def test_a_step_that_fails_is_halved_until_it_succeeds(
        self, accepted_steps: Callable[[FakeMinimiser], Iterator[Accepted]], outcome: Outcome
    ):
        fake = FakeMinimiser(stride=0.13)
        steps = list(accepted_steps(fake))
        assert [step.load_factor for step in steps] == [0.5, 1.0]
        assert fake.asked[:3] == [0.5, 0.25, 0.125]
        assert [step.minimum.state.displacement[0] for step in steps] == [0.5, 1.0]
        assert sum(step.effort.iterations for step in steps) >= len(fake.asked)  # failures are counted

    def test_a_step_that_fails_however_short_is_given_up_by_name(
        self, accepted_steps: Callable[[FakeMinimiser], Iterator[Accepted]], outcome: Outcome
    ):
        fake = FakeMinimiser(stride=0.5)
        path = accepted_steps(fake)
        assert next(path).load_factor == 0.5
        fake.stride = 0.0
        fake.asked.clear()
        with pytest.raises(StepFailed) as failure:
            next(path)
        assert failure.value.outcome is outcome
        assert fake.asked == [0.5 + 0.5 * 0.5**halving for halving in range(MOST_HALVINGS + 1)]
        assert failure.value.load_factor == fake.asked[-1]


def test_walls_that_no_path_from_the_lifting_frees_are_released_from_the_tied_state():
    tied, asked = np.array([3.0]), []

    def step(start: np.ndarray, centre: np.ndarray, load: float) -> Accepted:
        asked.append((float(start[0]), float(centre[0]), load))
        released.effort = released.effort + Effort(iterations=3)
        if centre[0] != tied[0]:
            raise StepFailed(Outcome.RELEASE_FAILED, load)
        state = SimpleNamespace(displacement=start, energy=0.0)
        minimum = Minimum(state, Ending.CONVERGED, 0.0, ProximalTerm(0, centre))
        return Accepted("released", load, minimum, Effort())

    fake = FakeMinimiser(stride=1.0)
    problem = SimpleNamespace(reset=lambda: None, has_history=False)
    released = SimpleNamespace(step=step, problem=problem, effort=Effort())
    problems = SimpleNamespace(tied=(fake,), closing=(), released=released, renew_budget=lambda: None)
    progress = Progress(accepted=1, load_factor=1.0, displacement={"tied": tied})
    (last,) = Sddp().follow(Task(problems, FakeMotion(), [1.0], [1.0]), progress)
    assert asked == [(3.0, 1.0, 1.0), (3.0, 3.0, 1.0)]
    assert last.minimum.state.displacement == tied and last.effort.iterations == 6


@pytest.mark.parametrize("helps", [True, False])
def test_where_bodies_are_left_deep_in_each_other_the_load_is_followed_in_half_as_long_increments(helps):
    asked = []

    def step(start: np.ndarray, centre: np.ndarray, load: float, **_: bool) -> Accepted:
        asked.append(load)
        if len(asked) > 1 and not helps and load < 1:
            raise StepFailed(Outcome.RELEASE_FAILED, load)
        state = SimpleNamespace(displacement=start, deep=0.09 if asked[-1] == 1 and 0.5 not in asked[-2:] else 0.0)
        return Accepted("released", load, Minimum(state, Ending.CONVERGED, 0.0, ProximalTerm(0, centre)), Effort())

    released = SimpleNamespace(
        step=step,
        problem=SimpleNamespace(has_history=False, overlap=lambda state: state.deep),
        pieces=lambda displacement, imposed: 1,
        predict=lambda displacement, imposed: imposed,
        effort=Effort(),
        apart=SimpleNamespace(effort=Effort()),
        forget_matrices=lambda: None,
    )
    motion = SimpleNamespace(
        has_lifting=False, lifting=lambda load: np.zeros(1), imposed=lambda displacement, load: np.array([load])
    )
    renewed = []
    problems = SimpleNamespace(released=released, renew_budget=lambda: renewed.append(len(asked)))
    (only,) = SingleStep().follow(Task(problems, motion, [1.0], [1.0]), Progress())
    assert only.load_factor == 1 and asked[:2] == [1.0, 0.5] and bool(renewed) != helps
    assert only.minimum.state.deep == (0.0 if helps else 0.09)
    assert asked == [1.0, 0.5, 1.0] if helps else (asked[-1] == 1.0 and len(asked) == MOST_HALVINGS + 3)


@pytest.mark.parametrize("is_long", [False, True])
def test_where_no_path_leads_from_the_lifting_the_load_is_followed_from_the_step_before(is_long, monkeypatch):
    """None does either where it takes more work than a step may; what follows has a budget of its own."""
    fake, renewed = FakeMinimiser(stride=0.13), []
    path = Released(FakeMinimiser(np.inf), (fake,), Continuation(1.0, ContinuationOptions(first=1.0, last=1.0)))
    step = Released.step

    def too_long(path: Released, start: np.ndarray, centre: np.ndarray, load: float, **how: bool) -> Accepted:
        if not how:
            raise OutOfIterations
        return step(path, start, centre, load, **how)

    if is_long:
        monkeypatch.setattr(Released, "step", too_long)
    problems = SimpleNamespace(released=path, renew_budget=lambda: renewed.append(1))
    task = Task(problems, FakeMotion(), [0.5, 1.0], [1.0])
    steps = list(SingleStep().follow(task, Progress()))
    assert [step.load_factor for step in steps] == [0.5, 1.0] and all(step.follows for step in steps)
    assert sum(step.effort.iterations for step in steps) == path.effort.iterations
    assert len(renewed) == 2
