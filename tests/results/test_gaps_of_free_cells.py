"""Gaps in the history: those between cells that something holds, and apart from them those of cells that nothing does.

Where a free cell lies is up to the proximal term that holds it still, and says nothing of the tissue.
"""

from __future__ import annotations

import pytest

import ngcell

PLAIN = ["load.levels=1", "mesh.order=2", "accuracy=inf"]
SCENES = {
    "sheared": ("shear-empty-3x3", PLAIN),
    "halves of prisms, which supports hold along their axes": (
        "shear-empty-3x3",
        [*PLAIN, "tissue.height=0.4", 'load.ends="mirrored"', "mesh.slices=1", "mesh.layers=1"],
    ),
    "a row between two that are pulled apart": ("stretch-plates", [*PLAIN, "tissue.rows=3", "tissue.cols=2"]),
}


@pytest.mark.parametrize("scene", SCENES)
def test_walls_of_free_cells_are_counted_apart(scene: str):
    *_, step = ngcell.simulate(ngcell.read_case(*SCENES[scene]))
    free, record = set(step.measurement.free_bodies), step.record
    of_free = [wall for wall in step.walls if {wall.cell_a, wall.cell_b} & free]
    held = [wall for wall in step.walls if not {wall.cell_a, wall.cell_b} & free]
    assert of_free and held
    assert record.largest_gap == max(wall.largest_gap for wall in held)
    assert record.free_largest_gap == max(wall.largest_gap for wall in of_free) > record.largest_gap
    # Walls of all cells are equally long.
    assert record.mean_gap == pytest.approx(sum(wall.mean_gap for wall in held) / len(held), rel=1e-9)
    assert record.free_mean_gap == pytest.approx(sum(wall.mean_gap for wall in of_free) / len(of_free), rel=1e-9)
