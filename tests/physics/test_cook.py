"""M5, Cook's membrane at finite strain: what fills lumens, nearly incompressible, bends without locking."""

from __future__ import annotations

import ngsolve
import numpy as np
from netgen.meshing import Mesh

from ngcell.geometry.bodies import FILLING, BodyMesh
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.inclusion import InclusionEnergy
from ngcell.mechanics.laws.mooney_rivlin import MooneyRivlin
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion, Support
from ngcell.problem.problem import Problem
from ngcell.scene import Traction
from ngcell.solve.minimise import Minimiser
from ngcell.solve.minimum import Ending
from ngcell.solve.proximal import ProximalTerm

MU, FORCE = 80.1938, 100.0
#: Exponent by which elements get smaller towards the corner where the stress is singular.
GRADING = 1.5
#: Displacement of the upper right corner at kappa / mu = 5000, in plane strain.
PUBLISHED = np.array([-5.838, 6.935])


def membrane(count: int) -> BodyMesh:
    """Quadrilaterals, `count` along each side and finer towards the clamp's upper end, as what fills a lumen."""
    share = np.linspace(0, 1, count + 1)
    s, t = (grid.ravel() for grid in np.meshgrid(share**GRADING, 1 - (1 - share) ** GRADING, indexing="ij"))
    points = np.column_stack([48 * s, 44 * s * (1 - t) + (44 + 16 * s) * t])
    node = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    quads = np.stack([node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]], axis=-1).reshape(-1, 4)
    mesh = Mesh()
    mesh.dim = 2
    mesh.AddPoints(np.ascontiguousarray(points))
    region = mesh.AddRegion(FILLING, dim=2)
    mesh.AddElements(dim=2, index=region, data=quads.astype(np.int32), base=0)
    for name, side in (("clamped", node[0, ::-1]), ("pulled", node[-1])):
        edges = np.column_stack([side[:-1], side[1:]]).astype(np.int32)
        mesh.AddElements(dim=1, index=mesh.AddRegion(name, dim=1), data=np.ascontiguousarray(edges), base=0)
    return BodyMesh(
        mesh=ngsolve.Mesh(mesh),
        body_of_element=np.zeros(len(quads), dtype=np.int64),
        body_names=("membrane",),
        wall_names="none",
        length=48.0,
        thickness=16.0,
        is_filling=np.ones(len(quads), dtype=bool),
    )


def corner(count: int, order: int, ratio: float) -> tuple[np.ndarray, int]:
    """Displacement of the upper right corner, and the number of unknowns."""
    space = DisplacementSpace(membrane(count), order)
    motion = PrescribedMotion(space, [Support("clamped", np.zeros((2, 2)), np.zeros(2))])
    law = MooneyRivlin(c1=MU, c2=0.0, bulk_modulus=ratio * MU)
    loads = AppliedLoads(space, [Traction(boundary="pulled", vector=(0.0, FORCE / 16))], motion)
    problem = Problem(space, [InclusionEnergy(space, law), loads], motion.fixed)
    minimiser = Minimiser(problem, np.inf, energy_scale=MU * 48 * 30)
    state = np.zeros(space.unknowns)
    for load in np.linspace(0.25, 1.0, 4):
        loads.apply(load)
        minimum = minimiser.minimise(state, ProximalTerm(0.0, state))
        assert minimum.ending is Ending.CONVERGED
        state = minimum.state.displacement
    return state.reshape(2, -1)[:, (count + 1) ** 2 - 1], space.unknowns


def test_the_corner_moves_as_published():
    moved, unknowns = corner(12, 3, 5000.0)
    assert unknowns <= 5000
    np.testing.assert_allclose(moved, PUBLISHED, rtol=5e-3)


def test_a_coarse_mesh_is_as_good_however_incompressible():
    """A mesh that locks is the stiffer the less compressible; here the error of 4 x 4 elements stays what it is."""
    errors = [corner(4, 2, ratio)[0][1] / corner(8, 2, ratio)[0][1] - 1 for ratio in (50.0, 5000.0, 1e5)]
    assert np.abs(errors).max() < 0.015
    assert np.ptp(errors) < 2e-3


def test_the_limit_is_that_of_an_incompressible_membrane():
    nearly, more = (corner(4, 3, ratio)[0] for ratio in (5000.0, 1e5))
    np.testing.assert_allclose(more, nearly, rtol=1e-3)
