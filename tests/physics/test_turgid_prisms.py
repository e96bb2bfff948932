"""Closed prisms full of a fluid: volumes hold, and the pressure found is one that does the same."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.build.simulation import Simulation
from ngcell.mechanics.fluid import LumenFluids
from tests.prisms import case, last_step

TISSUE = {"rows": 1, "cols": 1, "wall": 0.2, "height": 0.8, "end_wall": 0.1}
MESH = {"order": 2, "size": 1.0, "slices": 1}


@pytest.mark.parametrize(
    ("fill", "load"),
    [(1.0, {"displacement": (0.0, 0.0, -0.05)}), (1.1, {"twist": 20.0})],
    ids=["pressed", "twisted and turgid"],
)
def test_a_fluid_keeps_its_volume_and_does_what_its_pressure_does(fill, load):
    parts = {"tissue": TISSUE, "mesh": MESH, "load": {"kind": "ends", "levels": 1} | load}
    scene = case(0.8, lumen={"kind": "fluid", "fill": fill}, **parts)
    simulation = Simulation(scene)
    full = list(simulation.accepted_steps())[-1]
    assert full.record.certified
    (fluid,) = (term for term in simulation.problem.terms if isinstance(term, LumenFluids))
    np.testing.assert_allclose(fluid.areas(full.displacement), fill * fluid.area, rtol=1e-8)
    (pressure,) = (cell.pressure for cell in full.cells)
    assert pressure > 0.05
    pressed = last_step(case(0.8, lumen={"kind": "pressure", "pressure": pressure}, **parts))
    for name in ("energy", "plate_force_z"):
        assert getattr(full.record, name) == pytest.approx(getattr(pressed.record, name), rel=1e-6), name
    np.testing.assert_allclose(full.displacement, pressed.displacement, atol=1e-7)
    empty = last_step(case(0.8, **parts))
    assert full.record.energy > 1.05 * empty.record.energy


def test_layers_of_turgid_cells_press_on_each_other():
    """Two equal layers have one pressure, and the force between them is that on the ends."""
    tissue = TISSUE | {"height": 0.5, "layers": 2}
    load, mesh = {"kind": "ends", "displacement": (0, 0, -0.03), "levels": 1}, MESH | {"order": 1}
    step = last_step(case(0.5, lumen={"kind": "fluid"}, tissue=tissue, mesh=mesh, load=load))
    assert step.record.certified
    lower, upper = (cell.pressure for cell in step.cells)
    assert lower == pytest.approx(upper, rel=1e-6)
    assert step.record.contact_force == pytest.approx(-step.record.plate_force_z, rel=1e-6)
