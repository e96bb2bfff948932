"""The mortar method in three dimensions: a uniform pressure shows no mesh, prisms held along z are planar cells."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.scene import Mortar
from tests.physics.test_stacked_solids import C1, C2, STRETCH, pressed
from tests.prisms import case, last_step

HEIGHT = 0.6


@pytest.mark.parametrize(("sizes", "order"), [((0.4, 0.6), 1), ((0.7, 1.0), 2)])
def test_pressure_between_meshes_that_do_not_match_is_uniform(sizes, order):
    """K1; the bulk modulus is a thousand times the shear modulus."""
    step = pressed(sizes, order, Mortar())
    assert step.record.certified
    exact = -(C1 + C2 / STRETCH) * (STRETCH**2 - 1 / STRETCH)
    pressure = step.snapshot.walls.point_data["contact_pressure"]
    assert np.ptp(pressure) < 1e-8 * exact
    assert pressure.mean() == pytest.approx(exact, rel=5e-4)
    stress = step.snapshot.bulk.point_data["cauchy_stress"]
    np.testing.assert_allclose(stress, np.diag([0, 0, -pressure.mean()]).ravel() + 0 * stress, atol=1e-8)


@pytest.mark.parametrize("rows", [1, 2])
def test_prisms_held_along_their_axis_are_planar_cells(rows):
    tissue = {"rows": rows, "cols": 2, "wall": 0.1}
    mesh, contact = {"order": 2, "size": 0.5}, {"kind": "mortar"}
    planar = last_step(case(None, tissue=tissue, mesh=mesh, contact=contact)).record
    prisms = {"tissue": tissue | {"height": HEIGHT}, "mesh": mesh | {"slices": 1}}
    solid = last_step(case(HEIGHT, **prisms, ends="held", contact=contact)).record
    assert planar.certified
    assert solid.certified
    for name in ("energy", "plate_force_x", "plate_force_y", "contact_force"):
        assert getattr(solid, name) == pytest.approx(HEIGHT * getattr(planar, name), rel=1e-6), name
    for name in ("largest_gap", "mean_gap"):
        assert getattr(solid, name) == pytest.approx(getattr(planar, name), rel=1e-6), name
