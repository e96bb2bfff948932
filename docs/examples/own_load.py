"""A load of one's own: all outer walls turn by 30 degrees; a rigid rotation stores no energy and opens no gap."""

import numpy as np
import pytest

from ngcell import Case, MeshChoice, MooneyRivlin, PrescribedMotion, Support, Tissue, simulate


class Turn:
    supported, moved, level_factors, angle = "frame", "frame", (1.0,), np.radians(30)

    def motion(self, space):
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        gradient = np.array([[cos - 1, -sin], [sin, cos - 1]])
        return PrescribedMotion(space, [Support("frame", gradient, np.zeros(2))], lambda at: gradient @ at)

    def prescribed_displacement(self, space):
        return np.zeros(2)

    def tractions(self):
        return ()


rubber, cells = MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0), Tissue(rows=2, cols=2, wall=0.1)
*_, last = simulate(Case(tissue=cells, material=rubber, load=Turn(), mesh=MeshChoice(order=2)))
assert last.record.energy == pytest.approx(0, abs=1e-12) and last.record.largest_gap < 1e-9
