"""Cohesion of a tissue: without strength it is unilateral contact, with endless strength one tied solid."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell import read_case
from ngcell.build.reported import Step
from ngcell.build.simulation import Simulation
from ngcell.solve.strategies import sddp

SMALL = ["load.levels=1", "mesh.order=2", "tissue.rows=2", "tissue.cols=2"]


def followed(*sets: str) -> list[Step]:
    return list(Simulation(read_case("shear-empty-3x3", [*SMALL, *sets, "accuracy=inf"])).accepted_steps())


def bonded(strength: float, *sets: str) -> list[Step]:
    """Bonds that are strongest at an opening of a tenth of the wall."""
    return followed(f"cohesion.strength={strength}", f"cohesion.energy={strength * 0.01 * np.e}", *sets)


def test_no_strength_is_unilateral_contact(monkeypatch):
    """Both are released from the tied state, which without bonds is not where the path begins."""
    monkeypatch.setattr(sddp, "_centres", lambda task, tied, load: [tied])
    free, loose = followed()[-1], bonded(1e-12)[-1]
    assert loose.record.energy == pytest.approx(free.record.energy, rel=1e-6)
    assert loose.record.plate_force_x == pytest.approx(free.record.plate_force_x, rel=1e-6)
    assert loose.record.parted_pairs == free.record.parted_pairs > 0
    np.testing.assert_allclose(loose.displacement, free.displacement, atol=1e-5)


@pytest.mark.parametrize("strategy", ["sddp", "load-stepping"])
def test_endless_strength_is_the_tied_solid(strategy):
    """Contact is stiffened along with the bonds: what presses is left to it."""
    away = []
    for strength, stiffness in ((1e2, 10.0), (1e3, 100.0)):
        sets = f"strategy.kind={strategy}", f"contact.stiffness={stiffness}"
        steps = bonded(strength, "load.displacement=[0.2, 0.0]", *sets)
        away.append(steps[-1].record.energy)
        assert steps[-1].record.bonded_share == 1
        assert steps[-1].record.parted_pairs == 0
    tied = followed("load.displacement=[0.2, 0.0]")[0].record
    assert tied.phase == "tied"
    missing = 1 - np.array(away) / tied.energy
    assert 0 < missing[1] < 0.2 * missing[0] < 1e-3
