"""The quadratic with one-sided penalty terms, against brute force and cases worked by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize, sparse

from ngcell.solve.growing import GrowingMatrix
from ngcell.solve.inner import _Quadratics, _root_of_slope, minimise_one_sided
from ngcell.solve.one_sided import OneSidedModel
from ngcell.solve.options import InnerOptions
from ngcell.solve.stiffness import Stiffness


def random_model(
    seed: int, stiff: float, unknowns: int = 8, penalty_terms: int = 6
) -> tuple[OneSidedModel, GrowingMatrix]:
    random = np.random.default_rng(seed)
    root = random.standard_normal((unknowns, unknowns))
    full = root @ root.T + 0.1 * np.eye(unknowns)
    rows, columns = np.tril_indices(unknowns)
    free = np.ones(unknowns, dtype=bool)
    free[-1] = False
    gradient = np.where(free, random.standard_normal(unknowns), 0.0)
    jacobian = sparse.csr_array(random.standard_normal((penalty_terms, unknowns)))
    gap, penalty = random.uniform(-0.1, 0.3, penalty_terms), stiff * random.uniform(0.5, 2, penalty_terms)
    model = OneSidedModel(gradient, Stiffness(full[rows, columns]), gap, jacobian, penalty, free)
    return model, GrowingMatrix(unknowns, free, rows, columns)


def model_at(model: OneSidedModel, step: np.ndarray) -> float:
    """The model's value, spelled out."""
    size = len(step)
    full = np.zeros((size, size))
    full[np.tril_indices(size)] = model.stiffness.values
    full += np.tril(full, -1).T
    overlap = np.minimum(model.gap + model.jacobian @ step, 0)
    return float(model.gradient @ step + step @ full @ step / 2 + (model.penalty * overlap**2).sum() / 2)


@pytest.mark.parametrize("stiff", [1.0, 1e3])
@pytest.mark.parametrize("seed", range(8))
def test_the_step_is_nearly_the_minimum_found_by_brute_force(seed, stiff):
    model, matrix = random_model(seed, stiff)
    found = minimise_one_sided(model, matrix, InnerOptions(worthwhile_gain=0.02))
    step, change, rounds = found.step, found.change, found.factorisations

    def value(free: np.ndarray) -> float:
        return model_at(model, np.append(free, 0.0))

    best = min(
        (optimize.minimize(value, step[:-1] + damping, method="BFGS", options={"gtol": 1e-9}).fun)
        for damping in (0, 0.3, -0.3)
    ) - value(np.zeros(7))
    assert step[-1] == 0
    assert change == pytest.approx(model_at(model, step) - model_at(model, np.zeros(8)), rel=1e-9)
    assert best * (1 + 1e-6) <= change <= 0.95 * best < 0
    assert 1 <= rounds <= 8


def test_without_penalty_terms_the_step_is_newtons():
    model, matrix = random_model(3, 1.0, penalty_terms=0)
    found = minimise_one_sided(model, matrix, InnerOptions())
    step, change, rounds = found.step, found.change, found.factorisations
    np.testing.assert_allclose(matrix.multiply(model.stiffness, step)[:-1], -model.gradient[:-1], atol=1e-10)
    assert change == pytest.approx(model.gradient @ step / 2, rel=1e-9)
    assert rounds == 1


def test_penalty_terms_that_the_newton_step_would_close_are_foreseen():
    """One unknown pulled by 1 towards a stop at 0.1: Newton without the stop would go to 1."""
    free = np.ones(1, dtype=bool)
    matrix = GrowingMatrix(1, free, np.array([0]), np.array([0]))
    jacobian = sparse.csr_array(np.array([[-1.0]]))
    model = OneSidedModel(np.array([-1.0]), Stiffness(np.ones(1)), np.array([0.1]), jacobian, np.array([99.0]), free)
    found = minimise_one_sided(model, matrix, InnerOptions())
    step, change = found.step, found.change
    assert step[0] == pytest.approx((1 + 9.9) / 100, rel=1e-12)
    assert model.full_gradient[0] == -1.0
    assert change == pytest.approx(model_at(model, step), rel=1e-12)


def test_a_round_that_goes_up_is_told_with_what_was_gained_before():
    """A stop that presses holds what is unstable; the step opens it, and from there on the model falls without end."""
    free = np.ones(1, dtype=bool)
    matrix = GrowingMatrix(1, free, np.array([0]), np.array([0]))
    jacobian = sparse.csr_array(np.array([[1.0]]))
    model = OneSidedModel(np.array([-0.5]), Stiffness(-np.ones(1)), np.array([-0.1]), jacobian, np.array([3.0]), free)
    uphill = minimise_one_sided(model, matrix, InnerOptions()).uphill
    assert uphill is not None and not uphill.closed.any()
    assert uphill.step[0] == pytest.approx(0.4, rel=1e-12)  # where the minimum would be, were the stop still closed
    assert uphill.change == pytest.approx(model_at(model, uphill.step) - model_at(model, np.zeros(1)), rel=1e-12)
    assert float(uphill.product(model, matrix) @ uphill.way) == pytest.approx(-float(uphill.way @ uphill.way))
    held = replace(model, penalty=np.array([30.0]), gradient=np.array([0.5]))
    assert minimise_one_sided(held, matrix, InnerOptions()).uphill is None
    falling = minimise_one_sided(replace(model, gap=np.ones(1)), matrix, InnerOptions())
    assert falling.change > 0 and falling.uphill is not None and falling.uphill.change == 0


def test_the_gradient_at_rest_counts_closed_penalty_terms_only_and_no_held_unknown():
    model, _ = random_model(4, 10.0)
    size = 1e-6
    ways = size * np.eye(8)
    slope = [(model_at(model, way) - model_at(model, -way)) / (2 * size) for way in ways]
    np.testing.assert_allclose(model.full_gradient[:-1], slope[:-1], atol=1e-8)
    assert model.full_gradient[-1] == 0


def root(constant: float, linear: float, *penalty_terms: tuple[float, float, float]) -> float:
    penalty, gap, moved = np.array(penalty_terms, dtype=float).reshape(-1, 3).T
    return _root_of_slope(constant, linear, penalty, gap, moved)


@pytest.mark.parametrize(
    ("case", "expected"),
    [
        ((-1.0, 2.0), 0.5),  # a parabola
        ((-3.0, 2.0), 1.0),  # whose minimum lies beyond the end
        ((-1e-12, 1.0), 1e-12),  # or hardly beyond the start
        ((-1.0, -1.0), 1.0),  # a hill: downhill all the way
        ((-1.0, 1.0, (99.0, 0.1, -1.0)), 10.9 / 100),  # a penalty term closes at 0.1
        ((-1.0, 1.0, (99.0, 0.0, -1.0)), 0.01),  # it touches from the start
        ((-1.0, 1.0, (99.0, 1e-14, -1.0)), 0.01),  # nearly
        ((-1.0, 1.0, (99.0, 2.0, -1.0)), 1.0),  # it is out of reach
        ((-1.0, 1.0, (99.0, 0.1, 1.0)), 1.0),  # it moves away
        ((-1.0, 3.0, (4.0, -0.25, 0.5)), 1.5 / 4),  # closed, it still presses where the slope vanishes
        ((-1.0, 2.0, (1.0, -0.1, 1.0)), 0.5),  # it presses until 0.1, and is loose at the root
        ((-1.0, -1.0, (99.0, 0.1, -1.0)), 10.9 / 98),  # a hill that a penalty term stops
        ((-1.0, 0.0, (10.0, 0.2, -1.0), (10.0, 0.3, -1.0)), 0.3),  # two penalty terms, met at the second's start
        ((-1.0, 0.0, (10.0, 0.2, -1.0), (90.0, 0.25, -1.0)), 0.255),  # both press at the root
    ],
)
def test_roots_of_slopes_worked_by_hand(case, expected):
    assert root(*case) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_the_root_is_the_first_minimum_along_the_way(seed):
    random = np.random.default_rng(seed)
    count = 5
    penalty, gap = random.uniform(0, 20, count), random.uniform(-0.3, 0.5, count)
    moved = random.standard_normal(count)
    linear = random.uniform(-1, 1)
    constant = -1.0 - max(0.0, float((penalty * np.minimum(gap, 0) * moved).sum()))
    found = _root_of_slope(constant, linear, penalty, gap, moved)
    way = np.linspace(0, 1, 20001)
    overlap = np.minimum(gap + way[:, None] * moved, 0)
    value = constant * way + linear / 2 * way**2 + (penalty * overlap**2).sum(1) / 2
    rising = np.flatnonzero(np.diff(value) > 0)
    expected = way[rising[0]] if len(rising) else 1.0
    assert found == pytest.approx(expected, abs=2e-4)


def test_the_change_of_a_tiny_step_is_not_drowned_by_the_overlap():
    """Near the minimum the sign of the change decides whether a step is taken."""
    free, rest = np.ones(1, dtype=bool), 2.0**-30
    matrix = GrowingMatrix(1, free, np.array([0]), np.array([0]))
    # A penalty term of 1000, closed by 1, in balance with a load of 1000 but for `rest`.
    model = OneSidedModel(
        np.array([1000 - rest]),
        Stiffness(np.ones(1)),
        np.array([-1.0]),
        sparse.csr_array(np.array([[1.0]])),
        np.array([1000.0]),
        free,
    )
    found = minimise_one_sided(model, matrix, InnerOptions())
    step, change = found.step, found.change
    assert step[0] == pytest.approx(rest / 1001, rel=1e-3, abs=0)
    assert change == pytest.approx(-(rest**2) / 2002, rel=1e-3, abs=0)


@pytest.mark.parametrize("few", [0, 1, 2, 6])
def test_minima_with_other_penalty_terms_are_the_same_whether_factorised_or_corrected(few, monkeypatch):
    """Penalty terms close and open in turn; whatever is factorised anew, each minimum is that of its own quadratic."""
    monkeypatch.setattr(GrowingMatrix, "few", few)
    model, matrix = random_model(5, 1e3)
    quadratics = _Quadratics(model, matrix, InnerOptions().lost)
    sets = [[0, 1], [0, 1, 2], [0, 1], [1, 2], [], [3, 4, 5], [0, 3, 4, 5]]
    for closed in (np.array(numbers, dtype=np.int64) for numbers in sets):
        alone = replace(model, gap=model.gap[closed], jacobian=model.jacobian[closed], penalty=model.penalty[closed])
        minimum = quadratics.minimum(closed, model.gap)
        pulled = alone.pulled(alone.penalty * (alone.gap + alone.jacobian @ minimum))
        force = matrix.multiply(model.stiffness, minimum) + model.gradient + pulled
        np.testing.assert_allclose(force[model.free], 0, atol=1e-9)
        assert minimum[-1] == 0
    assert quadratics.factorisations == {0: 7, 1: 4, 2: 2, 6: 1}[few]


def test_a_penalty_term_that_alone_held_a_body_is_not_opened_by_a_correction(monkeypatch):
    """One unknown on a penalty term 1e9 times as stiff as what else holds it: corrected, half the digits would go."""
    monkeypatch.setattr(GrowingMatrix, "few", 1)
    free, zero = np.ones(1, dtype=bool), np.zeros(1, dtype=np.int64)
    matrix = GrowingMatrix(1, free, zero, zero)
    jacobian = sparse.csr_array(np.array([[-1.0]]))
    pull, soft, stiff = np.array([-0.3]), Stiffness(np.array([1 / 3])), np.array([1e9])
    model = OneSidedModel(pull, soft, np.array([-0.1]), jacobian, stiff, free)
    quadratics = _Quadratics(model, matrix, InnerOptions().lost)
    quadratics.minimum(zero, model.gap)
    assert quadratics.minimum(zero[:0], model.gap)[0] == pytest.approx(0.9, rel=1e-14)
    assert quadratics.factorisations == 2


@pytest.mark.parametrize(("misfit", "gain"), [(np.inf, 0.3), (np.nan, 0.3), (0.5, 0.3), (0.1, 0.1), (1e-4, 0.01)])
def test_rounds_of_a_settled_model_are_worth_what_the_one_before_was_off_by(misfit: float, gain: float):
    assert InnerOptions().within(misfit).worthwhile_gain == gain


def test_among_many_bodies_a_settled_model_is_minimised_no_less_far_than_any():
    """Their share of what is worth while may be below the least of settled models."""
    assert InnerOptions(worthwhile_gain=0.002).within(1e-4).worthwhile_gain == 0.002
