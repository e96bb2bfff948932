"""A contact law of one's own, a cubic energy of the overlap: blocks press on each other as hard as the plates bear."""

import numpy as np
import pytest
from netgen import occ

from ngcell import Body, BodyScene, BodySupport, MooneyRivlin, NormalLaw, simulate


def cubic(gap, stiffness, depth=1e-3):
    """Energy, slope and second derivative of ``k |g|^3 / (3 d)`` in overlaps: as stiff as a penalty at half of d."""
    overlap = np.maximum(-gap, 0)
    return stiffness * overlap**3 / (3 * depth), -stiffness * overlap**2 / depth, 2 * stiffness * overlap / depth


lower, upper = (occ.MoveTo(0, low).Rectangle(1.0, 0.5).Face() for low in (0.0, 0.5))
lower.edges.Min(occ.Y).name, upper.edges.Max(occ.Y).name = "floor", "roof"
rubber = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=1000.0)
bodies = (Body(lower, rubber, "lower"), Body(upper, rubber, "upper"))
slides = {"components": (False, True)}
supports = (BodySupport("floor", **slides), BodySupport("roof", translation=(0.0, -0.1), **slides))
*_, last = simulate(BodyScene(bodies, supports, size=0.25, levels=2, contact=NormalLaw(cubic)))
assert last.record.contact_force == pytest.approx(-last.record.plate_force_y, rel=1e-6)  # balance of a cut
assert last.record.plate_force_y == pytest.approx(0.9 - 0.9**-3, rel=2e-2)  # one block; the overlap is softer
