"""Laws of traction over opening: their energies, slopes, and bonds that follow a law of a script."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import quad

from ngcell.contact.cohesion.bonds import bond_walls
from ngcell.contact.cohesion.exponential import Cohesion
from ngcell.contact.cohesion.law import CohesiveLaw
from ngcell.contact.methods.terms import CohesionTerm, ContactTerm
from ngcell.problem.problem import Problem
from tests.contact.derivatives import assert_derivatives, smooth_step
from tests.tissues import small_tissue


@dataclass(frozen=True)
class Bilinear:
    """Traction that rises linearly to `strength` at `peak` and falls linearly to nothing at `end`."""

    strength: float
    peak: float
    end: float

    @property
    def stiffness_at_rest(self) -> float:
        return self.strength / self.peak

    def traction(self, opening):
        falling = self.strength * (self.end - opening) / (self.end - self.peak)
        return np.where(opening < self.peak, self.stiffness_at_rest * opening, np.maximum(falling, 0))

    def secant(self, opening):
        rising = opening < self.peak
        return np.where(rising, self.stiffness_at_rest, self.traction(opening) / np.where(rising, 1, opening))

    def secant_slope(self, opening):
        falls = (opening > self.peak) & (opening < self.end)
        slope = -self.strength * self.end / (self.end - self.peak)
        return np.where(falls, slope / np.where(falls, opening, 1) ** 2, 0.0)

    def work(self, opening):
        left = self.strength * np.maximum(self.end - opening, 0) ** 2 / (self.end - self.peak) / 2
        risen = self.stiffness_at_rest * opening**2 / 2
        return np.where(opening < self.peak, risen, self.strength * self.end / 2 - left)


LAWS = {"exponential": Cohesion(strength=0.3, energy=0.02), "bilinear": Bilinear(0.3, 0.01, 0.09)}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_secant_slope_and_work_belong_to_the_traction(law):
    assert isinstance(law, CohesiveLaw)
    openings = law.peak * np.array([0.3, 0.8, 1.7, 5.0])
    step = 1e-6 * law.peak
    np.testing.assert_allclose(law.secant(openings) * openings, law.traction(openings), rtol=1e-12)
    difference = (law.secant(openings + step) - law.secant(openings - step)) / (2 * step)
    np.testing.assert_allclose(law.secant_slope(openings), difference, rtol=1e-6, atol=1e-6)
    for opening in openings:
        work, _ = quad(lambda at: float(law.traction(np.array(at))), 0, opening, points=[min(opening, law.peak)])
        assert float(law.work(np.array(opening))) == pytest.approx(work, rel=1e-9)
    assert float(law.secant(np.array(0.0))) == pytest.approx(law.stiffness_at_rest, rel=1e-12)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("opening", [0.004, 0.04], ids=["before the peak", "behind it"])
@pytest.mark.parametrize("before", [0.0, 2.0], ids=["loading", "unloading"])
def test_forces_and_tangent_are_derivatives_of_one_energy(law, opening, before):
    tissue = small_tissue(1, 2)
    bonds = bond_walls(tissue.walls, law)
    terms = [tissue.bulk, ContactTerm(tissue.contact), CohesionTerm(bonds)]
    problem = Problem(tissue.space, terms, tissue.motion.fixed)
    at = tissue.smooth(0.001, 3) + tissue.body_translation(1, np.array([opening, 0.3 * opening]))
    bonds.largest = before * bonds.openings(tissue.positions(at))
    way = tissue.smooth(1.0, 8)
    assert_derivatives(problem, at, way, smooth_step(problem, bonds, at, way), rel=2e-7)


def test_parting_costs_the_energy_of_the_law():
    tissue, law = small_tissue(1, 2), LAWS["bilinear"]
    bonds = bond_walls(tissue.walls, law)
    apart = tissue.positions(tissue.body_translation(1, np.array([2 * law.end, 0.0])))
    bonds.advance(apart)
    assert bonds.energy(apart) == pytest.approx(0.3 * 0.09 / 2, rel=1e-12)
    assert bonds.stored(apart) == 0
    assert bonds.broken(apart).all()
