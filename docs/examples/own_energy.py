"""An energy of one's own: a block on an elastic foundation bears what two elastic layers on each other would."""

import ngsolve
import pytest
from netgen import occ

from ngcell import Body, BodyScene, BodySupport, MooneyRivlin, OwnEnergy, simulate

FOUNDATION, SMALL = 3.0, 1e-5


def foundation(displacement, mesh):
    return FOUNDATION / 2 * displacement[1] ** 2 * ngsolve.ds(definedon=mesh.Boundaries("floor"))


face = occ.Rectangle(1.0, 1.0).Face()
face.edges.Min(occ.Y).name, face.edges.Max(occ.Y).name = "floor", "roof"
rubber = MooneyRivlin(c1=0.5, c2=0.5, bulk_modulus=100.0)
roof = BodySupport("roof", translation=(0.0, -SMALL), components=(False, True))
scene = BodyScene((Body(face, rubber, "block"),), (roof,), levels=1)
*_, last = simulate(scene, terms=[lambda space: OwnEnergy(space, foundation)])
block = rubber.plane_strain_modulus  # stiffness of a unit square in plane strain at small strain
assert last.record.plate_force_y == pytest.approx(-SMALL / (1 / FOUNDATION + 1 / block), rel=1e-4)
