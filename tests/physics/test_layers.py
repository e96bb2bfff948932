"""Layers of prisms: one on the other they bear what a single tall prism bears, and pulled they part."""

from __future__ import annotations

import numpy as np
import pytest

from ngcell.build.simulation import Simulation
from tests.prisms import SOFT, case, last_step

HEIGHT = 0.5
CLOSED = {"end_wall": 0.1}


def stack(layers, displacement, *, height=HEIGHT, slices=1, cells=1, tissue=None, order=1, **parts):
    """Cells in layers, whose ends are moved."""
    return case(
        height,
        tissue={"rows": 1, "cols": cells, "wall": 0.2, "height": height, "layers": layers} | (tissue or {}),
        load={"kind": "ends", "displacement": displacement, "levels": 1},
        mesh={"order": order, "size": 1.0, "slices": slices},
        **parts,
    )


def steps(scene):
    return {step.record.phase: step for step in Simulation(scene).accepted_steps()}


@pytest.mark.parametrize(
    ("lumen", "order"), [(None, 2), ({"kind": "inclusion", "material": SOFT}, 1)], ids=["hollow", "filled"]
)
def test_two_layers_pressed_bear_what_a_prism_of_twice_the_height_bears(lumen, order):
    """Between them, where by symmetry nothing slides, is a plane of symmetry of the tall prism."""
    tall = steps(stack(1, (0, 0, -0.05), height=2 * HEIGHT, slices=2, lumen=lumen, order=order))["released"]
    found = steps(stack(2, (0, 0, -0.05), lumen=lumen, order=order))
    assert found["tied"].record.energy == pytest.approx(tall.record.energy, rel=1e-9)
    assert found["tied"].record.plate_force_z == pytest.approx(tall.record.plate_force_z, rel=1e-8)
    step = found["released"]
    assert step.record.certified
    assert step.record.parted_pairs == 0
    # Penalty terms between the layers give way by a length that is that of gaps, in proportion to the shortening.
    for name in ("energy", "plate_force_z", "contact_force"):
        meant = getattr(tall.record, name) if name != "contact_force" else -tall.record.plate_force_z
        assert getattr(step.record, name) == pytest.approx(meant, rel=2 * -step.record.smallest_gap / 0.05), name
    assert step.measurement.plate_force[:2] == pytest.approx(0, abs=1e-9)
    (row,) = step.walls
    assert (row.cell_a, row.cell_b) == (0, 1)
    assert row.force == pytest.approx(-step.record.plate_force_z, rel=1e-9)


@pytest.mark.parametrize("tissue", [{}, CLOSED], ids=["hollow", "closed"])
def test_two_layers_pulled_part_and_bear_nothing(tissue):
    found = steps(stack(2, (0, 0, 0.1), tissue=tissue))
    assert found["tied"].record.plate_force_z > 0.5
    step = found["released"]
    assert step.record.certified
    assert step.record.energy < 1e-12
    assert abs(step.record.plate_force_z) < 1e-8
    (row,) = step.walls
    assert row.parted and row.mean_gap == pytest.approx(0.1, rel=1e-6)
    assert [cell.component for cell in step.cells] == [0, 1]


def test_layers_slide_on_each_other():
    """Without friction a sheared stack has next to nothing to hold against, and corners do not sink in."""
    found = steps(stack(2, (0.2, 0, -0.01), tissue=CLOSED))
    assert found["tied"].record.plate_force_x > 0.1
    step = found["released"]
    assert step.record.certified
    assert abs(step.record.plate_force_x) < 0.02 * found["tied"].record.plate_force_x
    assert step.record.contact_force == pytest.approx(-step.record.plate_force_z, rel=0.01)


def test_moving_the_whole_stack_moves_the_answer():
    simulation = Simulation(stack(2, (0, 0, -0.05), tissue=CLOSED, cells=2))
    problem, space = simulation.problem, simulation.space
    translation = np.array([0.3, -2.0, 5.0])
    at = space.affine(np.diag([0.01, -0.02, -0.04]), np.zeros(3)).ravel()
    there = at + space.affine(np.zeros((3, 3)), translation).ravel()
    one, two = problem.at(at), problem.at(there)
    assert two.energy == pytest.approx(one.energy, rel=1e-9)
    np.testing.assert_allclose(problem.gradient(two), problem.gradient(one), atol=1e-9 * np.abs(one.energy))


def test_each_layer_has_its_own_pressures_and_its_load_passes_through_all():
    lumen, strategy = {"kind": "pressure", "pressure": [[0.05], [0.02]]}, {"kind": "single-step"}
    pressed = stack(2, (0, 0, -0.02), tissue=CLOSED, lumen=lumen, strategy=strategy)
    step = last_step(pressed)
    assert step.record.certified
    assert [cell.pressure for cell in step.cells] == [0.05, 0.02]
    assert step.record.contact_force == pytest.approx(-step.record.plate_force_z, rel=1e-8)


def test_ends_that_are_held_are_those_of_the_whole_stack():
    """Where layers meet, nothing is held."""
    motion = {"kind": "frame", "shear": 0.1, "ends": "held", "levels": 1}
    scene = stack(2, (0, 0, 0)).model_copy(update={"load": case(HEIGHT, load=motion).load})
    simulation = Simulation(scene)
    held = simulation.motion.fixed[2] & ~simulation.motion.fixed[0]
    height = simulation.space.rest[2, held]
    assert held.any()
    assert set(np.unique(height.round(12)[simulation.space.one[held] > 0])) == {0.0, 2 * HEIGHT}
