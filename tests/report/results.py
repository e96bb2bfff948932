"""Result folders made by hand: two rings that are moved apart, in the plane, and two blocks of hexahedra."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from ngcell.export import ResultFolder
from ngcell.results.record import CellRecord, StepRecord, WallRecord
from ngcell.results.snapshot import Grid, Snapshot
from tests.export.conftest import facing_walls, ring_bodies

CASE = """title = "Two rings"
source = "Made by hand."
accuracy = 0.01

[tissue]
kind = "honeycomb"
rows = 1

[load]
levels = {levels}
"""
#: Largest gaps of the rows of walls: by their digits they would stand in another order.
GAPS = (2.0, 10.0, 0.5)
#: Corners, edges and faces of VTK's triquadratic hexahedron, as places in a lattice of 3 x 3 x 3.
_CORNERS = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
_FACES = [(0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2), (1, 1, 1)]


def hexahedron_nodes() -> np.ndarray:
    """Return the 27 nodes of the unit cube in VTK's order, shape (27, 3)."""
    corners = np.array(_CORNERS, dtype=float)
    edges = [(corners[a] + corners[b]) / 2 for a, b in _EDGES]
    return np.vstack([corners, edges, np.array(_FACES, dtype=float)]) / 2


def blocks(apart: float) -> Grid:
    """Return two cells of 2 x 1 x 1 elements each, above one another, no node shared; the upper one is moved up."""
    places = [np.array(place, dtype=float) for place in product((0, 1), (0,), (0, 1))]
    points = np.vstack([hexahedron_nodes() + place for place in places])
    owner = np.array([int(place[2]) for place in places])
    displacement = np.zeros_like(points)
    displacement[np.repeat(owner, 27) == 1, 2] = apart
    data = {
        "displacement": displacement,
        "von_mises": points[:, 0],
        "cauchy_stress": np.ones((len(points), 9)),
    }
    cells = np.arange(len(points)).reshape(-1, 27)
    return Grid(points, cells, 29, data, {"cell_id": owner, "free": owner})


def block_walls(apart: float) -> Grid:
    """Return the two coincident walls between the blocks, as biquadratic quadrilaterals."""
    upper = hexahedron_nodes()[[0, 1, 2, 3, 8, 9, 10, 11, 24]]
    points = np.vstack([upper + [0, 0, 1], upper + [0, 0, 1]])
    displacement = np.zeros_like(points)
    displacement[9:, 2] = apart
    data = {"displacement": displacement, "gap": np.full(18, apart), "contact_pressure": np.full(18, np.nan)}
    return Grid(points, np.arange(18).reshape(2, 9), 28, data, {"cell_id": np.array([0, 1])})


def snapshot(step: int, *, solid: bool = False, rigid: bool = False) -> Snapshot:
    """Return a step; where asked for, the body that is moved is rigid."""
    apart = 0.1 * (step + 1)
    bodies, walls = (blocks, block_walls) if solid else (ring_bodies, facing_walls)
    bulk = bodies(apart)
    if rigid:
        owner = bulk.cell_data["cell_id"]
        bulk = replace(bulk, cell_data={"cell_id": owner, "free": 0 * owner, "rigid": owner})
    return Snapshot(step, apart, apart, bulk, walls(apart))


def record(step: int, *, certified: bool = True) -> StepRecord:
    gap = 0.1 * (step + 1)
    return StepRecord(
        step=step, phase="released", load_factor=gap, plate_displacement=gap, largest_gap=gap, mean_gap=gap / 3,
        smallest_gap=0.0, parted_pairs=step, opened_share=0.5, components=1 + step, largest_component=2,
        plate_force_x=gap, plate_force_y=0.0, contact_force=0.1, energy=gap**2, iterations=7, factorisations=8,
        seconds=0.1, certified=certified, energy_error=0.1 * gap**2,
    )  # fmt: skip


def write_run(
    folder: Path,
    *,
    levels: int = 3,
    certified: bool = True,
    ends: bool = True,
    solid: bool = False,
    rigid: bool = False,
    title: str = "",
) -> Path:
    """Write the result of a run of as many levels; where it is not certified, the last one is what fails."""
    with ResultFolder(folder, case_text=CASE.format(levels=levels)) as result:
        for step in range(levels):
            passed = certified or step < levels - 1
            walls = [WallRecord(step, 0.1 * (step + 1), 0, 1, gap, 0.05, 0.0, 1.0, True, 0, np.nan) for gap in GAPS]
            cells = [CellRecord(step, 0.1 * (step + 1), 0.1, cell, 0.5 - cell, 0, 2, cell == 0) for cell in range(2)]
            result.accept(record(step, certified=passed), walls, snapshot(step, solid=solid, rigid=rigid), cells)
        if ends:
            result.finish(summary(levels, certified) | ({"title": title} if title else {}))
    return folder


def summary(levels: int, certified: bool) -> dict[str, Any]:
    last = record(levels - 1)
    fields = {name: getattr(last, name) for name in StepRecord.__dataclass_fields__ if name != "more"}
    return {
        "title": "Two rings <come apart>",
        "outcome": "converged and certified" if certified else "converged, but a check of the certificate failed",
        "certified": certified,
        "accepted_steps": levels,
        "certificate": {
            "residual": {"worst": 1e-9 if certified else 0.5, "limit": 1e-6, "passed": certified},
            "tension": {"worst": 0.0, "limit": 0.0, "passed": True},
        },
        "meaning_of_checks": {"residual": "forces out of balance", "tension": "tensile pressure"},
        "failed_steps": {} if certified else {levels - 1: ["residual"]},
        "bodies": 2,
        "facing_pairs": 1,
        "debonding": {"wall_pairs_opened": 1, "wall_pairs_parted": 1, "component_sizes": [1, 1]},
        "last_step": fields,
        "versions": {"ngcell": "9.9.9"},
    }
