"""Closed prisms full of a solid: bonded to side walls and end walls alike."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from ngcell.build.simulation import Simulation
from ngcell.mechanics.term import Role
from tests.physics.test_pressed_ends import nominal_stress
from tests.prisms import MATERIAL, SOFT, case, last_step

HEIGHT = 0.8
TISSUE = {"rows": 1, "cols": 1, "wall": 0.2, "height": HEIGHT, "end_wall": 0.1}
MESH = {"order": 2, "size": 1.0, "slices": 1}
HEXAGON = 1.5 * np.sqrt(3)


def filled(displacement, material, **parts):
    load = {"kind": "ends", "displacement": displacement, "levels": 1}
    lumen = material and {"kind": "inclusion", "material": material}
    return case(HEIGHT, load=load, lumen=lumen, mesh=MESH, **({"tissue": TISSUE} | parts))


@pytest.mark.parametrize("along", [0.8, 1.3])
def test_a_cell_full_of_what_its_wall_is_made_of_is_a_solid_block(along):
    """In uniaxial stress it is in balance everywhere but at its ends, which bear the force of the closed form."""
    simulation = Simulation(filled((0, 0, 0), MATERIAL))
    space = simulation.space
    across = brentq(lambda width: nominal_stress(along, width)[1], 0.5, 2.0, xtol=1e-15, rtol=1e-14)
    at = space.affine(np.diag([across, across, along]) - np.eye(3), np.zeros(3)).ravel()
    force = simulation.problem.force(space.configuration(at), Role.INTERNAL).reshape(3, -1)
    scale = np.abs(force).max()
    np.testing.assert_allclose(force[:2], 0, atol=1e-10 * scale)
    ends = {name: space.region_unknowns(name) for name in ("upper-end", "lower-end")}
    inside = np.setdiff1d(np.arange(space.size), np.concatenate(list(ends.values())))
    np.testing.assert_allclose(force[2, inside], 0, atol=1e-10 * scale)
    borne = (force[2] * space.one)[ends["upper-end"]].sum()
    assert borne == pytest.approx(nominal_stress(along, across)[0] * HEXAGON, rel=1e-10)


def test_a_pressed_block_is_as_stiff_as_bounds_allow():
    """Ends that cannot widen: stiffer than a bar with free sides, softer than one whose sides are held."""
    small = 1e-4
    step = last_step(filled((0, 0, -small), MATERIAL))
    assert step.record.certified
    shear, bulk = 2.0, 100.0
    young, confined = 9 * bulk * shear / (3 * bulk + shear), bulk + 4 * shear / 3
    stiffness = -step.record.plate_force_z / small * HEIGHT / HEXAGON
    assert young < stiffness < confined
    assert step.record.energy == pytest.approx(-step.record.plate_force_z * small / 2, rel=1e-3)


def test_what_fills_a_closed_cell_bears_a_part_of_the_load():
    full, empty = last_step(filled((0, 0, -0.05), SOFT)), last_step(filled((0, 0, -0.05), None))
    assert full.record.certified
    assert full.record.plate_force_z < 1.02 * empty.record.plate_force_z < 0
    (cell,) = full.cells
    assert cell.pressure > 0
