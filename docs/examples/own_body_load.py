"""A load of one's own: a lift of given total force, however long the boundary that it acts on; the support bears it."""

import ngsolve
import pytest
from netgen import occ

from ngcell import Body, BodyScene, BodySupport, MooneyRivlin, simulate


class Lift:
    boundary, body, pressure, force = "top", None, 0.0, 0.02

    def check(self, dimension):
        assert dimension == 2

    def region(self, space):
        return ngsolve.ds(definedon=space.mesh.Boundaries(self.boundary))

    def density(self, space, displacement, swept):
        return -self.force / ngsolve.Integrate(ngsolve.CF(1) * self.region(space), space.mesh) * displacement[1]


face = occ.Rectangle(3, 1).Face()
face.edges.Min(occ.Y).name, face.edges.Max(occ.Y).name = "floor", "top"
block = Body(face, MooneyRivlin(c1=1.0, c2=1.0, bulk_modulus=100.0), "block")
floor = BodySupport("floor", translation=(0.1, 0.0))  # moved to the right, which takes no force
*_, last = simulate(BodyScene([block], [floor], loads=[Lift()], levels=1))
assert last.record.plate_force_y == pytest.approx(-Lift.force, rel=1e-6)
