"""Digits that are cut from places on the way, so that round-off does not choose between branches."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

import ngcell
from ngcell.solve.last_digits import Rounding, without_last_digits
from ngcell.solve.minimise import Minimiser
from ngcell.solve.one_sided import OneSidedModel
from ngcell.solve.stiffness import Stiffness
from ngcell.solve.trials import Trials
from tests.solve.test_minimise import NOWHERE, Landscape

DIGIT = 1e-5


class Diagonal:
    """The matrix of a quadratic, held as its diagonal."""

    def multiply(self, stiffness: Stiffness, vector: np.ndarray) -> np.ndarray:
        return stiffness.values * vector


def rounding(penalty: float, nothing: float) -> Rounding:
    model = OneSidedModel(
        np.zeros(3), Stiffness(np.ones(3)), np.zeros(1), sparse.csr_array(np.eye(1, 3)), np.array([penalty]),
        np.array([True, True, False]),
    )  # fmt: skip
    return Rounding(model, Diagonal(), DIGIT, nothing)


def test_prescribed_values_keep_their_digits_and_so_does_everything_where_steps_have_no_limit():
    place, free = np.array([1.23456789, -1e-7, 0.123456789]), np.array([True, True, False])
    np.testing.assert_allclose(without_last_digits(place, free, DIGIT), [1.23457, 0.0, 0.123456789], rtol=1e-15)
    assert without_last_digits(place, free, np.inf) is place


@pytest.mark.parametrize(("penalty", "is_cut"), [(0.0, True), (1e3, False)])
def test_nothing_is_cut_that_would_cost_more_than_it_may(penalty, is_cut):
    """A place that is 4e-6 off in two unknowns costs 1.6e-11 by the quadratic, and a stiff penalty term 8e-9 more."""
    place = np.array([4e-6, 4e-6, 4e-6])
    found = rounding(penalty, 1e-10).of(place)
    np.testing.assert_array_equal(found, [0.0, 0.0, 4e-6] if is_cut else place)


def test_iterates_are_whole_digits_until_steps_gain_little():
    minimiser = Minimiser(Landscape(free=np.array([True, True, False])), 0.5, energy_scale=1.0)
    digit = minimiser.options.last_digit * 0.5
    first = minimiser.minimise(np.array([2.5, 2.0, 0.7]), NOWHERE, most=3).state.displacement
    assert first[0] != 2.5 and first[1] != 2.0
    np.testing.assert_allclose(first[:2] / digit, np.round(first[:2] / digit), atol=1e-9)
    last = minimiser.minimise(np.array([2.5, 2.0 + 1e-7, 0.7]), NOWHERE).state
    assert last.energy < 1e-17  # the minimum is found to the last digit all the same


def test_round_off_of_a_load_is_enlarged_on_no_way_through_a_tissue_that_comes_apart(monkeypatch):
    """Without rounding it grows ten thousand times and more."""

    def places(shear: float) -> list[np.ndarray]:
        found, after = [], Trials.after

        def noting(trials: Trials, step: np.ndarray) -> tuple:
            trial, gain = after(trials, step)
            if np.isfinite(trials.rounding.digit):
                found.append(trial.displacement)
            return trial, gain

        with monkeypatch.context() as patch:
            patch.setattr(Trials, "after", noting)
            sets = ["tissue.cols=2", "accuracy=0.1", "load.levels=1", f"load.displacement=[{shear!r}, 0.0]"]
            ngcell.simulate(ngcell.read_case("shear-empty-3x3", sets))
        return found

    one, other = places(1.0), places(1.0 + 4 * float(np.finfo(float).eps))
    assert len(one) == len(other) > 40
    assert max(float(np.abs(a - b).max()) for a, b in zip(one, other, strict=True)) < 1e-12
