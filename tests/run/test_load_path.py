"""A load that is taken back: there is no law of debonding, so what was loaded returns to rest, on the same path."""

from __future__ import annotations

import numpy as np
import pytest

import ngcell

TISSUE = ["tissue.rows=2", "tissue.cols=2", "mesh.order=2", "load.displacement=[0.6, 0.0]"]
THERE_AND_BACK = "[0.5, 1.0, 0.5, 0.0]"
CASES = {
    "sddp": ("shear-empty-3x3", [*TISSUE, f"load.levels={THERE_AND_BACK}"]),
    "single-step": ("shear-empty-3x3", [*TISSUE, f"load.levels={THERE_AND_BACK}", 'strategy.kind="single-step"']),
}


@pytest.mark.parametrize(("strategy", "contact"), [("sddp", "penalty"), ("single-step", "mortar")])
def test_a_tissue_returns_to_rest(strategy, contact):
    case, sets = CASES[strategy]
    steps = ngcell.simulate(ngcell.read_case(case, [*sets, f'contact.kind="{contact}"', "accuracy=inf"]))
    assert all(step.record.certified for step in steps)
    there, full, back, rest = (step.record for step in steps if step.record.phase == "released")
    assert full.energy > there.energy > 1e-4
    assert back.energy == pytest.approx(there.energy, rel=1e-8)
    assert back.plate_force_x == pytest.approx(there.plate_force_x, rel=1e-6)
    assert rest.energy <= 1e-12 * full.energy
    assert rest.largest_gap <= 1e-6
    assert np.abs(steps[-1].displacement).max() <= 1e-6


def test_a_follower_pressure_is_taken_back():
    case = ngcell.read_case("closing-rings", [f"levels={THERE_AND_BACK}", "expected=[]", "accuracy=inf"])
    steps = ngcell.simulate(case)
    assert all(step.record.certified for step in steps)
    there, full, back, rest = (step.record for step in steps)
    assert full.contact_force > 0 == rest.contact_force
    # The last proximal term, to what each step was foreseen to be, still holds a millionth.
    assert back.energy == pytest.approx(there.energy, rel=1e-5)
    assert rest.energy <= 1e-12 * full.energy
