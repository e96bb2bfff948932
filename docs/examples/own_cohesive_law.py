"""A cohesive law of one's own, ``T = k d exp(-(d/p)^2)``: to pull two blocks apart takes its whole work, k p^2 / 2."""

import numpy as np
import pytest
from netgen import occ

from ngcell import Body, BodyScene, BodySupport, MooneyRivlin, simulate


class Gaussian:
    k, p = 2.0, 0.02
    stiffness_at_rest, peak = k, p / np.sqrt(2)
    traction = lambda self, d: d * self.secant(d)  # noqa: E731
    secant = lambda self, d: self.k * np.exp(-((d / self.p) ** 2))  # noqa: E731
    secant_slope = lambda self, d: -2 * d / self.p**2 * self.secant(d)  # noqa: E731
    work = lambda self, d: (self.k - self.secant(d)) * self.p**2 / 2  # noqa: E731


lower, upper = (occ.MoveTo(0, low).Rectangle(1.0, 0.5).Face() for low in (0.0, 0.5))
lower.edges.Min(occ.Y).name, upper.edges.Max(occ.Y).name = "floor", "roof"
rubber = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=10.0)
bodies = (Body(lower, rubber, "lower"), Body(upper, rubber, "upper"))
supports = (BodySupport("floor"), BodySupport("roof", translation=(0.0, 0.1)))
*_, last = simulate(BodyScene(bodies, supports, size=0.5, order=1, levels=8, cohesion=Gaussian()))
assert last.record.separation_energy == pytest.approx(Gaussian.k * Gaussian.p**2 / 2, rel=1e-6)  # on a length of 1
