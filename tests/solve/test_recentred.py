"""The proximal point method on a bowl whose minimum is known: how many centres it takes, and where it ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending
from ngcell.solve.options import ContinuationOptions
from ngcell.solve.recentred import recentred
from tests.solve.test_minimise import Landscape, Model, Point

#: Weight of the proximal term, and that beside which the bowl is soft.
WEIGHT, FAR = 1.0, 0.4


@dataclass
class Bowl(Landscape):
    """Soft along x, with its bottom at `FAR`: ``curvature (x - FAR)^2 / 2 - 1``; what presses on it is a unit force."""

    curvature: float = 0.1
    stored: float = 0.0

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
