"""K6: cells under pressure that nothing holds round off, and no cut through the cluster has a force."""

from __future__ import annotations

from itertools import chain, combinations

import numpy as np
import pytest

from ngcell.contact.methods.terms import ContactTerm
from ngcell.geometry.lattice import hexagonal_lattice
from ngcell.geometry.sections import ring_mesh
from ngcell.mechanics.applied.potential import AppliedLoads
from ngcell.mechanics.space import DisplacementSpace
from ngcell.mechanics.supports import PrescribedMotion
from ngcell.mechanics.symbolic_sum import fused
from ngcell.problem.problem import Problem
from ngcell.results.forces import contact_forces
from ngcell.scene import Pressure
from ngcell.solve.continuation import Continuation
from ngcell.solve.released import Released
from tests.tissues import LAW, SmallTissue, contact_set, single_step

PRESSURE = 0.05


def free_cluster(rows: int, cols: int) -> SmallTissue:
    lattice = hexagonal_lattice(rows, cols, side=1.0, pointy=True)
    bodies = ring_mesh(lattice.outlines, wall=0.2, radius=0.0, edges=3, layers=1, supports={})
    space = DisplacementSpace(bodies, 2)
    return SmallTissue(lattice, bodies, space, PrescribedMotion(space, []))


@pytest.mark.parametrize(("rows", "cols"), [(1, 2), (2, 2)])
def test_no_cut_through_a_free_cluster_carries_a_force(rows, cols):
    tissue = free_cluster(rows, cols)
    loads = AppliedLoads(tissue.space, [Pressure(boundary="lumen", value=PRESSURE)], tissue.motion)
    terms, contact = fused([tissue.bulk, loads]), ContactTerm(tissue.contact)
    apart, touching = (Problem(tissue.space, (*terms, *more), tissue.motion.fixed) for more in ((), (contact,)))
    path = Continuation(LAW.shear_modulus)
    released = Released(tissue.minimiser(apart), (tissue.minimiser(touching),), path)
    (step,) = single_step(released, tissue.motion, steps=[1.0])
    state = step.minimum.state
    forces = contact_forces(touching, state)
    scale = PRESSURE * 1.0  # of a wall between cells that are held together
    bodies = range(rows * cols)
    for side in chain.from_iterable(combinations(bodies, count) for count in range(1, rows * cols)):
        crossing = np.isin(forces.bodies, side).sum(1) == 1
        towards = np.where(np.isin(forces.bodies[:, 0], side), 1.0, -1.0)
        across = (towards[:, None] * forces.force)[crossing].sum(0)
        assert np.linalg.norm(across) < 1e-4 * scale
    assert forces.total < 1e-3 * scale
    # Each wall rises: the cluster opens at the corners.
    gap = contact_set(touching, state).kinematics.gaps(state.positions)
    assert gap.max() > 1e-3
