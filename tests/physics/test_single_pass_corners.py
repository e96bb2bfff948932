"""Corners that are integrated in a single pass slide farther, to the energies of the mortar."""

from __future__ import annotations

import pytest

from ngcell import read_case, simulate


def energy_of(*changes: str) -> float:
    given = ("tissue.rows=4", "tissue.cols=4", "load.displacement=[0.8, 0.0]", "load.levels=1", "expected=[]")
    *_, step = simulate(read_case("shear-empty", [*given, *changes]))
    assert step.record.certified
    return step.record.energy


def test_sheared_cells_come_to_the_energy_that_the_mortar_finds():
    both, single = (energy_of(f"contact.single_pass_corners={value}") for value in ("false", "true"))
    mortar = energy_of('contact.kind="mortar"')
    assert single == pytest.approx(mortar, rel=2e-3)
    assert single < both * (1 + 1e-3)
