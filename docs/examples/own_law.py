"""A hyperelastic law of one's own, as an expression of the deformation gradient: a block between plates, compressed."""

import ngsolve
import pytest
from netgen import occ

from ngcell import Body, BodyScene, BodySupport, CustomLaw, simulate


def energy(gradient):
    """Neo-Hooke: W = mu/2 (I1 / J^(2/3) - 3) + kappa/2 (ln J)^2 with mu = 1, kappa = 1000."""
    jacobian = ngsolve.Det(gradient)
    isochoric = ngsolve.Trace(gradient.trans * gradient) * jacobian ** (-2 / 3) - 3
    return isochoric / 2 + 500 * ngsolve.log(jacobian) ** 2


face = occ.Rectangle(1.0, 1.0).Face()
face.edges.Min(occ.Y).name, face.edges.Max(occ.Y).name = "bottom", "top"
held = BodySupport("bottom", components=(False, True))
moved = BodySupport("top", translation=(0.0, -0.1), components=(False, True))
*_, step = simulate(BodyScene((Body(face, CustomLaw(energy), "block"),), (held, moved), levels=2))
stretch = 0.9  # in plane strain with free sides the nominal stress of an incompressible block is mu (l - l^-3)
assert step.record.plate_force_y == pytest.approx(stretch - stretch**-3, rel=2e-3)
