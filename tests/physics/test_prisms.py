"""Prismatic cells: held along their axis they are planar ones, and between free ends they are softer."""

from __future__ import annotations

import pytest

from tests.prisms import SOFT, case, last_step

HEIGHT = 0.4


@pytest.mark.parametrize(
    "lumen", [None, {"kind": "pressure", "pressure": 0.01}, {"kind": "inclusion", "material": SOFT}], ids=str
)
def test_prisms_held_along_their_axis_are_planar_cells(lumen):
    planar = last_step(case(None, lumen=lumen))
    solid = last_step(case(HEIGHT, ends="held", lumen=lumen))
    assert planar.record.certified
    assert solid.record.certified
    for name in ("energy", "plate_force_x", "plate_force_y", "contact_force"):
        assert getattr(solid.record, name) == pytest.approx(HEIGHT * getattr(planar.record, name), rel=1e-8), name
    for name in ("largest_gap", "mean_gap", "opened_share"):
        assert getattr(solid.record, name) == pytest.approx(getattr(planar.record, name), rel=1e-6), name
    assert solid.record.plate_force_z == pytest.approx(0, abs=1e-12)


def test_prisms_between_free_ends_are_softer_and_certified():
    held, free = last_step(case(HEIGHT, ends="held")), last_step(case(HEIGHT))
    assert free.record.certified
    # Walls bend: of plane strain, 1 - nu^2 is left in plane stress, which the ends are in and the middle less so.
    poisson = (3 * 100 - 2 * 2) / (6 * 100 + 2 * 2)
    assert (1 - poisson**2) * held.record.energy < free.record.energy < held.record.energy
